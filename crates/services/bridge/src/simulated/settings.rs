//! Settings of a simulated cell.

use ppnpack_numbers::settings;
use ppnpack_physics::settings::CellSettings;
use ppnpack_physics::view::CameraSettings;
use ppnpack_service::configuration::in_range;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;

use crate::remote::RemoteSettings;

/// The maximum pitch of an exact scan, in metres: that of the samples of perception's surfaces.
const MAX_PITCH_M: f64 = 0.0025;

settings! {
    /// A cell: simulated, or with a robot that is a program of its own.
    pub struct SimulatedSettings {
        /// The container, the release and settling of items, and the solver. The defaults are those
        /// of a robot that lays items down.
        #[serde(deserialize_with = "over_robot")]
        pub physics: CellSettings = CellSettings::robot(),
        /// The time for a placement that comes without an arm's motion, in seconds.
        pub place_duration_s: f64 = 0.0,
        /// The speed of a placement's motion: 1 as it was planned, 2 in half of the time, 0 without
        /// any wait.
        pub motion_speed: f64 = 1.0,
        /// The faults that happen.
        pub faults: FaultSettings = FaultSettings::default(),
        /// The way in which the sensor sees the container.
        pub scan: Scan = Scan::default(),
        /// The pitch of an exact scan, in metres. Perception's heightmap is exact where this is the
        /// pitch of its grid's surface: 0.0025 for cells that are a multiple of 2.5 mm.
        pub scan_pitch_m: f64 = MAX_PITCH_M,
        /// The cameras, where the container is seen by any.
        pub camera: CameraSettings = CameraSettings::default(),
        /// Whether the sensor does not know the state of the cell, as cameras of ROS 2 do not.
        pub is_stateless: bool = false,
        /// The robot, where it is a program of its own: of the others only the container counts
        /// then.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub remote: Option<RemoteSettings> = None,
    }
}

/// Faults that happen on purpose, drawn per placement.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FaultSettings {
    /// The share of placements at which the gripper misses the item, which stays where it is.
    pub missed_picks: f64,
    /// The share of placements at which the gripper drops the item beside the container.
    pub drops: f64,
    /// The seed of the draws.
    pub seed: u64,
}

/// A way in which the sensor sees the container.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scan {
    /// The greatest height of the content around each point, on a regular grid.
    #[default]
    Exact,
    /// A depth camera above the middle of the container.
    Camera,
}

impl SimulatedSettings {
    /// Checks that every number is possible.
    pub(crate) fn validate(&self) -> Result<(), String> {
        self.physics
            .validate()
            .map_err(|error| format!("physics: {error}"))?;
        in_range("place_duration_s", self.place_duration_s, 0.0..=3600.0)?;
        in_range("motion_speed", self.motion_speed, 0.0..=1000.0)?;
        in_range("faults.missed_picks", self.faults.missed_picks, 0.0..=1.0)?;
        in_range("faults.drops", self.faults.drops, 0.0..=1.0)?;
        if self.faults.missed_picks + self.faults.drops > 1.0 {
            return Err("faults: the shares add up to more than 1".to_owned());
        }
        if !(self.scan_pitch_m > 0.0 && self.scan_pitch_m <= MAX_PITCH_M) {
            return Err(format!(
                "scan_pitch_m is {} where above 0 and at most {MAX_PITCH_M} m is possible",
                self.scan_pitch_m
            ));
        }
        super::view::View::new(self)
            .map(drop)
            .map_err(|error| error.to_string())
    }
}

/// Reads settings of the simulation over those of a robot, which are not the type's own defaults.
fn over_robot<'de, D: Deserializer<'de>>(deserializer: D) -> Result<CellSettings, D::Error> {
    let over = Value::deserialize(deserializer)?;
    let settings = CellSettings::robot().overlaid(over);
    settings.map_err(serde::de::Error::custom)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_out_is_that_of_a_robot() {
        let text = r#"{"physics": {"release": {"jitter_m": 0.001}}, "faults": {"drops": 0.1}}"#;
        let settings: SimulatedSettings = serde_json::from_str(text).unwrap();
        let mut expected = SimulatedSettings::default();
        expected.physics.release.jitter_m = 0.001;
        expected.faults.drops = 0.1;
        assert_eq!(settings, expected);
        settings.validate().unwrap();
        let written = serde_json::to_string(&settings).unwrap();
        let read: SimulatedSettings = serde_json::from_str(&written).unwrap();
        assert_eq!(read, settings);
        for unknown in [r#"{"physics": {"relase": {}}}"#, r#"{"phisics": {}}"#] {
            assert!(serde_json::from_str::<SimulatedSettings>(unknown).is_err());
        }
    }

    #[test]
    fn impossible_numbers_are_named() {
        let refused = |change: fn(&mut SimulatedSettings)| {
            let mut settings = SimulatedSettings::default();
            change(&mut settings);
            settings.validate().unwrap_err()
        };
        assert!(refused(|s| s.physics.container.x_m = -1.0).contains("x side"));
        assert!(refused(|s| s.place_duration_s = f64::NAN).contains("place_duration_s"));
        assert!(refused(|s| s.faults.drops = 1.1).contains("drops"));
        assert!(refused(|s| s.scan_pitch_m = 0.01).contains("scan_pitch_m"));
        type Change = fn(&mut CameraSettings);
        let cameras: [(Change, &str); 8] = [
            (|it| it.height_m = 0.2, "height_m"),
            (|it| it.height_m = f64::NAN, "height_m"),
            (|it| it.cameras = 3, "cameras"),
            (|it| it.width_px = 0, "width"),
            (|it| it.height_px = 1 << 40, "height"),
            (|it| it.noise.sigma_m = -1.0, "camera.noise.sigma_m"),
            (|it| it.noise.dropout = 1.5, "camera.noise.dropout"),
            (|it| it.noise.step_m = f64::NAN, "camera.noise.step_m"),
        ];
        for (change, named) in cameras {
            let mut settings = SimulatedSettings {
                scan: Scan::Camera,
                ..SimulatedSettings::default()
            };
            change(&mut settings.camera);
            let refusal = settings.validate().unwrap_err();
            assert!(refusal.contains(named), "{refusal}");
        }
        let both = refused(|s| (s.faults.drops, s.faults.missed_picks) = (0.6, 0.6));
        assert!(both.contains("more than 1"));
    }
}
