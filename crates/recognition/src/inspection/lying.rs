//! The pose of an item against the planned one.

use std::f64::consts::PI;

use nalgebra::{Isometry3, Point3, Unit, UnitQuaternion, Vector3};
use ppnpack_packing::kernel::grid::ContainerSize;

use crate::expected::Agreement;
use crate::inspection::settings::InspectionSettings;
use crate::object::LibraryObject;
use crate::symmetry::Symmetry;

/// An item that was found in the container, against how it was planned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lying {
    /// Its item frame in the container frame.
    pub container_from_item: Isometry3<f64>,
    /// The horizontal distance of its centre from the planned one, in metres. The centre is the
    /// centre of mass; of an object that nearly looks the same after some turns, the point that
    /// they leave in place.
    pub slide_m: f64,
    /// The height of its centre above the planned one, in metres.
    pub rise_m: f64,
    /// The tilt from the planned pose, whatever its yaw, modulo its near symmetry; in radians.
    pub tilt_rad: f64,
    /// The whole angle from the planned orientation, modulo its near symmetry, in radians.
    pub turn_rad: f64,
    /// Whether its centre of mass lies within the walls and below the rim.
    pub is_inside: bool,
    /// Its agreement with what is seen.
    pub agreement: Agreement,
}

/// A kind of change of an item that was placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    AsPlanned,
    Moved,
    Toppled,
}

impl Lying {
    pub(crate) fn new(
        object: &LibraryObject,
        [planned, found]: [&Isometry3<f64>; 2],
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
    container.holds(point, 0.0) && point.z <= container.z_m
}

/// Gives the least angle between the vertical and the direction that is upright in the planned
/// pose, over all turns that nearly look the same.
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
            let reversed_rad = is_reversible.then_some((PI - is_rad - was_rad).abs());
            reversed_rad.map_or(apart_rad, |reversed_rad| apart_rad.min(reversed_rad))
        }
        Symmetry::Turns(turns) => {
            let angles_rad = turns.iter();
            let angles_rad = angles_rad.map(|turn| (found * (turn * upright)).angle(&vertical));
            angles_rad.fold(PI, f64::min)
        }
    }
}
