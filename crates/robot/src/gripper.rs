//! The suction gripper: a cup on a stem on a body, all around the flange's axis.

use nalgebra::Point2;

use crate::parameters::GripperParameters;
use crate::shapes::UprightCylinder;

/// A part of the gripper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum GripperPart {
    /// The suction cup.
    Cup,
    /// The stem that carries it.
    Stem,
    /// Valve and adapter at the flange.
    Body,
}

/// A suction gripper that holds an item: its cup is compressed, and its lip is the tool's tip.
///
/// A cup bulges when it is compressed; a lip radius given with that in mind covers it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gripper {
    parameters: GripperParameters,
}

impl Gripper {
    pub(crate) fn new(parameters: GripperParameters) -> Self {
        Self { parameters }
    }

    /// The radius of the cup's lip, in metres.
    pub fn cup_radius_m(&self) -> f64 {
        self.parameters.cup_radius_m
    }

    /// The distance from the flange to the compressed cup's lip, in metres.
    pub fn length_m(&self) -> f64 {
        let gripper = &self.parameters;
        gripper.body_length_m + gripper.stem_length_m + self.cup_height_m()
    }

    fn cup_height_m(&self) -> f64 {
        self.parameters.cup_height_m - self.parameters.compression_m
    }

    /// The parts with the lip at the origin and the flange above.
    pub fn parts(&self) -> [(GripperPart, UprightCylinder); 3] {
        let gripper = &self.parameters;
        let cup_m = self.cup_height_m();
        let stem_m = cup_m + gripper.stem_length_m;
        let part = |radius_m, lowest_m, highest_m| UprightCylinder {
            axis_m: Point2::origin(),
            radius_m,
            lowest_m,
            highest_m,
        };
        [
            (GripperPart::Cup, part(gripper.cup_radius_m, 0.0, cup_m)),
            (
                GripperPart::Stem,
                part(gripper.stem_radius_m, cup_m, stem_m),
            ),
            (
                GripperPart::Body,
                part(gripper.body_radius_m, stem_m, self.length_m()),
            ),
        ]
    }
}
