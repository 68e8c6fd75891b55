//! The content's surface seen from above, computed anew only where bodies moved.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::Isometry3;
use ppnpack_catalogue::object::Model;
use ppnpack_catalogue::raster::raise_surface;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::heightmap::Surface;

use crate::outcome::{BodyId, BodyState};

/// The last scan, kept for the bodies that have not moved since.
#[derive(Clone, Default)]
pub(crate) struct SurfaceCache {
    scanned: Option<Grid>,
    bodies: BTreeMap<BodyId, Scanned>,
}

/// A body as it was scanned last.
#[derive(Clone)]
struct Scanned {
    /// Bodies are renumbered when a cell is emptied, so the number alone does not tell the model.
    model: Arc<Model>,
    container_from_item: Isometry3<f64>,
    /// `None` where it had moved: most that have will have moved again by the next scan.
    patch: Option<Arc<Patch>>,
}

/// The surface of one body in one pose: each sample that it covers, along x and y, and its height.
type Patch = Vec<(usize, usize, f32)>;

impl SurfaceCache {
    /// Gives the surface of the bodies together, in the container.
    pub(crate) fn scan(&mut self, grid: &Grid, bodies: &[BodyState]) -> Surface {
        if self.scanned.as_ref() != Some(grid) {
            self.scanned = Some(grid.clone());
            self.bodies.clear();
        }
        let before = std::mem::take(&mut self.bodies);
        let mut surface = Surface::empty(grid);
        let mut moved: Vec<&BodyState> = Vec::new();
        for body in bodies {
            let known = before.get(&body.id).filter(|scanned| scanned.shows(body));
            let patch = known.map(|scanned| scanned.patch(grid));
            match &patch {
                Some(patch) => {
                    for (x, y, height_m) in patch.iter() {
                        surface.raise(*x, *y, *height_m);
                    }
                }
                None => moved.push(body),
            }
            let scanned = Scanned {
                model: Arc::clone(&body.model),
                container_from_item: body.container_from_item,
                patch,
            };
            self.bodies.insert(body.id, scanned);
        }
        // From the top, as what is covered is not drawn.
        let height_m = |body: &BodyState| body.container_from_item.translation.z;
        moved.sort_by(|one, other| height_m(other).total_cmp(&height_m(one)));
        for body in moved {
            let pose = &body.container_from_item;
            raise_surface(&body.model.mesh, pose, &mut surface);
        }
        surface
    }
}

impl Scanned {
    fn shows(&self, body: &BodyState) -> bool {
        Arc::ptr_eq(&self.model, &body.model)
            && self.container_from_item == body.container_from_item
    }

    fn patch(&self, grid: &Grid) -> Arc<Patch> {
        self.patch.clone().unwrap_or_else(|| {
            let mut alone = Surface::flat(grid);
            raise_surface(&self.model.mesh, &self.container_from_item, &mut alone);
            let samples = alone.heights_m().iter().copied().enumerate();
            let covered = samples.filter(|(_, height_m)| *height_m > 0.0);
            let ny = alone.ny();
            Arc::new(
                covered
                    .map(|(at, height_m)| (at / ny, at % ny, height_m))
                    .collect(),
            )
        })
    }
}
