//! Known items as they lie: the heightmaps of an object in the pose that it was seen in.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use ppnpack_catalogue::catalogue::ObjectError;
use ppnpack_catalogue::object::Model;
use ppnpack_catalogue::views;
use ppnpack_packing::kernel::grid::Resolution;
use ppnpack_packing::kernel::item::Item;
use ppnpack_packing::kernel::rectangle::least_rectangle_rad;

use crate::rest::turn_to_rest;

/// Maximum lean of an object that is taken to be at rest, in radians. Planners take maps that lean
/// a little more.
const AT_REST_RAD: f64 = 0.12;

/// An object as it lies.
#[derive(Debug)]
pub struct PosedItem {
    /// Its heightmaps, a view per yaw; at yaw 0 it fills the least rectangle along the axes.
    pub item: Item,
    /// The object's own frame in that of the heightmaps: their origins are the same.
    pub heightmap_from_item: UnitQuaternion<f64>,
}

/// Makes the heightmaps of an object that was seen in a pose (`world_from_item`, the world's z axis
/// up), at each yaw of a resolution. A pose that is nearly one at rest is taken for that: the
/// object stands on something flat.
///
/// # Errors
/// [`ObjectError`] where it has more cells or units than the engine represents.
pub fn posed_item(
    model: &Model,
    world_from_item: &Isometry3<f64>,
    resolution: &Resolution,
) -> Result<PosedItem, ObjectError> {
    let seen = world_from_item.rotation;
    let standing = turn_to_rest(model, &seen, AT_REST_RAD).map_or(seen, |turn| turn * seen);
    let matrix = standing.to_rotation_matrix();
    let vertices = model.mesh.vertices.iter();
    let yaw_rad = least_rectangle_rad(vertices.map(|vertex| (matrix * vertex).xy()));
    let back = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -yaw_rad.unwrap_or(0.0));
    let heightmap_from_item = back * standing;
    Ok(PosedItem {
        item: views::item(&model.turned(&heightmap_from_item), resolution)?,
        heightmap_from_item,
    })
}

#[cfg(test)]
mod tests {
    use nalgebra::Translation3;
    use ppnpack_catalogue::build::{ModelSettings, model};
    use ppnpack_catalogue::mesh::Mesh;

    use super::*;

    #[test]
    fn a_brick_on_its_end_is_as_high_as_it_is_long() {
        let on_end =
            UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::FRAC_PI_2);
        let askew = UnitQuaternion::from_euler_angles(0.03, -0.02, 0.7);
        let seen = Translation3::new(0.2, 0.1, 0.0) * (askew * on_end);
        let brick = Mesh::cuboid([-0.05, -0.03, 0.0], [0.05, 0.03, 0.02]);
        let (brick, _) = model("brick", brick, &ModelSettings::default()).unwrap();
        let posed = posed_item(&brick, &seen, &Resolution::reference()).unwrap();
        let view = &posed.item.views()[0];
        let (short, long) = (view.nx().min(view.ny()), view.nx().max(view.ny()));
        assert_eq!((short, long), (2, 6), "it stands exactly, along the axes");
        assert_eq!(view.height(), 50);
        let down = posed.heightmap_from_item.inverse() * -Vector3::z();
        assert!((down.x.abs() - 1.0).abs() < 1e-9, "{down}");
    }
}
