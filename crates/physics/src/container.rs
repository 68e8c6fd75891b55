//! The container as boxes: a floor and four walls around the inner volume.

use ppnpack_catalogue::mesh::{Bounds, Mesh};

use crate::settings::CellSettings;

/// The floor and the walls, in the container frame.
///
/// The walls along y stand between those along x, so that no two boxes overlap.
pub(crate) fn boxes(settings: &CellSettings) -> [Bounds; 5] {
    let size = settings.container;
    let wall_m = settings.walls.thickness_m;
    let solid = |lowest: [f64; 3], highest: [f64; 3]| Bounds {
        lowest: lowest.into(),
        highest: highest.into(),
    };
    let (x, y, z) = (size.x_m, size.y_m, size.z_m);
    let floor_m = settings.walls.floor_thickness_m;
    [
        solid([-wall_m, -wall_m, -floor_m], [x + wall_m, y + wall_m, 0.0]),
        solid([-wall_m, -wall_m, 0.0], [0.0, y + wall_m, z]),
        solid([x, -wall_m, 0.0], [x + wall_m, y + wall_m, z]),
        solid([0.0, -wall_m, 0.0], [x, 0.0, z]),
        solid([0.0, y, 0.0], [x, y + wall_m, z]),
    ]
}

/// The container's surface, in the container frame.
pub(crate) fn mesh(settings: &CellSettings) -> Mesh {
    let mut mesh = Mesh::default();
    for solid in boxes(settings) {
        mesh.append(&solid.mesh());
    }
    mesh
}
