//! Solids that roll: balls, cylinders and cones that lie on their sides, pencils and tools with
//! rounded handles.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;
use ppnpack_packing::scene::model::Model;

/// Minimum turn of a solid that has rolled, in radians: from there on it counts as toppled.
const ROLLED_RAD: f64 = PI / 6.0;

/// Maximum rise of the centre of mass of what rolls, as a share of its height: that of a lying
/// octagonal prism, 1 / cos(pi / 8) - 1.
const MOST_RISE: f64 = 0.083;

/// Number of directions around the vertical that are tried.
const DIRECTIONS: usize = 24;

/// Number of steps in which a solid is turned.
const STEPS: usize = 6;

/// Says whether a solid rolls on a floor from the pose in which it stands.
///
/// It does where it can turn by 30 degrees in some direction, touching the floor, while its centre
/// of mass hardly rises. So does what tips over by itself, as its centre of mass is beside its
/// foot.
pub(crate) fn can_roll(model: &Model) -> bool {
    let centre = model.mass.centre_of_mass_m;
    let vertices = model.pieces.iter().flat_map(|piece| &piece.vertices);
    let vertices: Vec<Vector3<f64>> = vertices.map(|vertex| vertex - centre).collect();
    let height_m = |down: &Vector3<f64>| {
        let below = vertices.iter().map(|vertex| vertex.dot(down));
        below.fold(0.0, f64::max)
    };
    let standing_m = height_m(&-Vector3::z());
    let hardly_rises = |direction: usize| {
        let (sin, cos) = (TAU * direction as f64 / DIRECTIONS as f64).sin_cos();
        let mut turns = (1..=STEPS).map(|step| ROLLED_RAD * step as f64 / STEPS as f64);
        turns.all(|turn| {
            let aside = Vector3::new(cos, sin, 0.0) * turn.sin();
            let down = aside - Vector3::z() * turn.cos();
            height_m(&down) <= (1.0 + MOST_RISE) * standing_m
        })
    };
    (0..DIRECTIONS).any(hardly_rises)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Point3, UnitQuaternion};
    use ppnpack_packing::scene::model::mesh::Mesh;
    use ppnpack_packing::scene::model::{ConvexPiece, MassProperties};

    use super::*;

    /// A solid of these vertices about its centre of mass.
    fn solid(vertices: Vec<Point3<f64>>) -> Model {
        Model {
            name: "solid".to_owned(),
            mesh: Mesh::default(),
            volume_m3: 1e-3,
            pieces: vec![ConvexPiece { vertices }],
            mass: MassProperties {
                mass_kg: 1.0,
                centre_of_mass_m: Point3::origin(),
                inertia_kg_m2: Matrix3::identity(),
            },
            carries_kg: None,
            resting_poses: Vec::new(),
        }
    }

    /// A prism of so many sides that lies on one of them along x.
    fn prism(sides: usize, radius_m: f64, length_m: f64) -> Model {
        let corner = |index: usize| {
            let angle = TAU * (index as f64 + 0.5) / sides as f64 - PI / 2.0;
            [-1.0, 1.0].map(|end| {
                let (sin, cos) = angle.sin_cos();
                Point3::new(end * length_m / 2.0, radius_m * cos, radius_m * sin)
            })
        };
        solid((0..sides).flat_map(corner).collect())
    }

    /// A ball whose surface has some hundred flat places.
    fn ball(radius_m: f64) -> Model {
        let at = |index: usize| {
            let height = 1.0 - (2 * index + 1) as f64 / 400.0;
            let around = (index as f64) * PI * (3.0 - 5.0_f64.sqrt());
            let flat = (1.0 - height * height).sqrt();
            Point3::new(flat * around.cos(), flat * around.sin(), height) * radius_m
        };
        solid((0..400).map(at).collect())
    }

    #[test]
    fn what_is_round_the_way_it_lies_rolls_and_nothing_else_does() {
        assert!(can_roll(&ball(0.03)));
        assert!(can_roll(&prism(8, 0.01, 0.1)));
        assert!(can_roll(&prism(30, 0.01, 0.1)));
        // A pencil stays on its side.
        assert!(!can_roll(&prism(6, 0.01, 0.1)));
        assert!(!can_roll(&prism(4, 0.05, 0.1)));
        let up = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), PI / 2.0);
        let can = prism(30, 0.03, 0.1).turned(&up);
        assert!(!can_roll(&can), "it stands");
    }
}
