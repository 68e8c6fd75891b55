//! Regular and irregular shapes: the paper's Table II compares methods on easy and on hard ones.

use ppnpack_packing::scene::model::Model;

/// The least share of its bounding box that a regular object fills as it stands: boxes, cans and
/// balls do, bowls, cups and tools do not. A ball fills 52 % of its box.
pub const REGULAR_SHARE: f64 = 0.5;

/// How much of its bounding box an object fills.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShapeClass {
    /// At least [`REGULAR_SHARE`] of it.
    Regular,
    /// Less of it.
    Irregular,
}

impl ShapeClass {
    /// Both, the easier one first.
    pub const ALL: [Self; 2] = [Self::Regular, Self::Irregular];

    /// The class of an object in the pose in which it is packed.
    pub fn of(model: &Model) -> Self {
        let bounds = model.mesh.bounds();
        let box_m3 = bounds.map_or(0.0, |bounds| bounds.extents_m().product());
        if model.volume_m3 >= REGULAR_SHARE * box_m3 {
            Self::Regular
        } else {
            Self::Irregular
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{ModelSettings, model};
    use crate::shapes::{ball, cube};

    #[test]
    fn boxes_and_balls_are_regular_and_a_thin_angle_is_not() {
        let class = |mesh| ShapeClass::of(&model("it", mesh, &ModelSettings::default()).unwrap().0);
        assert_eq!(class(cube(0.1)), ShapeClass::Regular);
        assert_eq!(class(ball(0.05, 48, 24)), ShapeClass::Regular);
        let mut angle = crate::mesh::Mesh::cuboid([0.0; 3], [0.1, 0.1, 0.01]);
        angle.append(&crate::mesh::Mesh::cuboid(
            [0.0, 0.0, 0.01],
            [0.01, 0.1, 0.1],
        ));
        assert_eq!(class(angle), ShapeClass::Irregular);
    }
}
