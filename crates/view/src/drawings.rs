//! Streams as pictures, in schemas that Foxglove draws.

use foxglove::Encode;
use foxglove::messages::{
    Color, Grid, PackedElementField, PointCloud, SceneUpdate, Vector2, packed_element_field,
};
use nalgebra::Isometry3;
use ppnpack_service::clock::now_ns;
use ppnpack_wire::convert::{self, scene};
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::schemas::MessageSchema;
use ppnpack_wire::{MAX_CLOUD_BYTES, MAX_MESSAGE_BYTES, WireError, decode, v1};
use prost::Message;
use prost::bytes::BufMut;

use crate::draw::{ItemBox, color, entity, frame, in_place_of_all, pose, timestamp};

const BODY: Color = color(0.45, 0.62, 0.80, 0.75);
const OUTSIDE: Color = color(0.80, 0.30, 0.25, 0.75);

/// The size of a cell of a grid.
const FLOAT_BYTES: u32 = 4;

/// The edges of the cube that stands for an item whose shape is not known, in metres.
const MARK_M: f64 = 0.02;

/// The function that makes a picture of a message of a cell.
pub(crate) type Draw = fn(&Cell, &[u8]) -> Result<Vec<u8>, WireError>;

/// A stream, and the way in which it is drawn.
pub(crate) struct Drawing {
    pub(crate) stream: Stream,
    /// The name of the channel with the pictures.
    pub(crate) name: &'static str,
    pub(crate) schema: fn() -> MessageSchema,
    pub(crate) draw: Draw,
}

pub(crate) static DRAWINGS: [Drawing; 3] = [
    Drawing {
        stream: Stream::Heightmap,
        name: "drawn_heightmap",
        schema: schema::<Grid>,
        draw: |cell, payload| {
            Ok(heightmap(cell, &decode(payload, MAX_MESSAGE_BYTES)?)?.encode_to_vec())
        },
    },
    Drawing {
        stream: Stream::Cloud,
        name: "drawn_cloud",
        schema: schema::<PointCloud>,
        draw: |cell, payload| Ok(cloud(cell, decode(payload, MAX_CLOUD_BYTES)?)?.encode_to_vec()),
    },
    Drawing {
        stream: Stream::State,
        name: "drawn_state",
        schema: schema::<SceneUpdate>,
        draw: |cell, payload| Ok(state(cell, &decode(payload, MAX_MESSAGE_BYTES)?).encode_to_vec()),
    },
];

/// Gives the schema of a message of Foxglove's.
pub(crate) fn schema<M: Encode>() -> MessageSchema {
    let schema = M::get_schema();
    let known = schema.map(|schema| (schema.name, schema.data.into_owned()));
    let (name, descriptors) = known.unwrap_or_default();
    MessageSchema { name, descriptors }
}

/// Draws the heightmap on the container's floor, with the field `height`, in metres.
fn heightmap(cell: &Cell, message: &v1::Heightmap) -> Result<Grid, WireError> {
    let (grid, scene) = scene::read_required("scene", message.scene.as_ref())?;
    let resolution = grid.resolution();
    let unit_m = resolution.height_unit_m() as f32;
    let columns = u32::try_from(grid.nx()).unwrap_or(u32::MAX);
    // Foxglove's rows go along y.
    let mut data = Vec::with_capacity(grid.nx() * grid.ny() * FLOAT_BYTES as usize);
    for y in 0..grid.ny() {
        for x in 0..grid.nx() {
            data.put_f32_le(f32::from(scene.heightmap().get(x, y).unwrap_or(0)) * unit_m);
        }
    }
    Ok(Grid {
        timestamp: Some(timestamp(message.captured_at_ns)),
        frame_id: frame(cell),
        pose: Some(pose(&Isometry3::identity())),
        column_count: columns,
        cell_size: Some(Vector2 {
            x: resolution.cell_m(),
            y: resolution.cell_m(),
        }),
        row_stride: columns.saturating_mul(FLOAT_BYTES),
        cell_stride: FLOAT_BYTES,
        fields: vec![PackedElementField {
            name: "height".to_owned(),
            offset: 0,
            r#type: packed_element_field::NumericType::Float32.into(),
        }],
        data: data.into(),
    })
}

