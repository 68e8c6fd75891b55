//! What streams say, drawn for people in Foxglove's public schemas.
//!
//! Viewers know these schemas by name; nothing else depends on them. All coordinates are in the frame
//! `<cell>/container`.

use foxglove::messages::{
    self, Color, CubePrimitive, Grid, LinePrimitive, PackedElementField, Point3, PointCloud,
    Quaternion, SceneEntity, SceneEntityDeletion, SceneUpdate, TextPrimitive, Timestamp, Vector2,
    Vector3, line_primitive, packed_element_field, scene_entity_deletion,
};
use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use ppnpack_packing::grid::{self, ContainerSize};
use ppnpack_packing::heightmap::Heightmap;
use ppnpack_packing::item::Item;
use prost::bytes::BufMut;

use crate::convert::{self, cloud::Cloud};
use crate::keys::Cell;
use crate::limits::to_index;
use crate::v1;

const BODY: Color = color(0.45, 0.62, 0.80, 0.75);
const OUTSIDE: Color = color(0.80, 0.30, 0.25, 0.75);
const CONTAINER: Color = color(0.35, 0.35, 0.35, 1.0);

/// The size of a cell of a grid.
const FLOAT_BYTES: u32 = 4;

/// The edges of the cube that stands for an item whose shape is not known, in metres.
const MARK_M: f64 = 0.02;

/// A box that stands for an item.
#[derive(Debug, Clone, PartialEq)]
pub struct ItemBox {
    /// Tells it from the others.
    pub id: String,
    /// What is written beside it.
    pub label: String,
    /// Where its middle is.
    pub container_from_middle: Isometry3<f64>,
    /// Its edges, in metres.
    pub size_m: nalgebra::Vector3<f64>,
    /// Whether it lies within the container.
    pub is_inside: bool,
}

impl ItemBox {
    /// The bounding box of an item's view at a yaw, where the item is. `None` where the item has no such yaw.
    ///
    /// For a placement take its own yaw, which gives an upright box; for a body that lies anyhow take yaw 0.
    pub fn of(
        grid: &grid::Grid,
        item: &Item,
        yaw: usize,
        container_from_item: &Isometry3<f64>,
    ) -> Option<Self> {
        let view = item.views().get(yaw)?;
        let yaw_rad = grid.resolution().yaws().radians().get(yaw)?;
        let cell_m = grid.resolution().cell_m();
        let size_m = nalgebra::Vector3::new(
            view.nx() as f64 * cell_m,
            view.ny() as f64 * cell_m,
            f64::from(view.height()) * grid.resolution().height_unit_m(),
        );
        let item_from_turned =
            UnitQuaternion::from_axis_angle(&nalgebra::Vector3::z_axis(), -yaw_rad);
        let middle_from_origin = Translation3::from(size_m / 2.0 - view.origin_from_corner_m());
        Some(Self {
            id: String::new(),
            label: item.name().to_string(),
            container_from_middle: container_from_item * item_from_turned * middle_from_origin,
            size_m,
            is_inside: true,
        })
    }
}

/// The heightmap as a `foxglove.Grid` on the container's floor with the field `height`, in metres.
pub fn heightmap(
    cell: &Cell,
    captured_at_ns: i64,
    grid: &grid::Grid,
    heightmap: &Heightmap,
) -> Grid {
    let unit_m = grid.resolution().height_unit_m() as f32;
    let columns = to_index(grid.nx());
    // Foxglove's rows go along y.
    let mut data = Vec::with_capacity(grid.nx() * grid.ny() * FLOAT_BYTES as usize);
    for y in 0..grid.ny() {
        for x in 0..grid.nx() {
            data.put_f32_le(f32::from(heightmap.get(x, y).unwrap_or(0)) * unit_m);
        }
    }
    let cell_m = grid.resolution().cell_m();
    Grid {
        timestamp: Some(timestamp(captured_at_ns)),
        frame_id: frame(cell),
        pose: Some(pose(&Isometry3::identity())),
        column_count: columns,
        cell_size: Some(Vector2 {
            x: cell_m,
            y: cell_m,
        }),
        row_stride: columns.saturating_mul(FLOAT_BYTES),
        cell_stride: FLOAT_BYTES,
        fields: vec![PackedElementField {
            name: "height".to_owned(),
            offset: 0,
            r#type: packed_element_field::NumericType::Float32.into(),
        }],
        data: data.into(),
    }
}

/// These entities in place of all that were there.
pub(crate) fn in_place_of_all(at_ns: i64, entities: Vec<SceneEntity>) -> SceneUpdate {
    SceneUpdate {
        deletions: vec![SceneEntityDeletion {
            timestamp: Some(timestamp(at_ns)),
            r#type: scene_entity_deletion::Type::All.into(),
            id: String::new(),
        }],
        entities,
    }
}

