//! The parameter file of an arm: TOML, unknown fields refused, every value checked.
//!
//! The file is written in the units of data sheets, metres and degrees, with the unit in each name.

use std::ops::Bound;

use ppnpack_numbers::{SettingError, require, within};
use serde::{Deserialize, Serialize};

use crate::error::ParameterError;

/// A whole parameter file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArmParameters {
    /// The arm's name, for people: 1 to 256 bytes.
    pub name: String,
    /// The most that the flange carries, gripper included, in kilograms.
    pub payload_kg: f64,
    /// Lengths between the joints.
    pub geometry: GeometryParameters,
    /// The joints J1 to J6.
    pub joints: [JointParameters; 6],
    /// The arm's stand, in the container frame.
    pub base: BaseParameters,
    /// The links' collision shapes.
    pub capsules: Vec<CapsuleParameters>,
    /// The gripper on the flange.
    pub gripper: GripperParameters,
}

/// The lengths of an arm with an ortho-parallel basis and a spherical wrist, in metres.
///
/// Source: Brandstötter, Angerer and Hofbaur, *An Analytical Solution of the Inverse Kinematics
/// Problem of Industrial Serial Manipulators with an Ortho-parallel Basis and a Spherical Wrist*,
/// 2014, whose letters these are.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GeometryParameters {
    /// From J1's axis forwards to J2's.
    pub a1_m: f64,
    /// From the upper arm's line to the forearm's, along x of the stretched arm; often negative.
    pub a2_m: f64,
    /// Sideways from J1's axis to the arm's plane.
    pub b_m: f64,
    /// From the base up to J2.
    pub c1_m: f64,
    /// The upper arm: from J2 to J3.
    pub c2_m: f64,
    /// The forearm: from J3 to the wrist's centre.
    pub c3_m: f64,
    /// From the wrist's centre to the flange.
    pub c4_m: f64,
}

/// One joint, in the coordinates of the arm's controller.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointParameters {
    /// The least angle, in degrees.
    pub lowest_deg: f64,
    /// The greatest angle, in degrees.
    pub highest_deg: f64,
    /// The greatest speed, in degrees per second.
    pub speed_deg_per_s: f64,
    /// The greatest acceleration, in degrees per second squared.
    pub acceleration_deg_per_s2: f64,
    /// `sign * angle - zero_deg` is the model's angle, which is 0 where the arm is stretched
    /// straight up.
    pub zero_deg: f64,
    /// 1, or -1 where the joint turns against the model's.
    pub sign: i8,
}

/// The pose of the arm's base in the container frame: turned by roll about x, pitch about y, then
/// yaw about z.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BaseParameters {
    /// The base frame's origin, in metres.
    pub position_m: [f64; 3],
    /// Turn about x, in degrees.
    #[serde(default)]
    pub roll_deg: f64,
    /// Turn about y, in degrees.
    #[serde(default)]
    pub pitch_deg: f64,
    /// Turn about z, in degrees.
    #[serde(default)]
    pub yaw_deg: f64,
}

/// A capsule fixed to a link, given in the base frame with the arm stretched straight up (all model
/// angles 0).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CapsuleParameters {
    /// The link: 0 is the base, `n` is turned by joint `n`.
    pub link: usize,
    /// One end of the axis, in metres.
    pub from_m: [f64; 3],
    /// The other end of the axis, in metres.
    pub to_m: [f64; 3],
    /// The radius, in metres.
    pub radius_m: f64,
}

/// A suction gripper: a cup on a stem on a body, all around the flange's axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GripperParameters {
    /// Radius of the cup's lip, in metres.
    pub cup_radius_m: f64,
    /// Height of the cup when nothing presses on it, in metres.
    pub cup_height_m: f64,
    /// The length that the cup loses while it holds an item, in metres.
    pub compression_m: f64,
    /// Radius of the stem, in metres.
    pub stem_radius_m: f64,
    /// Length of the stem, in metres.
    pub stem_length_m: f64,
    /// Radius of the body at the flange: valve, adapter, in metres.
    pub body_radius_m: f64,
    /// Length of the body, in metres.
    pub body_length_m: f64,
}

