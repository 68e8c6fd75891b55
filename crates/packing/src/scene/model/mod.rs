//! The solid of an object, independent of any grid: what arms, simulations and pictures need of it.

pub mod mesh;
pub mod raster;

use nalgebra::{Matrix3, Point3, UnitQuaternion};
use serde::{Deserialize, Serialize};

use mesh::Mesh;

/// A convex piece of an object: the vertices of its hull in the item frame, in metres.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ConvexPiece {
    /// Hull vertices, in metres.
    pub vertices: Vec<Point3<f64>>,
}

/// Mass, centre of mass and inertia of an object of uniform density.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MassProperties {
    /// Mass, in kilograms.
    pub mass_kg: f64,
    /// Centre of mass in the item frame, in metres.
    pub centre_of_mass_m: Point3<f64>,
    /// Inertia about the centre of mass along the item frame's axes, in kg m^2.
    pub inertia_kg_m2: Matrix3<f64>,
}

/// A pose in which an object rests on a flat floor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RestingPose {
    /// Turns the item frame so that the resting face points down.
    pub rotation: UnitQuaternion<f64>,
    /// The chance of ending so when tossed: solid angle of the faces that roll onto it, over 4 pi.
    pub probability: f64,
}

/// The geometry of an object, independent of any grid, in the mesh's own frame, in metres, z up.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Model {
    /// Unique within its catalogue.
    pub name: String,
    /// The closed surface, in the item frame; it stands in the pose in which it is packed.
    pub mesh: Mesh,
    /// Its volume, in cubic metres.
    pub volume_m3: f64,
    /// At most eight convex pieces that together approximate it.
    pub pieces: Vec<ConvexPiece>,
    /// Mass properties of the mesh.
    pub mass: MassProperties,
    /// The greatest mass that may rest on it, in kilograms, where that is known.
    pub carries_kg: Option<f64>,
    /// Resting poses, the most probable first.
    pub resting_poses: Vec<RestingPose>,
}

impl Model {
    /// The same object standing otherwise: all of it turned about the origin of the item frame.
    #[must_use]
    pub fn turned(&self, rotation: &UnitQuaternion<f64>) -> Self {
        let matrix = rotation.to_rotation_matrix();
        let pieces = self.pieces.iter().map(|piece| ConvexPiece {
            vertices: piece.vertices.iter().map(|at| matrix * at).collect(),
        });
        let back = rotation.inverse();
        let resting_poses = self.resting_poses.iter().map(|pose| RestingPose {
            rotation: pose.rotation * back,
            probability: pose.probability,
        });
        Self {
            name: self.name.clone(),
            mesh: self.mesh.transformed(&nalgebra::convert(*rotation)),
            volume_m3: self.volume_m3,
            pieces: pieces.collect(),
            mass: MassProperties {
                mass_kg: self.mass.mass_kg,
                centre_of_mass_m: matrix * self.mass.centre_of_mass_m,
                inertia_kg_m2: matrix * self.mass.inertia_kg_m2 * matrix.inverse(),
            },
            carries_kg: self.carries_kg,
            resting_poses: resting_poses.collect(),
        }
    }
}
