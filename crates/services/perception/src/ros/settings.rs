//! Settings of cameras whose drivers publish clouds as ROS 2 does.

use std::collections::BTreeSet;

use nalgebra::Isometry3;
use ppnpack_catalogue::unit::LengthUnit;
use ppnpack_perception::extrinsics::Extrinsics;
use ppnpack_wire::keys::{Cell, everything};
use ppnpack_wire::ros::topic;
use serde::{Deserialize, Serialize};
use zenoh::key_expr::KeyExpr;

use crate::sensors::Sensors;

/// A camera whose driver publishes clouds as ROS 2 does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RosCamera {
    /// The key expression that its clouds come on: `<domain>/<topic>/**` over `rmw_zenoh`, the
    /// topic's name without its first slash through the bridge of ROS 2 over DDS.
    pub key: String,
    /// The cell that it looks at.
    pub cell: String,
    /// Its name among the sensors of the cell, where there are several.
    #[serde(default)]
    pub sensor: String,
    /// Whether it looks at the cell's tray.
    #[serde(default)]
    pub is_tray: bool,
    /// The pose of the frame that its coordinates are in.
    pub container_from_sensor: Extrinsics,
    /// The unit of its coordinates: ROS prescribes metres, and some drivers send millimetres.
    #[serde(default)]
    pub unit: LengthUnit,
}

/// A camera as it is set, checked.
pub(super) struct Camera {
    pub(super) key: KeyExpr<'static>,
    pub(super) cell: Cell,
    pub(super) sensor: String,
    pub(super) is_tray: bool,
    pub(super) container_from_sensor: Isometry3<f64>,
    pub(super) unit: LengthUnit,
}

impl RosCamera {
    pub(super) fn read(&self) -> Result<Camera, String> {
        topic::check_key(&self.key).map_err(|error| format!("key: {error}"))?;
        let key = KeyExpr::autocanonize(self.key.clone())
            .map_err(|error| format!("key: '{}' is no key expression: {error}", self.key))?;
        let own = everything();
        if KeyExpr::new(own.as_str()).is_ok_and(|own| key.intersects(&own)) {
            return Err(format!("key: '{key}' takes in what is under {own}"));
        }
        Ok(Camera {
            key,
            cell: Cell::new(&self.cell).map_err(|error| error.to_string())?,
            sensor: self.sensor.clone(),
            is_tray: self.is_tray,
            unit: self.unit,
            container_from_sensor: self
                .container_from_sensor
                .pose()
                .map_err(|error| format!("container_from_sensor: {error}"))?,
        })
    }
}

