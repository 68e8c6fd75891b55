//! How an item lies, against how it was to lie.

use nalgebra::{Isometry3, Point3, Unit, UnitQuaternion, Vector3};
use ppnpack_packing::grid::ContainerSize;

use crate::expected::Agreement;
use crate::inspection::InspectionSettings;
use crate::inspection::changes::Changes;
use crate::library::LibraryObject;
use crate::symmetry::Symmetry;

/// An item that was found in the container, against how it was planned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lying {
    /// Its item frame in the container frame.
    pub container_from_item: Isometry3<f64>,
    /// The horizontal distance of its centre from the planned one, in metres. The centre is the centre of mass; of an
    /// object that nearly looks the same after some turns, the point that they leave in place.
    pub slide_m: f64,
    /// How much higher its centre is than planned, in metres.
    pub rise_m: f64,
    /// By how much it is tilted from the planned pose, whatever its yaw, modulo its near symmetry; in radians.
    pub tilt_rad: f64,
    /// The whole angle from the planned orientation, modulo its near symmetry, in radians.
    pub turn_rad: f64,
    /// Whether its centre of mass lies within the walls and below the rim.
    pub is_inside: bool,
    /// How well it agrees with what is seen.
    pub agreement: Agreement,
}

/// What an item did that was placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    AsPlanned,
    Moved,
    Toppled,
}

impl Lying {
    pub(crate) fn new(
        object: &LibraryObject,
        planned: &Isometry3<f64>,
        found: &Isometry3<f64>,
        container: ContainerSize,
        agreement: Agreement,
    ) -> Self {
        let apart = found * object.centre_m - planned * object.centre_m;
        let symmetry = &object.near_symmetry;
        Self {
            container_from_item: *found,
            slide_m: apart.xy().norm(),
            rise_m: apart.z,
            tilt_rad: tilt_rad(symmetry, &planned.rotation, &found.rotation),
            turn_rad: symmetry.angle_between(&found.rotation, &planned.rotation),
            is_inside: is_inside(&(found * object.model.mass.centre_of_mass_m), container),
            agreement,
        }
    }

    pub(crate) fn kind(&self, settings: &InspectionSettings) -> Kind {
        if self.tilt_rad > settings.topple_rad {
            Kind::Toppled
        } else if self.slide_m > settings.slide_m
            || self.rise_m.abs() > settings.rise_m
            || self.turn_rad > settings.turn_rad
        {
            Kind::Moved
        } else {
            Kind::AsPlanned
        }
    }
}

fn is_inside(point: &Point3<f64>, container: ContainerSize) -> bool {
    (0.0..=container.x_m).contains(&point.x)
        && (0.0..=container.y_m).contains(&point.y)
        && point.z <= container.z_m
}

/// The least angle between the vertical and the direction that is upright in the planned pose, over all turns that
/// nearly look the same.
fn tilt_rad(
    symmetry: &Symmetry,
    planned: &UnitQuaternion<f64>,
    found: &UnitQuaternion<f64>,
) -> f64 {
    let vertical = Vector3::z_axis();
    let upright = Unit::new_unchecked(planned.inverse() * *vertical);
    match symmetry {
        Symmetry::Ball => 0.0,
        Symmetry::Axis {
            axis,
            is_reversible,
        } => {
            let was_rad = axis.angle(&upright);
            let is_rad = (found * axis).angle(&vertical);
            let apart_rad = (is_rad - was_rad).abs();
            if *is_reversible {
                apart_rad.min((std::f64::consts::PI - is_rad - was_rad).abs())
            } else {
                apart_rad
            }
        }
        Symmetry::Turns(turns) => turns
            .iter()
            .map(|turn| (found * (turn * upright)).angle(&vertical))
            .fold(std::f64::consts::PI, f64::min),
    }
}

/// How deep a surface may lie in the floor, in what was there, and in the walls, in metres.
const SUNK_M: f64 = 0.008;

/// The greatest share of the surface that lies deeper.
const MOST_SUNK: f64 = 0.08;

/// An item this far above everything below it does not rest on it, in metres.
const FLOATING_M: f64 = 0.015;

/// Whether a pose is possible among what was there: neither in the floor, the walls or the content, nor in the air.
pub(crate) fn is_possible(
    object: &LibraryObject,
    container_from_item: &Isometry3<f64>,
    changes: &Changes<'_>,
    container: ContainerSize,
) -> bool {
    let rotation = container_from_item.rotation.to_rotation_matrix();
    let shift = container_from_item.translation.vector;
    let (mut sunk, mut gap_m) = (0_u32, f64::INFINITY);
    for point in &object.points {
        let place = rotation * point.point + shift;
        let beyond_m = (-place.x)
            .max(-place.y)
            .max(place.x - container.x_m)
            .max(place.y - container.y_m);
        let is_in_wall = beyond_m > SUNK_M && place.z < container.z_m - SUNK_M;
        let content_m = changes.certain_at(place.x, place.y).unwrap_or(0.0);
        sunk += u32::from(is_in_wall || place.z < content_m - SUNK_M);
        // On what is unknown, and on the rim, anything may rest.
        let below_m = changes.blurred_at(place.x, place.y);
        gap_m = gap_m.min(below_m.map_or(0.0, |below_m| place.z - below_m));
    }
    f64::from(sunk) <= MOST_SUNK * object.points.len() as f64 && gap_m <= FLOATING_M
}
