//! The pose of a sensor, given by hand or by a calibration file, and its region.

use std::path::Path;

use nalgebra::{Isometry3, Point3};
use ppnpack_packing::kernel::grid::ContainerSize;
use ppnpack_perception::calibration::Calibration;
use ppnpack_perception::extrinsics::Extrinsics;
use ppnpack_recognition::segmentation::Region;
use serde::Deserialize;

use super::file;
use crate::quantity::{centimetres, parse_coordinate};

/// The pose of a sensor, with the container's size where that was calibrated too. By default, the
/// sensor's frame is the container's.
#[derive(Debug, Clone, Default)]
pub(crate) struct Sensor {
    pub(crate) container_from_sensor: Isometry3<f64>,
    pub(crate) container: Option<ContainerSize>,
}

/// The content of a calibration file, which may hold more.
#[derive(Debug, Deserialize)]
struct CalibrationFile {
    container_from_sensor: Extrinsics,
    container: Option<ContainerSize>,
}

/// Parses a pose, `X,Y,Z,QX,QY,QZ,QW`, or reads the calibration file of this name.
pub(crate) fn parse_sensor(text: &str) -> Result<Sensor, String> {
    let calibration = if text.contains(',') {
        let numbers = text.split(',').map(|number| number.trim().parse().ok());
        let numbers: Option<Vec<f64>> = numbers.collect();
        let numbers = numbers.and_then(|numbers| <[f64; 7]>::try_from(numbers).ok());
        let needed = "seven numbers X,Y,Z,QX,QY,QZ,QW are needed, or a calibration file";
        let none = || format!("'{text}' is no pose: {needed}");
        let [x, y, z, qx, qy, qz, qw] = numbers.ok_or_else(none)?;
        CalibrationFile {
            container_from_sensor: Extrinsics {
                position_m: [x, y, z],
                orientation_xyzw: [qx, qy, qz, qw],
            },
            container: None,
        }
    } else {
        file::settings(text).map_err(|error| format!("{text} is no calibration file: {error}"))?
    };
    let pose = calibration.container_from_sensor.pose();
    Ok(Sensor {
        container_from_sensor: pose.map_err(|error| error.to_string())?,
        container: calibration.container,
    })
}

/// Writes a calibration file: two lines for the service's configuration, and how good they are.
pub(crate) fn calibration_file(source: &Path, calibration: &Calibration) -> anyhow::Result<String> {
    let Extrinsics {
        position_m: [x, y, z],
        orientation_xyzw: [qx, qy, qz, qw],
    } = Extrinsics::from(&calibration.container_from_sensor);
    let ContainerSize {
        x_m,
        y_m,
        z_m,
        draft_rad,
        corner_radius_m,
    } = calibration.size;
    let shape = match calibration.size.is_box() {
        true => String::new(),
        false => format!(", draft_rad = {draft_rad:?}, corner_radius_m = {corner_radius_m:?}"),
    };
    let measured = calibration.measured_size;
    let leaning = match measured.is_box() {
        true => String::new(),
        false => format!(
            " at the rim, walls leaning by {:.1} degrees",
            measured.draft_rad.to_degrees()
        ),
    };
    let measured = centimetres([measured.x_m, measured.y_m, measured.z_m]);
    let source = source.display().to_string().replace(char::is_control, " ");
    let residuals = toml::to_string(&calibration.residuals)?;
    Ok(format!(
        "# Calibrated on {source}. Metres and radians; the quaternion's real part is last. Measured: {measured}{leaning}.
container = {{ x_m = {x_m:?}, y_m = {y_m:?}, z_m = {z_m:?}{shape} }}
container_from_sensor = {{ position_m = [{x:?}, {y:?}, {z:?}], orientation_xyzw = [{qx:?}, {qy:?}, {qz:?}, {qw:?}] }}

[residuals]
{residuals}"
    ))
}

/// Parses a box by its lowest and its highest corner, `X,Y,Z,X,Y,Z`; gives metres.
pub(crate) fn parse_region(text: &str) -> Result<Region, String> {
    let numbers = text.split(',').map(parse_coordinate);
    let numbers: Vec<f64> = numbers.collect::<Result<_, _>>()?;
    let [x0, y0, z0, x1, y1, z1] = <[f64; 6]>::try_from(numbers).map_err(|_| {
        format!("'{text}' is no region: its lowest and its highest corner are needed, X,Y,Z,X,Y,Z")
    })?;
    let region = Region {
        lowest_m: Point3::new(x0, y0, z0),
        highest_m: Point3::new(x1, y1, z1),
    };
    let sides = region.highest_m - region.lowest_m;
    let is_box = sides.iter().all(|side_m| *side_m > 0.0);
    let needed = "the second corner must be higher along each axis";
    is_box
        .then_some(region)
        .ok_or_else(|| format!("'{text}' is no region: {needed}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_has_seven_numbers_of_which_four_are_a_turn() {
        let sensor = parse_sensor("0.1, 0.2,0.9,1,0,0,0").unwrap();
        assert_eq!(sensor.container_from_sensor.translation.vector.z, 0.9);
        for text in ["1,2,3", "0,0,0,0,0,0,0", "0,0,0,1,0,0,x", "nan,0,0,1,0,0,0"] {
            assert!(parse_sensor(text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_region_has_two_corners() {
        let region = parse_region("-36cm,-0.7,-40mm, 40cm,-6cm,0.35").unwrap();
        assert_eq!(region.lowest_m, Point3::new(-0.36, -0.7, -0.04));
        assert_eq!(region.highest_m, Point3::new(0.4, -0.06, 0.35));
        for wrong in ["1,2,3", "0,0,0,1,1,0", "0,0,0,1,1,x", ""] {
            assert!(parse_region(wrong).is_err(), "{wrong}");
        }
    }
}
