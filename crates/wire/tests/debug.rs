//! The debug streams are what viewers read.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use foxglove::Encode;
use foxglove::messages::{Grid as GridMessage, PointCloud, SceneUpdate, Timestamp};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use ppnpack_packing::grid::{ContainerSize, Grid, Resolution};
use ppnpack_packing::heightmap::Heightmap;
use ppnpack_packing::item::{Item, ViewSurfaces};
use ppnpack_packing::placement::{Placement, RestingPlacement};
use ppnpack_packing::score_map::ScoreMap;
use ppnpack_wire::convert::cloud;
use ppnpack_wire::debug::{self, Foxglove, ItemBox, ItemScores, MOST_SCORED_ITEMS, Schema};
use ppnpack_wire::keys::Cell;
use ppnpack_wire::{MAX_MESSAGE_BYTES, encoding_of};
use prost::Message;

const AT_NS: i64 = 1_800_000_000_000_000_007;

/// What a viewer gets, by the names and schemas that Foxglove gives.
fn shown<M: Schema + Encode + PartialEq + std::fmt::Debug>(sent: &Foxglove<M>) -> M {
    let name = M::get_schema().unwrap().name;
    assert_eq!(
        encoding_of::<Foxglove<M>>(),
        format!("application/protobuf;{name}")
    );
    let payload = Message::encode_to_vec(sent);
    assert_eq!(payload.len(), Message::encoded_len(sent));
    assert_eq!(
        <Foxglove<M> as Message>::decode(&*payload).unwrap().0,
        sent.0
    );
    <M as Message>::decode(&*payload).unwrap()
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

/// A field of a cell, by the field's number.
fn value(message: &GridMessage, (x, y): (usize, usize), field: usize) -> f32 {
    let cell = y * message.row_stride as usize + x * message.cell_stride as usize;
    let at = cell + message.fields[field].offset as usize;
    f32::from_le_bytes(message.data[at..at + 4].try_into().unwrap())
}

fn field_names(message: &GridMessage) -> Vec<&str> {
    let fields = message.fields.iter();
    fields.map(|field| field.name.as_str()).collect()
}

#[test]
fn scores_lie_where_the_heights_do_by_item() {
    let resolution = Grid::reference().resolution().clone();
    let container = ContainerSize {
        x_m: 0.4,
        y_m: 0.2,
        z_m: 0.3,
    };
    let grid = Grid::new(container, resolution).unwrap();
    let mut maps = [ScoreMap::empty(&grid), ScoreMap::empty(&grid)];
    maps[0].lower(3, 5, -1.5);
    maps[0].lower(39, 0, 4.0);
    maps[1].lower(3, 5, -0.5);
    maps[1].lower(0, 19, 2.0);
    let items = [("mug", &maps[0]), ("bowl", &maps[1])];
    let items = items.map(|(name, scores)| ItemScores { name, scores });
    let message: GridMessage = shown(&debug::scores(&cell(), AT_NS, &grid, &items));
    assert_eq!(field_names(&message), ["best", "mug", "bowl"]);
    let float = foxglove::messages::packed_element_field::NumericType::Float32;
    assert!(message.fields.iter().all(|field| field.r#type() == float));

    let heights = debug::heightmap(&cell(), AT_NS, &grid, &Heightmap::empty(&grid));
    let heights: GridMessage = shown(&heights);
    assert_eq!(
        (&message.frame_id, &message.timestamp, &message.pose),
        (&heights.frame_id, &heights.timestamp, &heights.pose)
    );
    assert_eq!(
        (message.column_count, &message.cell_size),
        (heights.column_count, &heights.cell_size)
    );
    let bytes = grid.nx() * grid.ny() * 4;
    assert_eq!((message.data.len(), heights.data.len()), (3 * bytes, bytes));

    let expected = [
        ((3, 5), [Some(-1.5), Some(-1.5), Some(-0.5)]),
        ((39, 0), [Some(4.0), Some(4.0), None]),
        ((0, 19), [Some(2.0), None, Some(2.0)]),
    ];
    for (x, y) in (0..grid.nx()).flat_map(|x| (0..grid.ny()).map(move |y| (x, y))) {
        let scored = expected.iter().find(|(at, _)| *at == (x, y));
        let scored = scored.map_or([None; 3], |(_, scores)| *scores);
        let found = [0, 1, 2].map(|field| value(&message, (x, y), field));
        let found = found.map(|score| (!score.is_nan()).then_some(score));
        assert_eq!(found, scored, "({x}, {y})");
    }
}

#[test]
fn fields_of_scores_have_different_names() {
    let grid = Grid::reference();
    let map = ScoreMap::empty(&grid);
    let named = |names: &[&str]| -> GridMessage {
        let items = names.iter().map(|name| ItemScores { name, scores: &map });
        let items: Vec<ItemScores<'_>> = items.collect();
        shown(&debug::scores(&cell(), AT_NS, &grid, &items))
    };
    let message = named(&["mug", "mug", "3 bowl", "best", "mug"]);
    let expected = ["best", "mug", "2 mug", "3 bowl", "4 best", "5 mug"];
    assert_eq!(field_names(&message), expected);
    let message = named(&["3 mug", "mug", "mug"]);
    assert_eq!(field_names(&message), ["best", "3 mug", "mug", "3 3 mug"]);
    assert_eq!(field_names(&named(&[])), ["best"]);
}

#[test]
fn the_best_score_is_of_all_items_and_fields_are_of_the_first() {
    let grid = Grid::reference();
    let mut maps = vec![ScoreMap::empty(&grid); MOST_SCORED_ITEMS + 4];
    for (index, map) in maps.iter_mut().enumerate() {
        map.lower(1, 2, -(index as f32));
    }
    let items = maps.iter().map(|scores| ItemScores {
        name: "box",
        scores,
    });
    let items: Vec<ItemScores<'_>> = items.collect();
    let message: GridMessage = shown(&debug::scores(&cell(), AT_NS, &grid, &items));
    assert_eq!(message.fields.len(), 1 + MOST_SCORED_ITEMS);
    assert_eq!(value(&message, (1, 2), 0), -19.0);
    assert_eq!(value(&message, (1, 2), MOST_SCORED_ITEMS), -15.0);
}

#[test]
fn scores_of_a_large_grid_are_no_larger_than_a_message() {
    let resolution = Resolution::new(0.001, 0.002, Grid::reference().resolution().yaws().clone());
    let container = ContainerSize {
        x_m: 1024.0 * 0.001,
        y_m: 1024.0 * 0.001,
        z_m: 0.3,
    };
    let grid = Grid::new(container, resolution.unwrap()).unwrap();
    let map = ScoreMap::empty(&grid);
    let item = ItemScores {
        name: "box",
        scores: &map,
    };
    let sent = debug::scores(&cell(), AT_NS, &grid, &[item; 16]);
    // Four mebibytes a field.
    assert_eq!(field_names(&sent.0), ["best", "box", "2 box"]);
    assert!(Message::encoded_len(&sent) <= MAX_MESSAGE_BYTES);
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
    let grid = Grid::reference();
    let body = |id: &str| ItemBox {
        id: id.to_owned(),
        ..ItemBox::of(&grid, &block(), 0, &Isometry3::identity()).unwrap()
    };
    let bodies = [body("a"), body("b")];
    let sent = debug::scene(&cell(), AT_NS, grid.container(), &bodies, Some(&body("c")));
    let shown: SceneUpdate = shown(&sent);
    let all = foxglove::messages::scene_entity_deletion::Type::All;
    assert_eq!(shown.deletions[0].r#type(), all);
    let ids: Vec<&str> = shown
        .entities
        .iter()
        .map(|entity| entity.id.as_str())
        .collect();
    assert_eq!(ids, ["container", "body/a", "body/b", "decision"]);
    let lines = &shown.entities[0].lines[0];
    assert_eq!((lines.points.len(), lines.indices.len()), (8, 24));
    for edge in lines.indices.chunks(2) {
        let [from, to] = [
            lines.points[edge[0] as usize],
            lines.points[edge[1] as usize],
        ];
        let differing = [from.x != to.x, from.y != to.y, from.z != to.z];
        assert_eq!(differing.iter().filter(|differs| **differs).count(), 1);
    }
    assert_eq!(shown.entities[3].texts[0].text, "block");
}
