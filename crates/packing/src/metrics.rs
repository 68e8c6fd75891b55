//! What an episode achieved.

use serde::{Deserialize, Serialize};

use crate::grid::Grid;
use crate::heightmap::Heightmap;

/// The volume of the items that ended inside the container.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct PackedVolume {
    /// How many items.
    pub items: usize,
    /// Their voxels, in cubic metres: what the paper reports. Coarser grids inflate it more.
    pub voxels_m3: f64,
    /// The volume of their meshes, in cubic metres: what compares across grids.
    pub meshes_m3: f64,
}

/// How well a container is filled.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Metrics {
    /// What is inside.
    pub packed: PackedVolume,
    /// Voxel volume over the volume up to the greatest height of the content, 0 to 1.
    pub compactness: f64,
    /// The same with the meshes' volume.
    pub mesh_compactness: f64,
    /// Mesh volume over that of the whole container, 0 to 1.
    pub utilisation: f64,
}

impl Metrics {
    /// The metrics of a container with this heightmap and content.
    pub fn new(grid: &Grid, heightmap: &Heightmap, packed: PackedVolume) -> Self {
        let container = grid.container();
        let floor_m2 = container.x_m * container.y_m;
        let height_m = f64::from(heightmap.max()) * grid.resolution().height_unit_m();
        let share = |volume_m3: f64, of_m3: f64| if of_m3 > 0.0 { volume_m3 / of_m3 } else { 0.0 };
        Self {
            packed,
            compactness: share(packed.voxels_m3, floor_m2 * height_m),
            mesh_compactness: share(packed.meshes_m3, floor_m2 * height_m),
            utilisation: share(packed.meshes_m3, floor_m2 * container.z_m),
        }
    }
}
