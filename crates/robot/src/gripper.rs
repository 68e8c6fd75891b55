//! The shape of the suction gripper: a cup on a stem on a body, all around the flange's axis.

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

/// The gripper while it holds an item: its cup is compressed, and its lip is the tool's tip.
///
/// A cup bulges when it is compressed; a lip radius given with that in mind covers it.
impl GripperParameters {
    /// Gives the distance from the flange to the compressed cup's lip, in metres.
    pub fn length_m(&self) -> f64 {
        self.body_length_m + self.stem_length_m + self.compressed_cup_m()
    }

    fn compressed_cup_m(&self) -> f64 {
        self.cup_height_m - self.compression_m
    }

    /// Gives the parts with the lip at the origin and the flange above.
    pub fn parts(&self) -> [(GripperPart, UprightCylinder); 3] {
        let cup_m = self.compressed_cup_m();
        let stem_m = cup_m + self.stem_length_m;
        let length_m = self.length_m();
        let part = |part, radius_m, lowest_m, highest_m| {
            let shape = UprightCylinder {
                axis_m: Point2::origin(),
                radius_m,
                lowest_m,
                highest_m,
            };
            (part, shape)
        };
        [
            part(GripperPart::Cup, self.cup_radius_m, 0.0, cup_m),
            part(GripperPart::Stem, self.stem_radius_m, cup_m, stem_m),
            part(GripperPart::Body, self.body_radius_m, stem_m, length_m),
        ]
    }
}
