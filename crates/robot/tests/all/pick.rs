//! Where the cup holds items.
use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_catalogue::object::{MassProperties, Model};
use ppnpack_packing::kernel::grid::{Resolution, Yaws};
use ppnpack_packing::kernel::item::{Item, ViewSurfaces};
use ppnpack_robot::arm::Arm;
use ppnpack_robot::arms;
use ppnpack_robot::pick::{NoPickPoint, PickSettings, find};
use ppnpack_robot::surface::UpperSurface;

const PITCH_M: f64 = 0.002;

fn arm() -> Arm {
    arms::arm("nachi-mz07l").unwrap()
}

fn model(mesh: Mesh, centre_of_mass: [f64; 3]) -> Model {
    Model {
        name: "item".to_owned(),
        volume_m3: mesh.signed_volume_m3(),
        mesh,
        pieces: Vec::new(),
        mass: MassProperties {
            mass_kg: 1.0,
            centre_of_mass_m: centre_of_mass.into(),
            inertia_kg_m2: Matrix3::identity(),
        },
        carries_kg: None,
        resting_poses: Vec::new(),
    }
}

fn pick(model: &Model) -> Result<ppnpack_robot::pick::PickPoint, NoPickPoint> {
    let surface = UpperSurface::of_model(model, PITCH_M).unwrap();
    find(&surface, arm().gripper(), &PickSettings::default())
}

#[test]
fn a_block_is_held_above_its_centre_of_mass() {
    let block = Mesh::cuboid([-0.05, -0.04, -0.01], [0.05, 0.04, 0.03]);
    let found = pick(&model(block, [0.011, -0.013, 0.0])).unwrap();
    assert!((found.in_item - Point3::new(0.011, -0.013, 0.03)).norm() < 2.0 * PITCH_M);
    assert!(found.tilt_rad < 1e-6 && found.deviation_m < 1e-6 && found.offset_m < PITCH_M);
}

#[test]
fn a_hole_above_the_centre_of_mass_is_avoided() {
    // Two blocks with a gap between them, joined below.
    let mut mesh = Mesh::cuboid([-0.06, -0.04, 0.0], [-0.005, 0.04, 0.04]);
    mesh.append(&Mesh::cuboid([0.005, -0.04, 0.0], [0.06, 0.04, 0.04]));
    mesh.append(&Mesh::cuboid([-0.06, -0.04, 0.0], [0.06, 0.04, 0.01]));
    let found = pick(&model(mesh, [0.0, 0.0, 0.015])).unwrap();
    assert!((found.in_item.z - 0.04).abs() < 1e-6);
    // The cup's lip of 15 mm lies beside the half gap of 5 mm, as near as the samples allow.
    let beside_m = found.in_item.x.abs() - 0.020;
    assert!((0.0..2.0 * PITCH_M).contains(&beside_m), "{found:?}");
}

#[test]
fn what_is_too_small_is_refused() {
    let block = Mesh::cuboid([-0.01, -0.01, 0.0], [0.01, 0.01, 0.05]);
    let refused = pick(&model(block, [0.0, 0.0, 0.025]));
    assert_eq!(refused, Err(NoPickPoint::TooSmall));
}

/// A wedge that rises along x.
fn wedge(slope: f64) -> Mesh {
    let mut mesh = Mesh::cuboid([-0.05, -0.05, 0.0], [0.05, 0.05, 0.01]);
    let high = mesh
        .vertices
        .iter_mut()
        .filter(|at| at.x > 0.0 && at.z > 0.0);
    high.for_each(|at| at.z += 0.1 * slope);
    mesh
}

#[test]
fn tilted_surfaces_are_held_up_to_the_limit() {
    let found = pick(&model(wedge(0.176), [0.0, 0.0, 0.01])).unwrap();
    let tilt_deg = found.tilt_rad.to_degrees();
    assert!((tilt_deg - 10.0).abs() < 0.5, "{found:?}");
    // 30 degrees.
    let steep = pick(&model(wedge(0.577), [0.0, 0.0, 0.01]));
    assert_eq!(steep, Err(NoPickPoint::TooSteep));
}

#[test]
fn a_level_patch_further_away_is_preferred_to_a_tilted_one() {
    let mut mesh = wedge(0.176);
    mesh.append(&Mesh::cuboid([-0.05, 0.015, 0.0], [0.05, 0.05, 0.03]));
    let found = pick(&model(mesh, [0.0, 0.0, 0.01])).unwrap();
    assert!(found.tilt_rad < 0.01 && found.in_item.y > 0.02, "{found:?}");
}

#[test]
fn higher_parts_in_the_grippers_way_are_refused() {
    // A chimney higher than the stem, with a floor just large enough for the cup.
    let mut mesh = Mesh::cuboid([-0.05, -0.05, 0.0], [0.05, 0.05, 0.01]);
    for (x, y) in [(-0.05, -0.05), (0.02, -0.05), (-0.05, 0.02), (0.02, 0.02)] {
        mesh.append(&Mesh::cuboid([x, y, 0.0], [x + 0.03, y + 0.03, 0.30]));
    }
    let model = model(mesh, [0.0, 0.0, 0.1]);
    assert_eq!(pick(&model), Err(NoPickPoint::GripperBlocked));
}

#[test]
fn a_flat_heightmap_is_held_in_its_middle_at_every_pitch_and_yaw() {
    for (cell_m, cells) in [(0.01, 5), (0.01, 6), (0.005, 11), (0.0025, 24), (0.003, 20)] {
        let yaw_rad = 0.3;
        let yaws = Yaws::from_radians(vec![yaw_rad]).unwrap();
        let resolution = Resolution::new(cell_m, 0.002, yaws).unwrap();
        let origin = Vector3::new(0.01, 0.02, 0.005);
        let (top, bottom) = (vec![20; cells * cells], vec![0; cells * cells]);
        let view = ViewSurfaces {
            origin_from_corner_m: origin,
            ..ViewSurfaces::of_cells(cells, cells, top, bottom)
        };
        let item = Item::new("plate", vec![view], 0.0).unwrap();
        let surface = UpperSurface::of_item(&item, &resolution).unwrap();
        let found = find(&surface, arm().gripper(), &PickSettings::default()).unwrap();
        let half_m = 0.5 * cell_m * cells as f64;
        let middle = Vector3::new(half_m, half_m, 0.04) - origin;
        let in_item = Rotation3::from_axis_angle(&Vector3::z_axis(), -yaw_rad) * middle;
        let off_m = (found.in_item.coords - in_item).norm().max(found.offset_m);
        assert!(
            off_m < cell_m && found.tilt_rad < 1e-6,
            "{cell_m}: {found:?}"
        );
    }
}
