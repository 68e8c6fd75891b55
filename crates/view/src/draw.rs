//! The parts that scenes are drawn of, in Foxglove's public schemas.
//!
//! Viewers know these schemas by name. All coordinates are in the frame `<cell>/container`.

use foxglove::messages::{
    Color, CubePrimitive, LinePrimitive, Point3, Pose, Quaternion, SceneEntity,
    SceneEntityDeletion, SceneUpdate, TextPrimitive, Timestamp, TriangleListPrimitive, Vector3,
    line_primitive, scene_entity_deletion,
};
use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use ppnpack_packing::kernel::grid::{ContainerSize, Grid};
use ppnpack_packing::kernel::item::Item;
use ppnpack_packing::scene::model::mesh::Mesh;
use ppnpack_wire::keys::Cell;

const CONTAINER: Color = color(0.35, 0.35, 0.35, 1.0);

/// Maximum of triangles of a mesh; a larger one is drawn as its box.
const MOST_TRIANGLES: usize = 20_000;

/// A box that stands for an item.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ItemBox {
    pub(crate) label: String,
    /// The pose of its middle.
    pub(crate) container_from_middle: Isometry3<f64>,
    /// Its edges, in metres.
    pub(crate) size_m: nalgebra::Vector3<f64>,
}

impl ItemBox {
    /// Gives the bounding box of an item at a yaw, where it is; `None` where it has no such yaw.
    pub(crate) fn of(
        grid: &Grid,
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
            label: item.name().to_string(),
            container_from_middle: container_from_item * item_from_turned * middle_from_origin,
            size_m,
        })
    }

    pub(crate) fn cube(&self, color: Color) -> CubePrimitive {
        CubePrimitive {
            pose: Some(pose(&self.container_from_middle)),
            size: Some(vector(&self.size_m)),
            color: Some(color),
        }
    }

    pub(crate) fn label(&self) -> TextPrimitive {
        let above = Translation3::new(0.0, 0.0, self.size_m.z) * self.container_from_middle;
        text(&above, 14.0, CONTAINER, self.label.clone())
    }
}

/// Replaces all entities by these.
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

pub(crate) fn entity(cell: &Cell, at_ns: i64, id: String) -> SceneEntity {
    SceneEntity {
        timestamp: Some(timestamp(at_ns)),
        frame_id: frame(cell),
        id,
        ..SceneEntity::default()
    }
}

pub(crate) fn frame(cell: &Cell) -> String {
    format!("{cell}/container")
}

/// Gives a time; one before 1970 or after 2106 is moved there.
pub(crate) fn timestamp(at_ns: i64) -> Timestamp {
    let at_ns = u64::try_from(at_ns).unwrap_or(0);
    let seconds = u32::try_from(at_ns / 1_000_000_000).unwrap_or(u32::MAX);
    Timestamp::new(seconds, (at_ns % 1_000_000_000) as u32)
}

pub(crate) fn pose(pose: &Isometry3<f64>) -> Pose {
    let rotation = pose.rotation.coords;
    Pose {
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

fn point(at: &nalgebra::Point3<f64>) -> Point3 {
    Point3 {
        x: at.x,
        y: at.y,
        z: at.z,
    }
}

pub(crate) const fn color(r: f64, g: f64, b: f64, a: f64) -> Color {
    Color { r, g, b, a }
}

/// Draws a text at a place, facing the viewer.
pub(crate) fn text(
    container_from_text: &Isometry3<f64>,
    font_size: f64,
    color: Color,
    text: String,
) -> TextPrimitive {
    TextPrimitive {
        pose: Some(pose(container_from_text)),
        billboard: true,
        font_size,
        scale_invariant: true,
        color: Some(color),
        text,
    }
}

/// Draws the edges of the container: around the floor, around the rim and between them.
pub(crate) fn edges(size: ContainerSize) -> LinePrimitive {
    let ring = |z: f64| {
        let corners = size.outline_m(size.setback_m(z));
        corners.map(move |at| Point3 {
            x: at.x,
            y: at.y,
            z,
        })
    };
    let points: Vec<Point3> = ring(0.0).chain(ring(size.z_m)).collect();
    let count = points.len() as u32 / 2;
    let edges = (0..count).flat_map(|at| {
        let next = (at + 1) % count;
        [at, next, count + at, count + next, at, count + at]
    });
    LinePrimitive {
        r#type: line_primitive::Type::LineList.into(),
        pose: Some(pose(&Isometry3::identity())),
        thickness: 1.5,
        scale_invariant: true,
        points,
        color: Some(CONTAINER),
        indices: edges.collect(),
        ..LinePrimitive::default()
    }
}

/// Draws a line from point to point.
pub(crate) fn strip(
    points: &[nalgebra::Point3<f64>],
    thickness_m: f64,
    color: Color,
) -> LinePrimitive {
    LinePrimitive {
        r#type: line_primitive::Type::LineStrip.into(),
        pose: Some(pose(&Isometry3::identity())),
        thickness: thickness_m,
        points: points.iter().map(point).collect(),
        color: Some(color),
        ..LinePrimitive::default()
    }
}

/// Draws a mesh where it is: its box where it has too many triangles, nothing where it has none.
pub(crate) fn mesh(
    own: &Mesh,
    container_from_item: &Isometry3<f64>,
    color: Color,
) -> Option<TriangleListPrimitive> {
    let boxed = match own.triangles.len() {
        0 => return None,
        1..=MOST_TRIANGLES => None,
        _ => Some(own.bounds()?.mesh()),
    };
    let drawn = boxed.as_ref().unwrap_or(own);
    Some(TriangleListPrimitive {
        pose: Some(pose(container_from_item)),
        points: drawn.vertices.iter().map(point).collect(),
        color: Some(color),
        colors: Vec::new(),
        indices: drawn.triangles.iter().flatten().copied().collect(),
    })
}

/// Gives a colour for a name: always the same, and as a rule another one than other names'.
pub(crate) fn color_of(name: &str) -> Color {
    // FNV-1a.
    let hash = name.bytes().fold(0x811c_9dc5_u32, |hash, byte| {
        (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193)
    });
    let turn = f64::from(hash % 360) / 360.0;
    let part = |shift: f64| 0.45 + 0.35 * (std::f64::consts::TAU * (turn + shift)).cos();
    color(part(0.0), part(1.0 / 3.0), part(2.0 / 3.0), 0.95)
}

#[cfg(test)]
mod tests {
    use ppnpack_packing::kernel::item::ViewSurfaces;
    use ppnpack_packing::kernel::placement::{Placement, RestingPlacement};

    use super::*;

    /// Gives an item of 2 x 3 cells and 4 units with its frame in its middle, and 4 yaws.
    fn block() -> Item {
        let surfaces = ViewSurfaces {
            nx: 2,
            ny: 3,
            top: vec![4; 6],
            bottom: vec![0; 6],
            underside: None,
            origin_from_corner_m: nalgebra::Vector3::new(0.01, 0.015, 0.004),
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
        let expected = Isometry3::translation(0.05, 0.065, 0.024);
        let found = shown.container_from_middle.to_homogeneous();
        assert!((found - expected.to_homogeneous()).norm() < 1e-9);
        let expected_m = nalgebra::Vector3::new(0.02, 0.03, 0.008);
        assert!((shown.size_m - expected_m).norm() < 1e-9);
        assert_eq!(ItemBox::of(&grid, &item, 4, &pose), None);
    }
}
