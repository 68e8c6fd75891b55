//! Where a sensor is: given by hand or by a calibration file.

use std::path::{Path, PathBuf};

use anyhow::Context;
use nalgebra::Isometry3;
use ppnpack_packing::grid::ContainerSize;
use ppnpack_perception::calibration::{Calibration, Residuals};
use ppnpack_perception::extrinsics::Extrinsics;
use serde::Deserialize;

/// The longest calibration file, in bytes.
const MAX_FILE_BYTES: u64 = 1 << 16;

/// Where a sensor is, as it stands on the command line.
#[derive(Debug, Clone)]
pub(crate) enum SensorOption {
    /// Seven numbers.
    Pose(Isometry3<f64>),
    /// A calibration file.
    File(PathBuf),
}

/// Where a sensor is, and how large the container is where that was calibrated too. By default, the sensor's frame is
/// the container's.
#[derive(Debug, Clone, Default)]
pub(crate) struct Sensor {
    pub(crate) container_from_sensor: Isometry3<f64>,
    pub(crate) container: Option<ContainerSize>,
}

/// What a calibration file says. It may hold more.
#[derive(Debug, Deserialize)]
struct CalibrationFile {
    container_from_sensor: Extrinsics,
    container: Option<ContainerSize>,
}

/// Parses a pose, `X,Y,Z,QX,QY,QZ,QW`, or the name of a calibration file.
pub(crate) fn parse_sensor(text: &str) -> Result<SensorOption, String> {
    if !text.contains(',') {
        return Ok(SensorOption::File(text.into()));
    }
    let numbers = text.split(',').map(|number| number.trim().parse().ok());
    let numbers: Option<Vec<f64>> = numbers.collect();
    let numbers = numbers.and_then(|numbers| <[f64; 7]>::try_from(numbers).ok());
    let [x, y, z, qx, qy, qz, qw] = numbers.ok_or_else(|| {
        format!(
            "'{text}' is no pose: seven numbers X,Y,Z,QX,QY,QZ,QW are needed, or a calibration file"
        )
    })?;
    let extrinsics = Extrinsics {
        position_m: [x, y, z],
        orientation_xyzw: [qx, qy, qz, qw],
    };
    let pose = extrinsics.pose().map_err(|error| error.to_string())?;
    Ok(SensorOption::Pose(pose))
}

impl SensorOption {
    pub(crate) fn sensor(&self) -> anyhow::Result<Sensor> {
        match self {
            Self::Pose(container_from_sensor) => Ok(Sensor {
                container_from_sensor: *container_from_sensor,
                container: None,
            }),
            Self::File(path) => {
                read(path).with_context(|| format!("{} is no calibration file", path.display()))
            }
        }
    }
}

fn read(path: &Path) -> anyhow::Result<Sensor> {
    let length = std::fs::metadata(path)?.len();
    anyhow::ensure!(length <= MAX_FILE_BYTES, "it has {length} bytes");
    let text = std::fs::read_to_string(path)?;
    let file: CalibrationFile = toml::from_str(&text).map_err(|error| {
        // The library's own text has several lines.
        anyhow::anyhow!("{}", error.message().lines().collect::<Vec<_>>().join(" "))
    })?;
    Ok(Sensor {
        container_from_sensor: file.container_from_sensor.pose()?,
        container: file.container,
    })
}

/// The content of a calibration file: two lines for the service's configuration, and how good they are.
pub(crate) fn calibration_file(source: &Path, calibration: &Calibration) -> String {
    let Extrinsics {
        position_m: [x, y, z],
        orientation_xyzw: [qx, qy, qz, qw],
    } = Extrinsics::from(&calibration.container_from_sensor);
    let ContainerSize { x_m, y_m, z_m } = calibration.size;
    let Residuals {
        floor_rms_m,
        rim_rms_m,
        walls_rms_m,
        walls_seen,
        bow_m,
        squareness_rad,
        parallelism_rad,
    } = calibration.residuals;
    let source = source.display().to_string().replace(char::is_control, " ");
    format!(
        "# Calibrated on {source}. Metres; the quaternion's real part is last.
container = {{ x_m = {x_m:?}, y_m = {y_m:?}, z_m = {z_m:?} }}
container_from_sensor = {{ position_m = [{x:?}, {y:?}, {z:?}], orientation_xyzw = [{qx:?}, {qy:?}, {qz:?}, {qw:?}] }}

[residuals]
floor_rms_m = {floor_rms_m:.6}
rim_rms_m = {rim_rms_m:.6}
walls_rms_m = {walls_rms_m:.6}
bow_m = {bow_m:.6}
squareness_rad = {squareness_rad:.6}
parallelism_rad = {parallelism_rad:.6}
walls_seen = {walls_seen}
"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_and_files_are_told_apart() {
        let SensorOption::Pose(pose) = parse_sensor("0.1, 0.2,0.9,1,0,0,0").unwrap() else {
            panic!("a pose");
        };
        assert_eq!(pose.translation.vector.z, 0.9);
        assert!(matches!(parse_sensor("a.toml"), Ok(SensorOption::File(_))));
        for text in ["1,2,3", "0,0,0,0,0,0,0", "0,0,0,1,0,0,x", "nan,0,0,1,0,0,0"] {
            assert!(parse_sensor(text).is_err(), "{text}");
        }
    }
}
