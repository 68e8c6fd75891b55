use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion};
use ppnpack_packing::kernel::grid::{ContainerSize, Grid, Yaws};
use ppnpack_packing::kernel::placement::{Placement, RestingPlacement};
use proptest::prelude::*;

use super::*;
use crate::build::{ModelSettings, model};
use crate::shapes::ball;

fn item_of(mesh: Mesh, resolution: &Resolution) -> (Model, Item) {
    let (model, _) = model("thing", mesh, &ModelSettings::default()).unwrap();
    let item = item(&model, resolution).unwrap();
    (model, item)
}

#[test]
fn a_box_of_whole_cells_fills_them_exactly() {
    let mesh = Mesh::cuboid([-0.3, 0.7, 0.2], [-0.27 + 1e-10, 0.75, 0.22]);
    let (model, item) = item_of(mesh, &Resolution::reference());
    let view = &item.views()[0];
    assert_eq!((view.nx(), view.ny(), view.height()), (3, 5, 10));
    assert_eq!(view.voxel_count(), view.box_voxel_count());
    let turned = &item.views()[2];
    assert_eq!(
        (turned.nx(), turned.ny(), turned.voxel_count()),
        (5, 3, 150)
    );
    assert_eq!(item.mesh_volume_m3(), model.volume_m3);
    let centre = turned.centre_of_mass_m(0.01);
    assert!((centre - Point2::new(0.025, 0.015)).norm() < 1e-9);
}

#[test]
fn a_thin_sheet_is_a_unit_thick() {
    let (_, item) = item_of(
        Mesh::cuboid([0.0; 3], [0.03, 0.05, 0.0005]),
        &Resolution::reference(),
    );
    let view = &item.views()[0];
    assert!(view.top().iter().all(|top| *top == 1));
    assert!(view.bottom().iter().all(|bottom| *bottom == 0));
}

#[test]
fn an_arch_is_open_below() {
    // Two posts and a beam, as one outline extruded along y.
    let mut mesh = Mesh::cuboid([0.0, 0.0, 0.04], [0.06, 0.02, 0.06]);
    mesh.append(&Mesh::cuboid([0.0; 3], [0.02, 0.02, 0.04]));
    mesh.append(&Mesh::cuboid([0.04, 0.0, 0.0], [0.06, 0.02, 0.04]));
    let (_, item) = item_of(mesh, &Resolution::reference());
    let view = &item.views()[0];
    let column = |x: usize| (view.bottom()[x * view.ny()], view.top()[x * view.ny()]);
    assert_eq!(
        [column(0), column(2), column(5)],
        [(0, 30), (20, 30), (0, 30)]
    );
    let underside = view.underside().unwrap();
    assert_eq!(
        (underside.nx, underside.ny, underside.samples_per_cell),
        (24, 8, 4)
    );
    assert_eq!(underside.heights_m[12 * 8], 0.04);
}

#[test]
fn a_sphere_leaves_the_corners_empty() {
    let (_, item) = item_of(ball(0.05, 60, 40), &Resolution::reference());
    let view = &item.views()[0];
    assert_eq!((view.nx(), view.ny(), view.height()), (10, 10, 50));
    assert_eq!(view.bottom()[0], ABSENT);
    let underside = view.underside().unwrap();
    assert_eq!(underside.heights_m[0], f32::INFINITY);
}

#[test]
fn what_the_engine_cannot_represent_is_refused() {
    let (model, _) = model(
        "pole",
        Mesh::cuboid([0.0; 3], [0.1, 0.1, 4.0]),
        &ModelSettings::default(),
    )
    .unwrap();
    let yaws = || Yaws::half_turn(1).unwrap();
    let fine = Resolution::new(0.01, 0.0002, yaws()).unwrap();
    let refused = |resolution| item(&model, resolution).unwrap_err().to_string();
    assert!(refused(&fine).contains("its height of 4.000 m is more than"));
    let narrow = Resolution::new(0.00004, 0.002, yaws()).unwrap();
    assert!(refused(&narrow).contains("its width of 0.100 m is more than"));
}

proptest! {
    #[test]
    fn a_placed_item_lies_within_its_columns(
        size in prop::array::uniform3(0.012..0.09_f64),
        angles in prop::array::uniform3(-3.0..3.0_f64),
        placement in (0_usize..5, 0_usize..20, 0_usize..20, 0_i16..60),
    ) {
        let turns = (0..5).map(|yaw| std::f64::consts::TAU * f64::from(yaw) / 5.0);
        let yaws = Yaws::from_radians(turns.collect()).unwrap();
        let resolution = Resolution::new(0.007, 0.0013, yaws).unwrap();
        let container = ContainerSize::cuboid(0.5, 0.5, 0.5);
        let grid = Grid::new(container, resolution.clone()).unwrap();
        let [roll, pitch, yaw] = angles;
        let tilt = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
        let pose = Isometry3::from_parts(Translation3::new(0.1, -0.2, 0.05), tilt);
        let mesh = Mesh::cuboid([0.0; 3], size).transformed(&pose);
        let (model, item) = item_of(mesh, &resolution);
        let (yaw, x, y, resting_height) = placement;
        let placement =
            RestingPlacement { placement: Placement { yaw, x, y }, resting_height };
        let pose = item.container_from_item(&grid, &placement).unwrap();
        let placed = model.mesh.transformed(&pose);
        let bounds = placed.bounds().unwrap();
        let corner = Point3::new(
            x as f64 * 0.007,
            y as f64 * 0.007,
            f64::from(resting_height) * 0.0013,
        );
        prop_assert!((bounds.lowest - corner).norm() < 1e-9);
        let view = &item.views()[yaw];
        let (mut lowest, mut highest) = (vec![f64::INFINITY; view.nx() * view.ny()], vec![0.0; view.nx() * view.ny()]);
        // Points of the surface, away from the borders of cells, where rounding decides.
        for [a, b, c] in placed.corners() {
            for (first, second) in (0..40).flat_map(|first| (0..40 - first).map(move |second| (first, second))) {
                let at = a + (b - a) * (f64::from(first) / 40.0) + (c - a) * (f64::from(second) / 40.0) - corner;
                let cell = [at.x / 0.007, at.y / 0.007];
                if cell.iter().any(|at| (at - at.round()).abs() < 1e-3) {
                    continue;
                }
                let index = cell[0] as usize * view.ny() + cell[1] as usize;
                lowest[index] = at.z.min(lowest[index]);
                highest[index] = at.z.max(highest[index]);
            }
        }
        for (index, (lowest, highest)) in lowest.into_iter().zip(highest).enumerate() {
            if lowest.is_finite() {
                prop_assert!(view.bottom()[index] != ABSENT);
                prop_assert!(f64::from(view.bottom()[index]) * 0.0013 <= lowest + 1e-6);
                prop_assert!(f64::from(view.top()[index]) * 0.0013 >= highest - 1e-6);
            }
        }
        let centre = pose * model.mass.centre_of_mass_m - corner;
        prop_assert!((view.centre_of_mass_m(0.007) - centre.xy()).coords.norm() < 1e-9);
    }
}