impl ArmParameters {
    /// Reads and checks a parameter file.
    ///
    /// # Errors
    /// [`ParameterError`] names the first field that is unknown, missing or not possible.
    pub fn from_toml(text: &str) -> Result<Self, ParameterError> {
        let parameters: Self = toml::from_str(text)?;
        parameters.validate()?;
        Ok(parameters)
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`SettingError`] names the first field that is not possible.
    pub fn validate(&self) -> Result<(), SettingError> {
        // Each planned cycle tells it, in a message that holds no other.
        within("1 to 256 bytes long", 1.0..=256.0)("name", self.name.len() as f64)?;
        positive("payload_kg", self.payload_kg)?;
        self.geometry.validate()?;
        for (index, joint) in self.joints.iter().enumerate() {
            joint.validate(&format!("joints[{index}]"))?;
        }
        self.base.validate()?;
        for (index, capsule) in self.capsules.iter().enumerate() {
            capsule.validate(&format!("capsules[{index}]"))?;
        }
        self.gripper.validate()
    }
}

impl GeometryParameters {
    fn validate(&self) -> Result<(), SettingError> {
        length("geometry.a1_m", self.a1_m)?;
        length("geometry.a2_m", self.a2_m)?;
        length("geometry.b_m", self.b_m)?;
        length("geometry.c1_m", self.c1_m)?;
        size("geometry.c2_m", self.c2_m)?;
        size("geometry.c3_m", self.c3_m)?;
        size("geometry.c4_m", self.c4_m)
    }
}

impl JointParameters {
    fn validate(&self, joint: &str) -> Result<(), SettingError> {
        let field = |name: &str| format!("{joint}.{name}");
        let range = within("within +-720 degrees", -720.0..=720.0);
        range(&field("lowest_deg"), self.lowest_deg)?;
        range(&field("highest_deg"), self.highest_deg)?;
        let above = (Bound::Excluded(self.lowest_deg), Bound::Unbounded);
        within("above lowest_deg", above)(&field("highest_deg"), self.highest_deg)?;
        positive(&field("speed_deg_per_s"), self.speed_deg_per_s)?;
        let acceleration = self.acceleration_deg_per_s2;
        positive(&field("acceleration_deg_per_s2"), acceleration)?;
        turn(&field("zero_deg"), self.zero_deg)?;
        let is_sign = |value: f64| value.abs() == 1.0;
        require(field("sign"), f64::from(self.sign), "1 or -1", is_sign)
    }
}

impl BaseParameters {
    fn validate(&self) -> Result<(), SettingError> {
        point("base.position_m", &self.position_m)?;
        turn("base.roll_deg", self.roll_deg)?;
        turn("base.pitch_deg", self.pitch_deg)?;
        turn("base.yaw_deg", self.yaw_deg)
    }
}

impl CapsuleParameters {
    fn validate(&self, capsule: &str) -> Result<(), SettingError> {
        let field = |name: &str| format!("{capsule}.{name}");
        within("a link from 0 to 6", 0.0..=6.0)(&field("link"), self.link as f64)?;
        point(&field("from_m"), &self.from_m)?;
        point(&field("to_m"), &self.to_m)?;
        size(&field("radius_m"), self.radius_m)
    }
}

impl GripperParameters {
    fn validate(&self) -> Result<(), SettingError> {
        size("gripper.cup_radius_m", self.cup_radius_m)?;
        size("gripper.cup_height_m", self.cup_height_m)?;
        size("gripper.stem_radius_m", self.stem_radius_m)?;
        size("gripper.stem_length_m", self.stem_length_m)?;
        size("gripper.body_radius_m", self.body_radius_m)?;
        size("gripper.body_length_m", self.body_length_m)?;
        let less = "between 0 and less than the cup's height";
        within(less, 0.0..self.cup_height_m)("gripper.compression_m", self.compression_m)
    }
}

