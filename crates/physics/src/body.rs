//! Models as the engine sees them: convex hulls and true mass properties, built once per model.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, SymmetricEigen, UnitQuaternion};
use ppnpack_catalogue::mesh::{Bounds, Mesh};
use ppnpack_catalogue::object::{ConvexPiece, MassProperties, Model};
use rapier3d::geometry::SharedShape;
use rapier3d::math::{Pose, Vector};
use rapier3d::parry::mass_properties::MassProperties as EngineMass;
use rapier3d::parry::query::{ShapeCastOptions, cast_shapes};
use rapier3d::parry::shape::{ConvexPolyhedron, Shape};
use rapier3d::parry::transformation::try_convex_hull;

use crate::convert::{
    engine_inertia, engine_length, engine_pose, engine_rotation, engine_vector, metres, point_m,
};
use crate::error::PhysicsError;
use crate::rolling;

/// Coordinates of a model beyond this are taken for a mistake in its unit, in metres.
const MAX_COORDINATE_M: f64 = 10.0;

/// The least volume of a convex piece: a tenth of a cubic millimetre.
const MIN_PIECE_VOLUME_M3: f64 = 1e-10;

/// Maximum of templates that are kept whether their models are used or not.
const TEMPLATES_KEPT: usize = 256;

/// Hulls and mass that all bodies of one model share.
pub(crate) struct BodyTemplate {
    pub(crate) model: Arc<Model>,
    pieces: Vec<SharedShape>,
    /// The pieces as one: of contacts in one plane, those of a whole body are solved together.
    pub(crate) shape: SharedShape,
    pub(crate) mass: EngineMass,
    /// The distance from the centre of mass to the farthest vertex, in metres.
    pub(crate) radius_m: f64,
    pub(crate) can_roll: bool,
}

impl BodyTemplate {
    fn new(model: &Arc<Model>) -> Result<Self, PhysicsError> {
        let refused = |reason: String| PhysicsError::Model {
            model: model.name.clone(),
            reason,
        };
        if model.pieces.is_empty() {
            return Err(refused("it has no convex piece".to_owned()));
        }
        let hull = |(index, piece)| {
            hull(piece).map_err(|reason| refused(format!("convex piece {index}: {reason}")))
        };
        let pieces = model.pieces.iter().enumerate().map(hull);
        let pieces: Vec<SharedShape> = pieces.collect::<Result<_, _>>()?;
        let mass = engine_mass(&model.mass).map_err(|reason| refused(reason.to_owned()))?;
        let vertices = model.pieces.iter().flat_map(|piece| &piece.vertices);
        let centre_of_mass_m = model.mass.centre_of_mass_m;
        let radius_m = vertices
            .map(|vertex| (vertex - centre_of_mass_m).norm())
            .fold(0.0, f64::max);
        Ok(Self {
            model: Arc::clone(model),
            shape: together(&pieces),
            pieces,
            mass,
            radius_m,
            can_roll: rolling::can_roll(model),
        })
    }

    /// Gives the box around it at a pose, in metres.
    pub(crate) fn bounds(&self, container_from_item: &Isometry3<f64>) -> Bounds {
        let pose = engine_pose(container_from_item);
        // That of the whole shape is around its own box, turned, and larger.
        let boxes = self.pieces.iter().map(|piece| piece.compute_aabb(&pose));
        let corners = boxes.flat_map(|bounds| [bounds.mins, bounds.maxs].map(point_m));
        let corners: Vec<Point3<f64>> = corners.collect();
        let at = container_from_item.translation.vector.into();
        Bounds::of(&corners).unwrap_or(Bounds {
            lowest: at,
            highest: at,
        })
    }

    /// Measures how far it can be lowered before it touches a shape, at most `most_m`, in metres.
    pub(crate) fn clearance_m(
        &self,
        container_from_item: &Isometry3<f64>,
        other: &dyn Shape,
        container_from_other: &Pose,
        most_m: f64,
    ) -> f64 {
        let pose = engine_pose(container_from_item);
        let (down, still) = (Vector::new(0.0, 0.0, -1.0), Vector::ZERO);
        let cast = ShapeCastOptions {
            compute_impact_geometry_on_penetration: false,
            ..ShapeCastOptions::with_max_time_of_impact(engine_length(most_m))
        };
        let hits = self.pieces.iter().map(|piece| {
            let (shape, at) = (&**piece, container_from_other);
            match cast_shapes(&pose, down, shape, at, still, other, cast) {
                Ok(hit) => hit.map_or(most_m, |hit| metres(hit.time_of_impact)),
                // All known shapes can be cast; onto one that cannot, nothing is lowered.
                Err(_) => 0.0,
            }
        });
        hits.fold(most_m, f64::min)
    }
}

