//! What is published of a cell.

use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::Scene;
use ppnpack_service::ServiceError;
use ppnpack_service::process::Process;
use ppnpack_service::stream::Publisher;
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::{debug, v1};

/// Publishes the heightmaps of a cell.
pub(crate) struct Streams {
    cell: Cell,
    heightmaps: Publisher<v1::Heightmap>,
    debug_heightmaps: Option<Publisher<debug::Grid>>,
}

impl Streams {
    pub(crate) fn new(
        process: &Process,
        cell: &Cell,
        has_debug_streams: bool,
    ) -> Result<Self, ServiceError> {
        let debug_heightmaps =
            has_debug_streams.then(|| Publisher::new(process, cell, Stream::DebugHeightmap));
        Ok(Self {
            cell: cell.clone(),
            heightmaps: Publisher::new(process, cell, Stream::Heightmap)?,
            debug_heightmaps: debug_heightmaps.transpose()?,
        })
    }

    /// Publishes a heightmap. Nothing depends on it: heightmaps can be asked for.
    pub(crate) fn tell(&self, heightmap: &v1::Heightmap, grid: &Grid, scene: &Scene) {
        if let Err(error) = self.try_tell(heightmap, grid, scene) {
            tracing::warn!(cell = %self.cell, %error, "heightmap not published");
        }
    }

    fn try_tell(
        &self,
        heightmap: &v1::Heightmap,
        grid: &Grid,
        scene: &Scene,
    ) -> Result<(), ServiceError> {
        self.heightmaps.put(heightmap)?;
        let Some(publisher) = &self.debug_heightmaps else {
            return Ok(());
        };
        let at_ns = heightmap.captured_at_ns;
        publisher.put(&debug::heightmap(
            &self.cell,
            at_ns,
            grid,
            scene.heightmap(),
        ))
    }
}