fn positive(field: &str, value: f64) -> Result<(), SettingError> {
    require(field, value, "a positive number", |value| value > 0.0)
}

/// Checks a coordinate: lengths beyond 10 m are no arm's.
pub(crate) fn length(field: &str, value: f64) -> Result<(), SettingError> {
    within("within +-10 m", -10.0..=10.0)(field, value)
}

/// Checks a length that is positive.
fn size(field: &str, value: f64) -> Result<(), SettingError> {
    length(field, value)?;
    positive(field, value)
}

/// Checks the coordinates of a point.
pub(crate) fn point(field: &str, point_m: &[f64; 3]) -> Result<(), SettingError> {
    let mut axes = point_m.iter().enumerate();
    axes.try_for_each(|(axis, value)| length(&format!("{field}[{axis}]"), *value))
}

/// Checks an angle of a turn, in degrees.
pub(crate) fn turn(field: &str, value: f64) -> Result<(), SettingError> {
    within("within +-360 degrees", -360.0..=360.0)(field, value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text() -> &'static str {
        crate::arms::text("nachi-mz07l").unwrap()
    }

    /// Gives the refusal of the parameter file when a part of it is replaced.
    fn refusal(from: &str, to: &str) -> String {
        assert!(text().contains(from), "'{from}' is in the file");
        let changed = text().replacen(from, to, 1);
        ArmParameters::from_toml(&changed).unwrap_err().to_string()
    }

    #[test]
    fn wrong_values_are_refused_by_name() {
        for (key, value, wrong, field) in [
            ("payload_kg", "7.0", "0.0", "payload_kg"),
            ("c2_m", "0.420", "-0.420", "geometry.c2_m"),
            ("a1_m", "0.050", "nan", "geometry.a1_m"),
            ("lowest_deg", "-45.0", "171.0", "joints[1].highest_deg"),
            ("lowest_deg", "-45.0", "-1e9", "joints[1].lowest_deg"),
            ("speed_deg_per_s", "360.0", "-1.0", "joints[2].speed"),
            ("acceleration_deg_per_s2", "5000.0", "inf", "joints[5].acc"),
            ("zero_deg", "180.0", "361.0", "joints[5].zero_deg"),
            ("sign", "-1", "2", "joints[1].sign"),
            ("position_m", "[-0.35", "[-350.0", "base.position_m[0]"),
            ("yaw_deg", "0.0", "nan", "base.yaw_deg"),
            ("link", "5", "7", "capsules[5].link"),
            ("radius_m", "0.12", "0.0", "capsules[0].radius_m"),
            (
                "to_m",
                "[0.0, 0.0, 0.1",
                "[0.0, inf, 0.1",
                "capsules[0].to_m[1]",
            ),
            ("cup_radius_m", "0.015", "0.0", "gripper.cup_radius_m"),
            ("compression_m", "0.004", "0.02", "gripper.compression_m"),
        ] {
            let message = refusal(&format!("{key} = {value}"), &format!("{key} = {wrong}"));
            assert!(message.contains(field), "{message} names {field}");
        }
    }

    #[test]
    fn names_that_no_message_holds_are_refused() {
        for bytes in [0, 257] {
            let name = format!("name = \"{}\"", "n".repeat(bytes));
            let message = refusal("name = \"NACHI MZ07L-01\"", &name);
            let expected = format!("name must be 1 to 256 bytes long, but is {bytes}");
            assert_eq!(message, expected);
        }
    }

    #[test]
    fn unknown_and_missing_fields_are_refused_by_name() {
        assert!(refusal("payload_kg = 7.0", "payload_kg = 7.0\nreach_m = 1.0").contains("reach_m"));
        assert!(refusal("c4_m = 0.073", "").contains("c4_m"));
        assert!(refusal("[[joints]]", "[[unused]]").contains("unused"));
    }
}
