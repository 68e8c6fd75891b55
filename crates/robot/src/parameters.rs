//! The parameter file of an arm: TOML, unknown fields refused, every value checked.
//!
//! The file is written in the units of data sheets, metres and degrees, with the unit in each name.

use ppnpack_numbers::{SettingError, require};
use serde::{Deserialize, Serialize};

use crate::error::ParameterError;

/// Lengths beyond this are no arm's, in metres.
const MAX_LENGTH_M: f64 = 10.0;

/// A whole parameter file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArmParameters {
    /// The arm's name, for people.
    pub name: String,
    /// What the flange carries at most, gripper included, in kilograms.
    pub payload_kg: f64,
    /// Lengths between the joints.
    pub geometry: GeometryParameters,
    /// The joints J1 to J6.
    pub joints: [JointParameters; 6],
    /// Where the arm stands, in the container frame.
    pub base: BaseParameters,
    /// The links' collision shapes.
    pub capsules: Vec<CapsuleParameters>,
    /// The gripper on the flange.
    pub gripper: GripperParameters,
}

/// The lengths of an arm with an ortho-parallel basis and a spherical wrist, in metres.
///
/// Source: Brandstötter, Angerer and Hofbaur, *An Analytical Solution of the Inverse Kinematics Problem of Industrial
/// Serial Manipulators with an Ortho-parallel Basis and a Spherical Wrist*, 2014, whose letters these are.
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
    /// `sign * angle - zero_deg` is the model's angle, which is 0 where the arm is stretched straight up.
    pub zero_deg: f64,
    /// 1, or -1 where the joint turns against the model's.
    pub sign: i8,
}

/// The pose of the arm's base in the container frame: turned by roll about x, pitch about y, then yaw about z.
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

/// A capsule fixed to a link, given in the base frame with the arm stretched straight up (all model angles 0).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CapsuleParameters {
    /// The link: 0 is the base, `n` what joint `n` turns.
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
    /// How much shorter the cup is while it holds an item, in metres.
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
        positive("payload_kg", self.payload_kg)?;
        self.geometry.validate()?;
        for (index, joint) in self.joints.iter().enumerate() {
            joint.validate(index)?;
        }
        self.base.validate()?;
        for (index, capsule) in self.capsules.iter().enumerate() {
            capsule.validate(index)?;
        }
        self.gripper.validate()
    }
}

impl GeometryParameters {
    fn validate(&self) -> Result<(), SettingError> {
        for (name, value) in [("a1_m", self.a1_m), ("a2_m", self.a2_m), ("b_m", self.b_m)] {
            length(&format!("geometry.{name}"), value)?;
        }
        length("geometry.c1_m", self.c1_m)?;
        for (name, value) in [
            ("c2_m", self.c2_m),
            ("c3_m", self.c3_m),
            ("c4_m", self.c4_m),
        ] {
            let name = format!("geometry.{name}");
            length(&name, value)?;
            positive(&name, value)?;
        }
        Ok(())
    }
}

impl JointParameters {
    fn validate(&self, index: usize) -> Result<(), SettingError> {
        let field = |name: &str| format!("joints[{index}].{name}");
        for (name, value) in [
            ("lowest_deg", self.lowest_deg),
            ("highest_deg", self.highest_deg),
        ] {
            require(field(name), value, "within +-720 degrees", |value| {
                value.abs() <= 720.0
            })?;
        }
        require(
            field("highest_deg"),
            self.highest_deg,
            "above lowest_deg",
            |value| value > self.lowest_deg,
        )?;
        positive(&field("speed_deg_per_s"), self.speed_deg_per_s)?;
        positive(
            &field("acceleration_deg_per_s2"),
            self.acceleration_deg_per_s2,
        )?;
        require(
            field("zero_deg"),
            self.zero_deg,
            "within +-360 degrees",
            |value| value.abs() <= 360.0,
        )?;
        require(field("sign"), f64::from(self.sign), "1 or -1", |value| {
            value.abs() == 1.0
        })?;
        Ok(())
    }
}

impl BaseParameters {
    fn validate(&self) -> Result<(), SettingError> {
        for (axis, value) in self.position_m.iter().enumerate() {
            length(&format!("base.position_m[{axis}]"), *value)?;
        }
        for (name, value) in [
            ("roll_deg", self.roll_deg),
            ("pitch_deg", self.pitch_deg),
            ("yaw_deg", self.yaw_deg),
        ] {
            require(
                format_args!("base.{name}"),
                value,
                "within +-360 degrees",
                |value| value.abs() <= 360.0,
            )?;
        }
        Ok(())
    }
}

