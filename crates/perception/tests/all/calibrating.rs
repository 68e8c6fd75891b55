//! Containers found in clouds of a simulated depth camera, and clouds that are refused.
use nalgebra::{Isometry3, Point3, Vector3};
use ppnpack_camera::NoiseModel;
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_packing::kernel::grid::ContainerSize;
use ppnpack_perception::calibration::{
    Calibration, CalibrationError, CalibrationSettings, calibrate,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::simulated::{Case, container};

fn found(case: &Case) -> Result<Calibration, CalibrationError> {
    calibrate(case.cloud(), &CalibrationSettings::default())
}

/// Asks for an error that says one of these.
fn assert_refused<const N: usize>(
    found: Result<Calibration, CalibrationError>,
    reasons: [&str; N],
) {
    let error = found.unwrap_err().to_string();
    assert!(
        reasons.iter().any(|reason| error.contains(reason)),
        "{error}"
    );
}

const NO_RIM: &str = "no raised rim encloses a hole";

fn with_size(case: &Case, size: ContainerSize) -> Result<Calibration, CalibrationError> {
    let settings = CalibrationSettings {
        size: Some(size),
        ..CalibrationSettings::default()
    };
    calibrate(case.cloud(), &settings)
}

#[test]
fn containers_of_any_size_are_found_from_any_side() {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut refused = 0;
    for index in 0..10 {
        let case = Case::any(&mut random);
        match found(&case) {
            Ok(calibration) => {
                let errors = case.errors(&calibration);
                assert!(errors.are_small(), "case {index}: {errors:?}");
            }
            Err(_) => refused += 1,
        }
    }
    assert!(refused <= 1, "{refused} of 10");
}

#[test]
fn a_perfect_sensor_gives_the_container_almost_exactly() {
    let mut case = Case::plain();
    case.noise = NoiseModel::none();
    let calibration = found(&case).unwrap();
    let errors = case.errors(&calibration);
    let is_exact = errors.position_m < 0.0005 && errors.size_m < 0.0005;
    assert!(is_exact && errors.angle_rad < 0.001, "{errors:?}");
    assert_eq!(calibration.residuals.walls_seen, 4);
    assert_eq!(calibration.size, calibration.measured_size);
}

#[test]
fn the_frame_is_right_handed_with_x_near_the_sensor_s_and_turns_as_asked() {
    let case = Case::plain();
    let cloud = case.cloud();
    for quarter_turns in 0..4_u8 {
        let settings = CalibrationSettings {
            quarter_turns,
            ..CalibrationSettings::default()
        };
        let calibration = calibrate(cloud.iter().copied(), &settings).unwrap();
        let container_from_sensor = calibration.container_from_sensor;
        // The sensor looks down: what is counter-clockwise from above is clockwise in its image.
        let turned = -f64::from(quarter_turns) * std::f64::consts::FRAC_PI_2;
        let wanted = Vector3::new(turned.cos(), turned.sin(), 0.0);
        let x = container_from_sensor * wanted;
        assert!(x.x > 0.65, "{quarter_turns}: {x}");
        // All of the floor is at positive places.
        let camera = container_from_sensor * Point3::origin();
        let is_inside = camera.x > 0.0 && camera.x < 0.32;
        assert!(is_inside && camera.z > 0.5, "{camera}");
        assert!(case.errors(&calibration).are_small());
    }
}

#[test]
fn a_known_size_is_checked_and_decides_which_side_is_x() {
    let mut case = Case::plain();
    case.size_m = [0.40, 0.25, 0.2];
    for roll_rad in [0.2, 1.8] {
        case.look_from(0.8, 0.2, 1.0, roll_rad);
        let calibration = with_size(&case, case.size()).unwrap();
        assert_eq!(calibration.size, case.size());
        assert!((calibration.measured_size.x_m - 0.40).abs() < 0.002);
        assert!(case.errors(&calibration).are_small());
    }
    let wrong = ContainerSize {
        x_m: 0.41,
        ..case.size()
    };
    assert_refused(
        with_size(&case, wrong),
        ["the container's x side was measured"],
    );
    let shallow = ContainerSize {
        z_m: 0.15,
        ..case.size()
    };
    assert_refused(
        with_size(&case, shallow),
        ["the container's z side was measured"],
    );
}

/// Sides within the tolerance of each other were taken for one another.
#[test]
fn a_known_size_with_sides_nearly_equal_is_not_turned() {
    let mut case = Case::plain();
    case.size_m = [0.323, 0.32, 0.2];
    for roll_rad in [0.2, 1.8] {
        case.look_from(0.8, 0.2, 1.0, roll_rad);
        let calibration = with_size(&case, case.size()).unwrap();
        let errors = case.errors(&calibration);
        assert!(errors.position_m < 0.001, "{errors:?}");
    }
}

#[test]
fn the_same_cloud_gives_the_same_result() {
    let case = Case::plain();
    assert_eq!(found(&case).unwrap(), found(&case).unwrap());
}

#[test]
fn content_is_refused() {
    let mut case = Case::plain();
    for (low, high) in [
        ([0.1, 0.1, 0.0], [0.15, 0.15, 0.04]),
        ([0.02, 0.02, 0.0], [0.25, 0.3, 0.1]),
        ([0.2, 0.2, 0.0], [0.3, 0.23, 0.012]),
    ] {
        case.others = vec![Mesh::cuboid(low, high)];
        assert_refused(found(&case), ["the container is not empty"]);
    }
}

#[test]
fn a_bent_wall_is_refused() {
    let mut case = Case::plain();
    case.bulge_m = 0.015;
    assert_refused(found(&case), ["a wall is bent or leans"]);
}

#[test]
fn a_tote_is_found_by_its_opening_and_how_far_its_walls_lean() {
    let mut case = Case::plain();
    case.size_m = [0.4, 0.3, 0.2];
    for draft_deg in [2.0_f64, 5.0] {
        case.draft_rad = draft_deg.to_radians();
        let tote = ContainerSize {
            draft_rad: case.draft_rad,
            ..case.size()
        };
        for calibration in [found(&case), with_size(&case, tote)] {
            let calibration = calibration.unwrap();
            let errors = case.errors(&calibration);
            assert!(errors.are_small(), "{draft_deg} degrees: {errors:?}");
            let off_rad = calibration.measured_size.draft_rad - case.draft_rad;
            assert!(off_rad.abs() < 0.3_f64.to_radians(), "{off_rad}");
        }
        // A box that lets items be placed in the walls' foot is none of it.
        let leans = format!("the walls lean outwards by {draft_deg}.");
        let narrower = "the container's x side was measured as 0.39";
        assert_refused(with_size(&case, case.size()), [&leans, narrower]);
    }
}

#[test]
fn more_than_one_container_needs_a_size() {
    let mut case = Case::plain();
    case.size_m = [0.2, 0.2, 0.15];
    case.look_from(1.1, 0.1, 0.3, 0.2);
    let other = container([0.17, 0.15, 0.12], 0.01, 0.005, 0.0);
    let beside = Isometry3::translation(0.25, 0.0, 0.0);
    let other = other.iter().map(|mesh| mesh.transformed(&beside));
    case.others = other.collect();
    assert_refused(found(&case), ["more than one container"]);
    let calibration = with_size(&case, case.size()).unwrap();
    assert!(case.errors(&calibration).are_small());
}

#[test]
fn clouds_without_a_container_are_refused() {
    let mut case = Case::plain();
    let cloud = case.cloud();
    let settings = CalibrationSettings::default();
    let millimetres = cloud.iter().map(|point| point * 1000.0);
    assert_refused(
        calibrate(millimetres, &settings),
        ["is the cloud in millimetres"],
    );

    assert_refused(calibrate([], &settings), ["has 0 measured points"]);

    let sparse = cloud.iter().step_by(100).copied();
    assert_refused(
        calibrate(sparse, &settings),
        ["too coarse to see", "measured points"],
    );

    case.look_from(1.0, 1.2, 0.3, 0.2);
    assert_refused(
        found(&case),
        ["degrees from above", NO_RIM, "too little of a floor"],
    );

    // Half of the rim is out of sight.
    let mut case = Case::plain();
    case.look_from(0.35, 0.0, 0.0, 0.0);
    assert_refused(
        found(&case),
        ["rim is not seen along", "higher than what seems the rim"],
    );

    // A table with a box on it.
    let table = vec![
        Mesh::cuboid([-5.0, -5.0, -0.1], [5.0, 5.0, 0.0]),
        Mesh::cuboid([0.0; 3], [0.3, 0.3, 0.2]),
    ];
    assert_refused(calibrate(simulated_only(&table), &settings), [NO_RIM]);
}

/// What the plain camera sees of meshes without a container.
fn simulated_only(meshes: &[Mesh]) -> Vec<Point3<f32>> {
    let case = Case {
        size_m: [0.1, 0.1, 0.001],
        wall_m: 0.0001,
        bottom_m: 0.0001,
        others: meshes.to_vec(),
        has_ground: false,
        ..Case::plain()
    };
    case.cloud()
}

#[test]
fn impossible_settings_are_named() {
    let refused = |change: fn(&mut CalibrationSettings)| {
        let mut settings = CalibrationSettings::default();
        change(&mut settings);
        calibrate([], &settings).unwrap_err().to_string()
    };
    assert!(refused(|s| s.quarter_turns = 4).contains("quarter_turns"));
    assert!(refused(|s| s.largest_rms_m = f64::NAN).contains("largest_rms_m"));
    assert!(refused(|s| s.largest_view_angle_rad = 2.0).contains("largest_view_angle_rad"));
    let flat = |s: &mut CalibrationSettings| {
        s.size = Some(ContainerSize {
            z_m: -1.0,
            ..ContainerSize::REFERENCE
        });
    };
    assert!(refused(flat).contains("size"));
}