/// Checks the cameras that are set, given the sensors of the cells that are served, or of their
/// trays.
pub(crate) fn validate(
    cameras: &[RosCamera],
    sensors_of: impl Fn(&Cell, bool) -> Option<Sensors>,
) -> Result<(), String> {
    let mut seen = BTreeSet::new();
    for (index, camera) in cameras.iter().enumerate() {
        let refused = |reason: String| format!("ros[{index}]: {reason}");
        let cell = camera.read().map_err(refused)?.cell;
        let Some(sensors) = sensors_of(&cell, camera.is_tray) else {
            return Err(refused(match camera.is_tray {
                true => format!("cell '{cell}' has no tray: set trays.{cell}"),
                false => format!(
                    "cell '{cell}' is not served: list it in cells, or set has_unlisted_cells"
                ),
            }));
        };
        let Some(sensor) = sensors.index_of(&camera.sensor) else {
            let name = &camera.sensor;
            return Err(refused(format!("cell '{cell}' has no sensor '{name}'")));
        };
        // Each camera counts its own clouds: those of two would be late in turn.
        if !seen.insert((cell.clone(), camera.is_tray, sensor)) {
            return Err(refused(format!(
                "cell '{cell}' has this camera already: name its cameras in sensors.{cell}"
            )));
        }
    }
    Ok(())
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn camera() -> RosCamera {
        RosCamera {
            key: "0/camera/depth/points/**".to_owned(),
            cell: "cell-1".to_owned(),
            sensor: String::new(),
            is_tray: false,
            container_from_sensor: Extrinsics {
                position_m: [0.16, 0.16, 0.9],
                orientation_xyzw: [1.0, 0.0, 0.0, 0.0],
            },
            unit: LengthUnit::Metres,
        }
    }

    /// One sensor in each cell, and one above its tray.
    fn one(_: &Cell, _: bool) -> Option<Sensors> {
        Some(Sensors::new(&[]))
    }

    #[test]
    fn keys_of_both_middlewares_are_possible() {
        for key in [
            "0/camera/depth/points/**",
            "0/camera/depth/points/sensor_msgs::msg::dds_::PointCloud2_/RIHS01_91",
            "0/camera/*/points/$*::msg::dds_::PointCloud2_/*",
            "camera/depth/points",
        ] {
            let mut camera = camera();
            camera.key = key.to_owned();
            assert_eq!(validate(&[camera], one), Ok(()), "{key}");
        }
    }

    #[test]
    fn impossible_cameras_are_named() {
        type Change = fn(&mut RosCamera);
        let changes: [(&str, Change); 14] = [
            ("key: '/camera", |c| c.key = "/camera/points".to_owned()),
            ("key: ''", |c| c.key = String::new()),
            ("key: 'a//b'", |c| c.key = "a//b".to_owned()),
            ("key: 'a#b'", |c| c.key = "a#b".to_owned()),
            ("ppnpack/v1", |c| c.key = "**".to_owned()),
            ("ppnpack/v1", |c| {
                c.key = "ppnpack/v1/cell-1/cloud".to_owned();
            }),
            ("sensor_msgs::msg::dds_::Image_", |c| {
                c.key = "0/camera/sensor_msgs::msg::dds_::Image_/**".to_owned();
            }),
            ("cell-?", |c| c.cell = "cell-?".to_owned()),
            ("'all'", |c| c.cell = "all".to_owned()),
            ("'cell-2' is not served", |c| c.cell = "cell-2".to_owned()),
            ("cell 'cell-1' has no tray", |c| c.is_tray = true),
            ("is no unit quaternion", |c| {
                c.container_from_sensor.orientation_xyzw = [0.0; 4];
            }),
            ("is no unit quaternion", |c| {
                c.container_from_sensor.orientation_xyzw = [f64::NAN; 4];
            }),
            ("container_from_sensor: the position", |c| {
                c.container_from_sensor.position_m = [f64::INFINITY, 0.0, 0.0];
            }),
        ];
        let served = |cell: &Cell, is_tray| {
            one(cell, is_tray).filter(|_| cell.as_str() == "cell-1" && !is_tray)
        };
        assert_eq!(validate(&[camera()], served), Ok(()));
        for (expected, change) in changes {
            let mut changed = camera();
            change(&mut changed);
            let reason = validate(&[changed], served).unwrap_err();
            assert!(
                reason.starts_with("ros[0]: ") && reason.contains(expected),
                "{reason}"
            );
        }
        let reason = validate(&[camera(), camera()], served).unwrap_err();
        assert!(reason.starts_with("ros[1]: cell 'cell-1' has this camera already"));
        let tray = RosCamera {
            is_tray: true,
            ..camera()
        };
        assert_eq!(validate(&[camera(), tray], one), Ok(()));
    }

    #[test]
    fn the_cameras_of_a_cell_are_told_apart_by_their_names() {
        let two = |_: &Cell, _| Some(Sensors::new(&["left".to_owned(), "right".to_owned()]));
        let named = |name: &str| RosCamera {
            sensor: name.to_owned(),
            ..camera()
        };
        assert_eq!(validate(&[named("left"), named("right")], two), Ok(()));
        let reason = validate(&[named("left"), named("left")], two).unwrap_err();
        assert!(reason.starts_with("ros[1]: "), "{reason}");
        let reason = validate(&[named("behind")], two).unwrap_err();
        assert_eq!(reason, "ros[0]: cell 'cell-1' has no sensor 'behind'");
    }
}
