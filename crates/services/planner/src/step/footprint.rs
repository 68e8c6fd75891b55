//! The floor that is below a packed item.

use nalgebra::{Isometry3, Point3, Vector3};
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::item::ItemView;
use ppnpack_packing::kernel::placement::RestingPlacement;
use ppnpack_packing::scene::blocked::BlockedRegion;

/// Gives the floor below a packed item where it is now: the box that it was planned in, moved and
/// turned with it, and grown by a cell. `moved` is the motion from the planned place.
pub(super) fn footprint(
    placement: &RestingPlacement,
    view: &ItemView,
    grid: &Grid,
    moved: &Isometry3<f64>,
) -> BlockedRegion {
    let resolution = grid.resolution();
    let cell_m = resolution.cell_m();
    let unit_m = resolution.height_unit_m();
    let half_m = Vector3::new(
        view.nx() as f64 * cell_m,
        view.ny() as f64 * cell_m,
        f64::from(view.height()) * unit_m,
    ) / 2.0;
    let corner_m = Vector3::new(
        placement.placement.x as f64 * cell_m,
        placement.placement.y as f64 * cell_m,
        f64::from(placement.resting_height) * unit_m,
    );
    let middle_m = moved * Point3::from(corner_m + half_m);
    let reach_m = moved.rotation.to_rotation_matrix().matrix().abs() * half_m;
    BlockedRegion {
        x_min_m: middle_m.x - reach_m.x - cell_m,
        y_min_m: middle_m.y - reach_m.y - cell_m,
        x_max_m: middle_m.x + reach_m.x + cell_m,
        y_max_m: middle_m.y + reach_m.y + cell_m,
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use nalgebra::{Point2, UnitQuaternion};
    use ppnpack_packing::kernel::item::{Item, ViewSurfaces};
    use ppnpack_packing::kernel::placement::Placement;

    use super::*;

    /// A post of 2 x 4 cells and 20 cm, at the cell (10, 12).
    fn region(moved: &Isometry3<f64>) -> [f64; 4] {
        let view = ViewSurfaces {
            nx: 2,
            ny: 4,
            top: vec![100; 8],
            bottom: vec![0; 8],
            underside: None,
            origin_from_corner_m: Vector3::zeros(),
            centre_of_mass_m: Some(Point2::new(0.01, 0.02)),
        };
        let post = Item::new("post", vec![view; 4], 0.0).unwrap();
        let resting = RestingPlacement {
            placement: Placement {
                yaw: 0,
                x: 10,
                y: 12,
            },
            resting_height: 0,
        };
        let region = footprint(&resting, &post.views()[0], &Grid::reference(), moved);
        [
            region.x_min_m,
            region.x_max_m,
            region.y_min_m,
            region.y_max_m,
        ]
    }

    fn is_near(found: [f64; 4], expected: [f64; 4]) {
        let mut pairs = found.iter().zip(&expected);
        assert!(
            pairs.all(|(found, expected)| (found - expected).abs() < 1e-9),
            "{found:?} where {expected:?} is right"
        );
    }

    #[test]
    fn an_item_keeps_the_floor_below_it_and_a_cell_around() {
        is_near(region(&Isometry3::identity()), [0.09, 0.13, 0.11, 0.17]);
        let slid = Isometry3::translation(0.05, -0.02, 0.0);
        is_near(region(&slid), [0.14, 0.18, 0.09, 0.15]);
    }

    #[test]
    fn an_item_that_fell_over_keeps_the_floor_below_its_length() {
        // About its lower edge at x = 10 cm, towards smaller x.
        let edge = Point3::new(0.10, 0.0, 0.0);
        let turn = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), -FRAC_PI_2);
        let fell = Isometry3::rotation_wrt_point(turn, edge);
        is_near(region(&fell), [-0.11, 0.11, 0.11, 0.17]);
    }
}