/// Joins convex pieces, of which there is at least one, to one shape.
fn together(pieces: &[SharedShape]) -> SharedShape {
    match pieces {
        [piece] => piece.clone(),
        pieces => {
            let posed = pieces.iter().map(|piece| (Pose::IDENTITY, piece.clone()));
            SharedShape::compound(posed.collect())
        }
    }
}

/// Says whether a point is finite and within [`MAX_COORDINATE_M`] of the origin.
fn is_sane(point: &Point3<f64>) -> bool {
    point.iter().all(|value| value.abs() <= MAX_COORDINATE_M)
}

/// Makes the hull of a piece.
///
/// The engine's own constructor panics on points without volume; this one says what is wrong.
pub(crate) fn hull(piece: &ConvexPiece) -> Result<SharedShape, String> {
    if !piece.vertices.iter().all(is_sane) {
        return Err(format!(
            "a vertex is further than {MAX_COORDINATE_M} m away or not finite"
        ));
    }
    let vertices = piece.vertices.iter();
    let points: Vec<Vector> = vertices
        .map(|vertex| engine_vector(&vertex.coords))
        .collect();
    if points.len() < 4 {
        return Err(format!("{} vertices enclose no volume", points.len()));
    }
    let (vertices, triangles) = try_convex_hull(&points).map_err(|error| error.to_string())?;
    // The engine takes a flat hull, but finds no depth by which to push it out of what it lies in.
    let hull = Mesh {
        vertices: vertices.iter().copied().map(point_m).collect(),
        triangles,
    };
    if hull.signed_volume_m3().abs() < MIN_PIECE_VOLUME_M3 {
        return Err("its vertices enclose no volume".to_owned());
    }
    ConvexPolyhedron::from_convex_mesh(vertices, &hull.triangles)
        .map(SharedShape::new)
        .ok_or_else(|| "its hull is degenerate".to_owned())
}

/// Converts mass properties to the engine's.
///
/// The principal axes are found in double precision: inertias of small items are near 1e-8 kg m^2,
/// where the engine's own single-precision solver loses them.
fn engine_mass(mass: &MassProperties) -> Result<EngineMass, &'static str> {
    if !(mass.mass_kg.is_finite() && mass.mass_kg > 0.0) {
        return Err("its mass is not a positive number");
    }
    if !is_sane(&mass.centre_of_mass_m) {
        return Err("its centre of mass is far away or not finite");
    }
    let inertia = mass.inertia_kg_m2;
    let symmetric: Matrix3<f64> = (inertia + inertia.transpose()) * 0.5;
    if !symmetric.iter().all(|value| value.is_finite()) {
        return Err("its inertia is not finite");
    }
    let eigen = SymmetricEigen::try_new(symmetric, f64::EPSILON, 1000)
        .ok_or("its inertia has no principal axes")?;
    if eigen.eigenvalues.min() <= 0.0 {
        return Err("its inertia is not positive");
    }
    let mut axes = eigen.eigenvectors;
    if axes.determinant() < 0.0 {
        axes = -axes;
    }
    let axes = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    let engine = EngineMass::with_principal_inertia_frame(
        engine_vector(&mass.centre_of_mass_m.coords),
        mass.mass_kg as f32,
        engine_inertia(&eigen.eigenvalues),
        engine_rotation(&axes),
    );
    let is_usable = engine.inv_mass.is_finite() && engine.inv_principal_inertia.is_finite();
    is_usable
        .then_some(engine)
        .ok_or("its mass or inertia is too small")
}

/// Templates by model, so that hulls are built once per model and not per body.
///
/// The key is the model's address, which stays its own because the template owns the model.
#[derive(Clone, Default)]
pub(crate) struct Templates(HashMap<usize, Arc<BodyTemplate>>);

impl Templates {
    /// Gives the template of a model, built where it is new.
    pub(crate) fn of(&mut self, model: &Arc<Model>) -> Result<Arc<BodyTemplate>, PhysicsError> {
        Ok(Arc::clone(match self.0.entry(Arc::as_ptr(model).addr()) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => new.insert(Arc::new(BodyTemplate::new(model)?)),
        }))
    }

    /// Forgets the templates of models that nobody else has, where there are many.
    pub(crate) fn tidy(&mut self) {
        if self.0.len() > TEMPLATES_KEPT {
            self.0
                .retain(|_, known| Arc::strong_count(&known.model) > 1);
        }
    }
}