/// The items of a cell's state as a `foxglove.SceneUpdate` that replaces the one before: where the frame of each is, with its name.
pub fn state(cell: &Cell, at_ns: i64, state: &v1::CellState) -> SceneUpdate {
    let entities = state.bodies.iter().filter_map(|body| {
        let at = convert::pose::read_required("pose", body.container_from_item.as_ref());
        let mark = ItemBox {
            id: body.item_id.clone(),
            label: body.object.clone(),
            container_from_middle: at.ok()?,
            size_m: nalgebra::Vector3::repeat(MARK_M),
            is_inside: body.is_inside,
        };
        Some(SceneEntity {
            timestamp: Some(timestamp(at_ns)),
            frame_id: frame(cell),
            id: format!("body/{}", mark.id),
            cubes: vec![cube(&mark, if mark.is_inside { BODY } else { OUTSIDE })],
            texts: vec![label(&mark)],
            ..SceneEntity::default()
        })
    });
    in_place_of_all(at_ns, entities.collect())
}

/// A cloud as a `foxglove.PointCloud`, with all of its fields.
pub fn cloud(cell: &Cell, cloud: &Cloud<'_>) -> PointCloud {
    let message = cloud.message();
    let field = |field: &v1::PackedField| PackedElementField {
        name: field.name.clone(),
        offset: field.offset,
        // Numbered alike.
        r#type: field.r#type,
    };
    PointCloud {
        timestamp: Some(timestamp(message.captured_at_ns)),
        frame_id: frame(cell),
        pose: Some(pose(cloud.container_from_sensor())),
        point_stride: message.point_stride,
        fields: message.fields.iter().map(field).collect(),
        data: message.data.clone().into(),
    }
}

pub(crate) fn frame(cell: &Cell) -> String {
    format!("{cell}/container")
}

/// What lies before 1970 or after 2106 is moved there.
pub(crate) fn timestamp(at_ns: i64) -> Timestamp {
    let at_ns = u64::try_from(at_ns).unwrap_or(0);
    let seconds = u32::try_from(at_ns / 1_000_000_000).unwrap_or(u32::MAX);
    Timestamp::new(seconds, (at_ns % 1_000_000_000) as u32)
}

pub(crate) fn pose(pose: &Isometry3<f64>) -> messages::Pose {
    let rotation = pose.rotation.coords;
    messages::Pose {
        position: Some(vector(&pose.translation.vector)),
        orientation: Some(Quaternion {
            x: rotation.x,
            y: rotation.y,
            z: rotation.z,
            w: rotation.w,
        }),
    }
}

fn vector(vector: &nalgebra::Vector3<f64>) -> Vector3 {
    Vector3 {
        x: vector.x,
        y: vector.y,
        z: vector.z,
    }
}

pub(crate) const fn color(r: f64, g: f64, b: f64, a: f64) -> Color {
    Color { r, g, b, a }
}

pub(crate) fn cube(item: &ItemBox, color: Color) -> CubePrimitive {
    CubePrimitive {
        pose: Some(pose(&item.container_from_middle)),
        size: Some(vector(&item.size_m)),
        color: Some(color),
    }
}

/// The label above a box, facing the viewer.
pub(crate) fn label(item: &ItemBox) -> TextPrimitive {
    let above = Translation3::new(0.0, 0.0, item.size_m.z) * item.container_from_middle;
    TextPrimitive {
        pose: Some(pose(&above)),
        billboard: true,
        font_size: 14.0,
        scale_invariant: true,
        color: Some(CONTAINER),
        text: item.label.clone(),
    }
}

/// The twelve edges of the container.
pub(crate) fn edges(size: ContainerSize) -> LinePrimitive {
    let corner = |index: u32| Point3 {
        x: f64::from(index & 1) * size.x_m,
        y: f64::from((index >> 1) & 1) * size.y_m,
        z: f64::from((index >> 2) & 1) * size.z_m,
    };
    // Two corners share an edge where their indices differ in one bit.
    let edges = (0..8_u32).flat_map(|from| {
        let others = [1, 2, 4].map(|bit| from | bit).into_iter();
        let others = others.filter(move |to| *to != from);
        others.flat_map(move |to| [from, to])
    });
    LinePrimitive {
        r#type: line_primitive::Type::LineList.into(),
        pose: Some(pose(&Isometry3::identity())),
        thickness: 1.5,
        scale_invariant: true,
        points: (0..8).map(corner).collect(),
        color: Some(CONTAINER),
        colors: Vec::new(),
        indices: edges.collect(),
    }
}
