//! The container as boxes: a floor and four walls around the inner volume.

use nalgebra::Point3;
use ppnpack_catalogue::mesh::Mesh;

use crate::settings::CellSettings;

/// The lowest and highest corners of the floor and the walls, in the container frame.
///
/// The walls along y stand between those along x, so that no two boxes overlap.
pub(crate) fn boxes(settings: &CellSettings) -> [[Point3<f64>; 2]; 5] {
    let size = settings.container;
    let wall_m = settings.walls.thickness_m;
    let corners = |lowest: [f64; 3], highest: [f64; 3]| [lowest.into(), highest.into()];
    let (x, y, z) = (size.x_m, size.y_m, size.z_m);
    let floor_m = settings.walls.floor_thickness_m;
    [
        corners([-wall_m, -wall_m, -floor_m], [x + wall_m, y + wall_m, 0.0]),
        corners([-wall_m, -wall_m, 0.0], [0.0, y + wall_m, z]),
        corners([x, -wall_m, 0.0], [x + wall_m, y + wall_m, z]),
        corners([0.0, -wall_m, 0.0], [x, 0.0, z]),
        corners([0.0, y, 0.0], [x, y + wall_m, z]),
    ]
}

/// The container's surface, in the container frame.
pub(crate) fn mesh(settings: &CellSettings) -> Mesh {
    /// Faces of a box by its corners, numbered by the bits x, y, z; counter-clockwise seen from outside.
    const TRIANGLES: [[u32; 3]; 12] = [
        [0, 2, 1],
        [1, 2, 3],
        [4, 5, 6],
        [5, 7, 6],
        [0, 1, 4],
        [1, 5, 4],
        [2, 6, 3],
        [3, 6, 7],
        [0, 4, 2],
        [2, 4, 6],
        [1, 3, 5],
        [3, 7, 5],
    ];
    let mut mesh = Mesh::default();
    for [lowest, highest] in boxes(settings) {
        let first = mesh.vertices.len() as u32;
        for corner in 0..8_u32 {
            let side = |axis: u32, low: f64, high: f64| {
                if corner >> axis & 1 == 1 { high } else { low }
            };
            mesh.vertices.push(Point3::new(
                side(0, lowest.x, highest.x),
                side(1, lowest.y, highest.y),
                side(2, lowest.z, highest.z),
            ));
        }
        mesh.triangles
            .extend(TRIANGLES.map(|triangle| triangle.map(|corner| first + corner)));
    }
    mesh
}
