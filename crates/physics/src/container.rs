//! The container as convex solids: a floor, walls around the inside, and what is taken of that.

use nalgebra::Point3;
use ppnpack_catalogue::mesh::{Bounds, Mesh};

use crate::settings::{CellSettings, TakenBox};

/// The floor, what is taken, and of a box the walls, in the container frame.
///
/// The walls along y stand between those along x, so that no two of them overlap.
pub(crate) fn boxes(settings: &CellSettings) -> Vec<Bounds> {
    let size = settings.container;
    let wall_m = settings.walls.thickness_m;
    let solid = |lowest: [f64; 3], highest: [f64; 3]| Bounds {
        lowest: lowest.into(),
        highest: highest.into(),
    };
    let (x, y, z) = (size.x_m, size.y_m, size.z_m);
    let floor_m = settings.walls.floor_thickness_m;
    let floor = solid([-wall_m, -wall_m, -floor_m], [x + wall_m, y + wall_m, 0.0]);
    let taken = settings.taken.iter().map(TakenBox::bounds);
    let fixed = std::iter::once(floor).chain(taken);
    if !size.is_box() {
        return fixed.collect();
    }
    let walls = [
        solid([-wall_m, -wall_m, 0.0], [0.0, y + wall_m, z]),
        solid([x, -wall_m, 0.0], [x + wall_m, y + wall_m, z]),
        solid([0.0, -wall_m, 0.0], [x, 0.0, z]),
        solid([0.0, y, 0.0], [x, y + wall_m, z]),
    ];
    fixed.chain(walls).collect()
}

/// The walls of a container that is no box, as convex pieces of eight corners: upright outside,
/// leaning inside, where the wall is as thick as is set at the rim.
pub(crate) fn leaning_walls(settings: &CellSettings) -> Vec<Mesh> {
    let size = settings.container;
    if size.is_box() {
        return Vec::new();
    }
    let ring = |setback_m: f64, z_m: f64| {
        let corners = size.outline_m(setback_m);
        corners.map(move |corner| Point3::new(corner.x, corner.y, z_m))
    };
    let outside_m = -settings.walls.thickness_m;
    let low = ring(outside_m, 0.0).zip(ring(size.setback_m(0.0), 0.0));
    let high = ring(outside_m, size.z_m).zip(ring(0.0, size.z_m));
    let corners: Vec<_> = low.zip(high).collect();
    let triangles = Mesh::cuboid([0.0; 3], [1.0; 3]).triangles;
    let further = corners.iter().cycle().skip(1);
    let pieces = corners.iter().zip(further).map(|(one, next)| {
        let ((one_low, one_high), (next_low, next_high)) = (one, next);
        let level = |one: &(Point3<f64>, Point3<f64>), next: &(Point3<f64>, Point3<f64>)| {
            [one.0, next.0, one.1, next.1]
        };
        Mesh {
            vertices: [level(one_low, next_low), level(one_high, next_high)].concat(),
            triangles: triangles.clone(),
        }
    });
    pieces.collect()
}

/// The container's surface, in the container frame.
pub(crate) fn mesh(settings: &CellSettings) -> Mesh {
    let mut mesh = Mesh::default();
    let boxes = boxes(settings).into_iter().map(|solid| solid.mesh());
    for solid in boxes.chain(leaning_walls(settings)) {
        mesh.append(&solid);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use ppnpack_packing::kernel::grid::ContainerSize;

    use super::*;

    #[test]
    fn walls_fill_what_is_between_the_inside_and_the_outside() {
        let size = ContainerSize {
            draft_rad: 0.1_f64.atan(),
            ..ContainerSize::cuboid(0.4, 0.3, 0.2)
        };
        let mut settings = CellSettings {
            container: size,
            ..CellSettings::default()
        };
        let wall_m = settings.walls.thickness_m;
        let outside_m3 = (0.4 + 2.0 * wall_m) * (0.3 + 2.0 * wall_m) * 0.2;
        let volume_m3 = |settings: &CellSettings| {
            let pieces = leaning_walls(settings);
            pieces.iter().map(Mesh::signed_volume_m3).sum::<f64>()
        };
        let expected = outside_m3 - size.volume_m3();
        assert!((volume_m3(&settings) / expected - 1.0).abs() < 1e-6);
        settings.container.corner_radius_m = 0.03;
        assert_eq!(leaning_walls(&settings).len(), 24);
        // Outside the corners are as round as inside.
        assert!((volume_m3(&settings) / expected - 1.0).abs() < 0.01);
        settings.container = ContainerSize::REFERENCE;
        assert!(leaning_walls(&settings).is_empty());
        assert_eq!(boxes(&settings).len(), 5);
    }
}
