//! What is drawn of streams is what viewers read.

use foxglove::Encode;
use foxglove::messages::{Grid as GridMessage, PointCloud, SceneUpdate, Timestamp};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::Heightmap;
use ppnpack_packing::item::{Item, ViewSurfaces};
use ppnpack_packing::placement::{Placement, RestingPlacement};
use ppnpack_wire::convert::cloud;
use ppnpack_wire::debug::{self, ItemBox};
use ppnpack_wire::keys::Cell;
use ppnpack_wire::{convert, v1};
use prost::Message;

const AT_NS: i64 = 1_800_000_000_000_000_007;

/// What a viewer gets.
fn shown<M: Message + Encode + Default>(sent: &M) -> M {
    assert!(M::get_schema().is_some());
    <M as Message>::decode(&*Message::encode_to_vec(sent)).unwrap()
}

fn cell() -> Cell {
    Cell::new("west").unwrap()
}

#[test]
fn heights_lie_where_foxglove_looks_for_them() {
    let grid = Grid::reference();
    let mut heightmap = Heightmap::empty(&grid);
    heightmap.raise(3, 5, 10);
    let message: GridMessage = shown(&debug::heightmap(&cell(), AT_NS, &grid, &heightmap));
    assert_eq!(message.frame_id, "west/container");
    assert_eq!(message.timestamp, Some(Timestamp::new(1_800_000_000, 7)));
    let at = 5 * message.row_stride as usize + 3 * message.cell_stride as usize;
    let height_m = f32::from_le_bytes(message.data[at..at + 4].try_into().unwrap());
    assert!((height_m - 0.02).abs() < 1e-6);
    assert_eq!(message.data.iter().filter(|byte| **byte != 0).count(), 4);
    assert_eq!(message.data.len(), 4 * 32 * 32);
}

#[test]
fn clouds_keep_their_fields_and_bytes() {
    let capture = cloud::Capture {
        sequence: 1,
        captured_at_ns: -5,
        state_number: 0,
        container_from_sensor: Translation3::new(0.1, 0.2, 1.0).into(),
    };
    let message = cloud::write(&capture, &[Point3::new(1.0, 2.0, 3.0)]);
    let cloud = cloud::read(&message).unwrap();
    let shown: PointCloud = shown(&debug::cloud(&cell(), &cloud));
    assert_eq!(shown.timestamp, Some(Timestamp::new(0, 0)));
    assert_eq!(shown.data, message.data);
    let names: Vec<&str> = shown
        .fields
        .iter()
        .map(|field| field.name.as_str())
        .collect();
    assert_eq!(names, ["x", "y", "z"]);
    let float = foxglove::messages::packed_element_field::NumericType::Float32;
    assert_eq!(shown.fields[0].r#type(), float);
    assert_eq!(shown.pose.unwrap().position.unwrap().z, 1.0);
}

/// An item of 2 x 3 cells and 4 units whose frame is in its middle; it has its yaws from the reference grid.
fn block() -> Item {
    let surfaces = ViewSurfaces {
        nx: 2,
        ny: 3,
        top: vec![4; 6],
        bottom: vec![0; 6],
        underside: None,
        origin_from_corner_m: Vector3::new(0.01, 0.015, 0.004),
        centre_of_mass_m: None,
    };
    Item::new("block", vec![surfaces; 4], 0.0).unwrap()
}

#[test]
fn the_box_of_a_placement_stands_upright_where_it_is_placed() {
    let grid = Grid::reference();
    let item = block();
    let placement = Placement { yaw: 1, x: 4, y: 5 };
    let resting = RestingPlacement {
        placement,
        resting_height: 10,
    };
    let pose = item.container_from_item(&grid, &resting).unwrap();
    let shown = ItemBox::of(&grid, &item, placement.yaw, &pose).unwrap();
    let expected = Isometry3::from_parts(
        Translation3::new(0.05, 0.065, 0.024),
        UnitQuaternion::identity(),
    );
    assert!(
        (shown.container_from_middle.to_homogeneous() - expected.to_homogeneous()).norm() < 1e-9
    );
    assert!((shown.size_m - Vector3::new(0.02, 0.03, 0.008)).norm() < 1e-9);
    assert_eq!(ItemBox::of(&grid, &item, 4, &pose), None);
}

#[test]
fn a_scene_replaces_the_one_before() {
    let at = Isometry3::translation(0.1, 0.2, 0.03);
    let body = |id: &str, is_inside| v1::Body {
        item_id: id.to_owned(),
        object: "block".to_owned(),
        container_from_item: Some(convert::pose::write(&at)),
        is_inside,
        ..v1::Body::default()
    };
    let state = v1::CellState {
        bodies: vec![body("a", true), body("b", false)],
        ..v1::CellState::default()
    };
    let shown: SceneUpdate = shown(&debug::state(&cell(), AT_NS, &state));
    let all = foxglove::messages::scene_entity_deletion::Type::All;
    assert_eq!(shown.deletions[0].r#type(), all);
    let ids: Vec<&str> = shown
        .entities
        .iter()
        .map(|entity| entity.id.as_str())
        .collect();
    assert_eq!(ids, ["body/a", "body/b"]);
    let [inside, outside] = [0, 1].map(|index| &shown.entities[index].cubes[0]);
    assert_ne!(inside.color, outside.color);
    assert_eq!(inside.pose.as_ref().unwrap().position.unwrap().z, 0.03);
    assert_eq!(shown.entities[1].texts[0].text, "block");
}
