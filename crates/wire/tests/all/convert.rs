//! What is written is read as it was, and what is read is written as it was.

use nalgebra::{Matrix3, Point3};
use ppnpack_packing::kernel::objective::{Heuristic, Order, Weights};
use ppnpack_packing::planning::valid::Tally;
use ppnpack_packing::ranking::refusal::{Cause, Refusal};
use ppnpack_packing::ranking::search::SearchSettings;
use ppnpack_packing::ranking::step::{Evaluated, PlacementCounts};
use ppnpack_packing::scene::model::mesh::Mesh;
use ppnpack_packing::scene::model::{ConvexPiece, MassProperties, Model};
use ppnpack_wire::convert::{cloud, cycle, grid, item, objective, placement, pose, scene, solid};
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::{decode, v1};
use proptest::prelude::*;
use prost::{Message, Name};

use crate::support::domain;

/// A message as another process gets it.
fn sent<M: Message + Name + Default>(message: &M) -> M {
    decode(&message.encode_to_vec(), usize::MAX).unwrap()
}

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|value| value.to_bits()).collect()
}

/// What placements are refused for.
fn refusals() -> impl Strategy<Value = Refusal> {
    let causes = [
        Cause::AboveRim,
        Cause::NotOnFloor,
        Cause::Unstable,
        Cause::UnstableByPublishedTest,
        Cause::CouldFallOver,
        Cause::Arm,
    ];
    let detail = proptest::option::of("[a-z ]{1,20}");
    (proptest::sample::select(causes.to_vec()), detail).prop_map(|(cause, detail)| Refusal {
        cause,
        detail: detail.map(Into::into),
    })
}

proptest! {
    #[test]
    fn grids_stay_what_they_are(sender in domain::grids()) {
        let message = grid::write(&sender);
        let receiver = grid::read(&sent(&message)).unwrap();
        prop_assert_eq!(grid::write(&receiver), message);
        prop_assert_eq!(receiver, sender);
    }

    #[test]
    fn scenes_stay_what_they_are((sender, given) in domain::scenes()) {
        let message = scene::write(&sender, &given);
        let (receiver, taken) = scene::read(&sent(&message)).unwrap();
        prop_assert_eq!(scene::write(&receiver, &taken), message);
        prop_assert_eq!(receiver, sender);
        let heights = |scene: &ppnpack_packing::scene::Scene| {
            scene.surface().map(|surface| bits(surface.heights_m()))
        };
        prop_assert_eq!(heights(&taken), heights(&given));
        prop_assert_eq!(taken, given);
    }

    #[test]
    fn items_stay_what_they_are_and_keep_their_id(given in domain::items()) {
        let message = item::write(&given);
        let received = sent(&message);
        prop_assert_eq!(ItemId::of(&received), ItemId::of(&message));
        let taken = item::read(&received).unwrap();
        prop_assert_eq!(item::write(&taken), message);
        prop_assert_eq!(taken.name(), given.name());
        prop_assert_eq!(taken.views(), given.views());
        prop_assert_eq!(taken.mesh_volume_m3().to_bits(), given.mesh_volume_m3().to_bits());
        for (taken, given) in taken.views().iter().zip(given.views()) {
            let heights = |view: &ppnpack_packing::kernel::item::ItemView| {
                view.underside().map(|underside| bits(&underside.heights_m))
            };
            prop_assert_eq!(heights(taken), heights(given));
        }
    }

    #[test]
    fn placements_stay_what_they_are(given in proptest::collection::vec(domain::placements(), 0..50)) {
        let message = placement::write_all(given.iter().copied());
        prop_assert_eq!(placement::read_all("placements", &sent(&message)).unwrap(), given);
    }

    #[test]
    fn ranked_placements_stay_what_they_are(
        candidate in 0_usize..1000,
        resting in domain::resting_placements(),
        value in -1e9_f64..1e9,
    ) {
        let given = Evaluated { candidate, resting, value };
        let message = placement::write_ranked(&given);
        let taken = placement::read_ranked(&sent(&message)).unwrap();
        prop_assert_eq!(taken.value.to_bits(), given.value.to_bits());
        prop_assert_eq!(taken, given);
        let of_item = placement::write_ranked_item(&given, 3, 2);
        prop_assert_eq!((message.pose, of_item.candidate, of_item.pose), (0, 3, 2));
        prop_assert_eq!(of_item.placement, message.placement);
    }

    #[test]
    fn tallies_stay_what_they_are(
        candidate in 0_usize..1000,
        [possible, proposed, fitting] in any::<[u64; 3]>(),
        refusals in proptest::collection::hash_map(refusals(), any::<u64>(), 0..3),
    ) {
        let counts = PlacementCounts { possible, proposed, fitting };
        let refusals = refusals.into_iter().collect();
        let given = Tally { candidate, counts, refusals };
        let message = placement::write_tally(&given);
        prop_assert_eq!(placement::read_tally(&sent(&message)).unwrap(), given);
    }

    #[test]
    fn poses_stay_what_they_are(given in domain::poses()) {
        let message = pose::write(&given);
        let taken = pose::read_required("pose", Some(&sent(&message))).unwrap();
        prop_assert_eq!(taken, given);
        prop_assert_eq!(pose::write(&taken), message);
    }

    #[test]
    fn poses_rounded_by_the_sender_are_rotations(given in domain::poses(), scale in 0.9991_f64..1.0009) {
        let mut message = pose::write(&given);
        let rotation = message.orientation.as_mut().unwrap();
        for part in [&mut rotation.x, &mut rotation.y, &mut rotation.z, &mut rotation.w] {
            *part *= scale;
        }
        let taken = pose::read_required("pose", Some(&message)).unwrap();
        prop_assert!((taken.rotation.norm() - 1.0).abs() < 1e-9);
        prop_assert!(taken.rotation.angle_to(&given.rotation) < 1e-6);
    }

    #[test]
    fn objectives_stay_what_they_are(
        heuristic in proptest::sample::select(&[
            Heuristic::Sdfm,
            Heuristic::Dbl,
            Heuristic::Hm,
            Heuristic::Mta,
            Heuristic::FirstFit,
            Heuristic::Random,
        ][..]),
        is_balanced in any::<bool>(),
        weights in any::<[u32; 8]>(),
        seed in any::<u64>(),
        above_rim_mm in 0..=1000_u32,
    ) {
        let [resting_height, distance, box_share, balance, corner, surface_volume, touching_area, top_height] =
            weights.map(|weight| f64::from(weight) / 7.0);
        let weights = Weights {
            resting_height,
            distance,
            box_share,
            balance,
            corner,
            surface_volume,
            touching_area,
            top_height,
        };
        let order = if is_balanced { Order::Balance } else { Order::Arrival };
        let above_rim_m = f64::from(above_rim_mm) / 1e3;
        let given = SearchSettings { heuristic, order, weights, seed, above_rim_m };
        let message = objective::write(&given);
        prop_assert_eq!(objective::read_required("objective", Some(&sent(&message))).unwrap(), given);
    }

    #[test]
    fn clouds_stay_what_they_are(
        points in domain::points(),
        container_from_sensor in domain::poses(),
        sequence in 1_u64..,
    ) {
        let capture = cloud::Capture {
            sequence,
            captured_at_ns: 1_800_000_000_000_000_001,
            state_number: 7,
            container_from_sensor,
        };
        let message = sent(&cloud::write(&capture, &points));
        let taken = cloud::read(&message).unwrap();
        let of = |point: Point3<f32>| bits(point.coords.as_slice());
        let found: Vec<_> = taken.points().map(of).collect();
        let seen = points.iter().map(|point| match *point == Point3::origin() {
            true => Point3::from([f32::NAN; 3]),
            false => *point,
        });
        let expected: Vec<_> = seen.map(of).collect();
        prop_assert_eq!(found, expected);
        prop_assert_eq!(taken.len(), points.len());
        prop_assert_eq!(taken.is_empty(), points.is_empty());
        prop_assert_eq!(taken.sequence(), sequence);
        prop_assert_eq!(taken.captured_at_ns(), capture.captured_at_ns);
        prop_assert_eq!(taken.state_number(), 7);
        prop_assert_eq!(taken.container_from_sensor(), &container_from_sensor);
    }
}