/// Draws a cloud with all of its fields.
fn cloud(cell: &Cell, message: v1::PointCloud) -> Result<PointCloud, WireError> {
    let sensor = *convert::cloud::read(&message)?.container_from_sensor();
    let field = |field: v1::PackedField| PackedElementField {
        name: field.name,
        offset: field.offset,
        // Numbered alike.
        r#type: field.r#type,
    };
    Ok(PointCloud {
        timestamp: Some(timestamp(message.captured_at_ns)),
        frame_id: frame(cell),
        pose: Some(pose(&sensor)),
        point_stride: message.point_stride,
        fields: message.fields.into_iter().map(field).collect(),
        data: message.data.into(),
    })
}

/// Draws the items of a state in place of those before: the frame of each, with its name.
fn state(cell: &Cell, state: &v1::CellState) -> SceneUpdate {
    let at_ns = i64::try_from(now_ns()).unwrap_or(i64::MAX);
    let entities = state.bodies.iter().filter_map(|body| {
        let at = convert::pose::read_required("pose", body.container_from_item.as_ref());
        let mark = ItemBox {
            label: body.object.clone(),
            container_from_middle: at.ok()?,
            size_m: nalgebra::Vector3::repeat(MARK_M),
        };
        let color = if body.is_inside { BODY } else { OUTSIDE };
        let mut drawn = entity(cell, at_ns, format!("body/{}", body.item_id));
        drawn.cubes.push(mark.cube(color));
        drawn.texts.push(mark.label());
        Some(drawn)
    });
    in_place_of_all(at_ns, entities.collect())
}

#[cfg(test)]
mod tests {
    use foxglove::messages::Timestamp;
    use ppnpack_packing::kernel::grid;
    use ppnpack_packing::kernel::heightmap::Heightmap;
    use ppnpack_packing::scene::Scene;

    use super::*;

    fn cell() -> Cell {
        Cell::new("west").unwrap()
    }

    #[test]
    fn heights_lie_where_foxglove_looks_for_them() {
        let grid = grid::Grid::reference();
        let mut map = Heightmap::empty(&grid);
        map.raise(3, 5, 10);
        let sent = v1::Heightmap {
            captured_at_ns: 1_800_000_000_000_000_007,
            scene: Some(scene::write(&grid, &Scene::from_heightmap(map))),
            ..v1::Heightmap::default()
        };
        let message = heightmap(&cell(), &sent).unwrap();
        assert_eq!(message.frame_id, "west/container");
        assert_eq!(message.timestamp, Some(Timestamp::new(1_800_000_000, 7)));
        let at = 5 * message.row_stride as usize + 3 * message.cell_stride as usize;
        let height_m = f32::from_le_bytes(message.data[at..at + 4].try_into().unwrap());
        assert!((height_m - 0.02).abs() < 1e-6);
        assert_eq!(message.data.iter().filter(|byte| **byte != 0).count(), 4);
        assert_eq!(message.data.len(), 4 * 32 * 32);
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
        let told = v1::CellState {
            bodies: vec![body("a", true), body("b", false)],
            ..v1::CellState::default()
        };
        let shown = state(&cell(), &told);
        let all = foxglove::messages::scene_entity_deletion::Type::All;
        assert_eq!(shown.deletions[0].r#type(), all);
        let ids = shown.entities.iter().map(|entity| entity.id.as_str());
        assert_eq!(ids.collect::<Vec<_>>(), ["body/a", "body/b"]);
        let [inside, outside] = [0, 1].map(|index| &shown.entities[index].cubes[0]);
        assert_ne!(inside.color, outside.color);
        assert_eq!(inside.pose.as_ref().unwrap().position.unwrap().z, 0.03);
        assert_eq!(shown.entities[1].texts[0].text, "block");
    }
}
