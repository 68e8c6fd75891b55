//! `ppnpack calibrate`: where the container is before a sensor, from a cloud of it empty.

use std::path::{Path, PathBuf};

use clap::Args;
use ppnpack_catalogue::unit::LengthUnit;
use ppnpack_files::write_whole;
use ppnpack_packing::kernel::grid::ContainerSize;
use ppnpack_perception::calibration::{CalibrationSettings, Residuals, calibrate};
use ppnpack_perception::extrinsics::Extrinsics;
use serde::Serialize;

use crate::failure::{Failure, OrInput, Outcome};
use crate::options::container::parse_container;
use crate::options::{calibration_file, file, read_cloud};
use crate::output::{print_json, print_line};

/// Finds the container in a cloud of it empty, seen from above: its pose before the sensor and its
/// inner size.
///
/// The cloud is a PCD or PLY file in the sensor's frame, with the whole rim in view. What
/// is written is taken by `ppnpack perceive --container-from-sensor`, and its lines go into the
/// perception service's configuration.
#[derive(Debug, Args)]
pub(crate) struct CalibrateArguments {
    /// The cloud
    #[arg(value_name = "CLOUD")]
    cloud: PathBuf,

    /// The unit of the cloud's coordinates: m, cm, mm or in; industrial cameras write millimetres
    #[arg(long, value_name = "UNIT", default_value = "m")]
    unit: LengthUnit,

    /// The container's inner size where it is known, or a TOML file with its size, draft and
    /// corner_radius: the cloud is checked against the size, and gives only the pose
    #[arg(long, value_name = "XxYxZ|FILE", allow_hyphen_values = true, value_parser = parse_container)]
    container: Option<ContainerSize>,

    /// Turn the x axis from the side nearest to the sensor's by so many quarter turns,
    /// counter-clockwise from above
    #[arg(long, value_name = "COUNT", default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..=3))]
    quarter_turns: u8,

    /// Limits of the cloud's fit, where they are not the usual ones: a TOML file with
    /// `size_tolerance_m`, `largest_rms_m`, `largest_bow_m` or other settings of docs/perception.md
    #[arg(long, value_name = "FILE", value_parser = file::settings::<CalibrationSettings>)]
    limits: Option<CalibrationSettings>,

    /// The file to write
    #[arg(long, value_name = "FILE", default_value = "out/calibration.toml")]
    out: PathBuf,

    /// Print the result as JSON instead of the file that is written
    #[arg(long)]
    json: bool,
}

/// The result, for programs.
#[derive(Debug, Serialize)]
struct Summary<'a> {
    container_from_sensor: Extrinsics,
    container: ContainerSize,
    measured_container: ContainerSize,
    residuals: &'a Residuals,
    out: &'a Path,
}

pub(crate) fn run(arguments: &CalibrateArguments) -> Outcome {
    let settings = CalibrationSettings {
        size: arguments.container,
        quarter_turns: arguments.quarter_turns,
        ..arguments.limits.clone().unwrap_or_default()
    };
    settings.validate().or_input()?;
    let cloud = read_cloud(&arguments.cloud, arguments.unit, "--unit")?;
    let mut calibration = calibrate(cloud.measured_m(), &settings)
        .map_err(|error| Failure::input(format_args!("{}: {error}", arguments.cloud.display())))?;
    if arguments.container.is_none() {
        calibration.size = in_whole_millimetres(calibration.size);
    }
    let file = calibration_file(&arguments.cloud, &calibration)?;
    write_whole(&arguments.out, file.as_bytes())?;
    let summary = Summary {
        container_from_sensor: Extrinsics::from(&calibration.container_from_sensor),
        container: calibration.size,
        measured_container: calibration.measured_size,
        residuals: &calibration.residuals,
        out: &arguments.out,
    };
    match arguments.json {
        true => print_json(&summary)?,
        false => print_line(&format!("{file}\nCalibration: {}", arguments.out.display()))?,
    }
    Ok(())
}

/// Rounds the size to what is measured. A hair less than a multiple of the cell would cost a row of
/// cells.
fn in_whole_millimetres(size: ContainerSize) -> ContainerSize {
    let [x_m, y_m, z_m] =
        [size.x_m, size.y_m, size.z_m].map(|side_m| (1000.0 * side_m).round() / 1000.0);
    ContainerSize {
        draft_rad: (1000.0 * size.draft_rad).round() / 1000.0,
        ..ContainerSize::cuboid(x_m, y_m, z_m)
    }
}