impl CapsuleParameters {
    fn validate(&self, index: usize) -> Result<(), SettingError> {
        let field = |name: &str| format!("capsules[{index}].{name}");
        require(
            field("link"),
            self.link as f64,
            "a link from 0 to 6",
            |value| value <= 6.0,
        )?;
        for (name, point) in [("from_m", &self.from_m), ("to_m", &self.to_m)] {
            for (axis, value) in point.iter().enumerate() {
                length(&field(&format!("{name}[{axis}]")), *value)?;
            }
        }
        length(&field("radius_m"), self.radius_m)?;
        positive(&field("radius_m"), self.radius_m)
    }
}

impl GripperParameters {
    fn validate(&self) -> Result<(), SettingError> {
        for (name, value) in [
            ("cup_radius_m", self.cup_radius_m),
            ("cup_height_m", self.cup_height_m),
            ("stem_radius_m", self.stem_radius_m),
            ("stem_length_m", self.stem_length_m),
            ("body_radius_m", self.body_radius_m),
            ("body_length_m", self.body_length_m),
        ] {
            let name = format!("gripper.{name}");
            length(&name, value)?;
            positive(&name, value)?;
        }
        require(
            "gripper.compression_m",
            self.compression_m,
            "between 0 and less than the cup's height",
            |value| (0.0..self.cup_height_m).contains(&value),
        )?;
        Ok(())
    }
}

fn positive(field: &str, value: f64) -> Result<(), SettingError> {
    require(field, value, "a positive number", |value| value > 0.0)?;
    Ok(())
}

fn length(field: &str, value: f64) -> Result<(), SettingError> {
    require(field, value, "within +-10 m", |value| {
        value.abs() <= MAX_LENGTH_M
    })?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text() -> &'static str {
        crate::arms::text("nachi-mz07l").unwrap()
    }

    /// What the parameter file is refused for when a part of it is replaced.
    fn refusal(from: &str, to: &str) -> String {
        assert!(text().contains(from), "'{from}' is in the file");
        let changed = text().replacen(from, to, 1);
        ArmParameters::from_toml(&changed).unwrap_err().to_string()
    }

    #[test]
    fn wrong_values_are_refused_by_name() {
        for (from, to, field) in [
            ("payload_kg = 7.0", "payload_kg = 0.0", "payload_kg"),
            ("c2_m = 0.420", "c2_m = -0.420", "geometry.c2_m"),
            ("a1_m = 0.050", "a1_m = nan", "geometry.a1_m"),
            (
                "lowest_deg = -45.0",
                "lowest_deg = 171.0",
                "joints[1].highest_deg",
            ),
            (
                "lowest_deg = -45.0",
                "lowest_deg = -1e9",
                "joints[1].lowest_deg",
            ),
            (
                "speed_deg_per_s = 360.0",
                "speed_deg_per_s = -1.0",
                "joints[2].speed_deg_per_s",
            ),
            (
                "acceleration_deg_per_s2 = 5000.0",
                "acceleration_deg_per_s2 = inf",
                "joints[5].acceleration_deg_per_s2",
            ),
            ("zero_deg = 180.0", "zero_deg = 361.0", "joints[5].zero_deg"),
            ("sign = -1", "sign = 2", "joints[1].sign"),
            (
                "position_m = [-0.35",
                "position_m = [-350.0",
                "base.position_m[0]",
            ),
            ("yaw_deg = 0.0", "yaw_deg = nan", "base.yaw_deg"),
            ("link = 5", "link = 7", "capsules[5].link"),
            ("radius_m = 0.12", "radius_m = 0.0", "capsules[0].radius_m"),
            (
                "to_m = [0.0, 0.0, 0.17]",
                "to_m = [0.0, inf, 0.17]",
                "capsules[0].to_m[1]",
            ),
            (
                "cup_radius_m = 0.015",
                "cup_radius_m = 0.0",
                "gripper.cup_radius_m",
            ),
            (
                "compression_m = 0.004",
                "compression_m = 0.02",
                "gripper.compression_m",
            ),
        ] {
            let message = refusal(from, to);
            assert!(message.contains(field), "{message} names {field}");
        }
    }

    #[test]
    fn unknown_and_missing_fields_are_refused_by_name() {
        assert!(refusal("payload_kg = 7.0", "payload_kg = 7.0\nreach_m = 1.0").contains("reach_m"));
        assert!(refusal("c4_m = 0.073", "").contains("c4_m"));
        assert!(refusal("[[joints]]", "[[unused]]").contains("unused"));
    }
}