#[test]
fn a_cycle_is_read_as_it_was_written() {
    let given = domain::cycle();
    assert_eq!(cycle::read(&sent(&cycle::write(&given))), Ok(given));
}

#[test]
fn weights_that_are_not_given_are_the_papers() {
    let message = v1::Objective {
        heuristic: v1::Heuristic::Sdfm.into(),
        ..Default::default()
    };
    let settings = objective::read_required("objective", Some(&message)).unwrap();
    assert_eq!(settings.weights, Weights::default());
}

/// A solid of an eighth of a cube, with numbers that no decimal writes.
fn model(carries_kg: Option<f64>) -> Model {
    let corner = |x: f64, y: f64, z: f64| Point3::new(x / 3.0, -y / 7.0, z.sqrt());
    let vertices = vec![
        corner(0.0, 0.0, 0.0),
        corner(1.0, 0.0, 0.0),
        corner(0.0, 1.0, 0.0),
        corner(0.0, 0.0, 2.0),
    ];
    Model {
        name: "corner".to_owned(),
        mesh: Mesh {
            vertices: vertices.clone(),
            triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        },
        volume_m3: 1.0 / 6.0,
        pieces: vec![
            ConvexPiece { vertices },
            ConvexPiece {
                vertices: Vec::new(),
            },
        ],
        mass: MassProperties {
            mass_kg: 0.1 + 0.2,
            centre_of_mass_m: corner(0.25, 0.25, 0.25),
            inertia_kg_m2: Matrix3::new(1.0, 0.1, 0.2, 0.3, 2.0, 0.4, 0.5, 0.6, 3.0) / 3.0,
        },
        carries_kg,
        resting_poses: Vec::new(),
    }
}

#[test]
fn solids_stay_what_they_are() {
    for carries_kg in [None, Some(0.0), Some(1.0 / 3.0)] {
        let sender = model(carries_kg);
        let message = solid::write(&sender);
        let receiver = solid::read(&sent(&message)).unwrap();
        assert_eq!(receiver, sender);
        assert_eq!(solid::write(&receiver), message);
        assert_eq!(
            ItemId::of_solid(&message),
            ItemId::of_solid(&sent(&message))
        );
    }
}
