//! Cloud files, and the unit that they are in.

use std::path::Path;

use ppnpack_catalogue::unit::LengthUnit;
use ppnpack_clouds::Cloud;

use crate::failure::{Failure, OrInput, Outcome};

/// Range of the points' median distance from the sensor, in metres; others are of another unit.
const MEDIAN_DISTANCE_M: std::ops::RangeInclusive<f32> = 0.01..=10.0;

/// Reads a cloud file in a unit; `option` is the one that gives it.
pub(crate) fn read_cloud(path: &Path, unit: LengthUnit, option: &str) -> Outcome<Cloud> {
    let cloud = ppnpack_clouds::read(path).or_input()?;
    let cloud = cloud.in_units_of(unit.metres());
    let distances_m = cloud.measured_m().map(|point| point.coords.norm());
    let mut distances_m: Vec<f32> = distances_m.collect();
    let middle = distances_m.len() / 2;
    if distances_m.is_empty() {
        return Ok(cloud);
    }
    let (_, median_m, _) = distances_m.select_nth_unstable_by(middle, f32::total_cmp);
    match MEDIAN_DISTANCE_M.contains(median_m) {
        true => Ok(cloud),
        false => Err(Failure::input(format_args!(
            "{}: in {unit}, its points are {median_m} m from the sensor in the median, where {} to {} m are possible: \
             give the unit of its coordinates, such as {option} mm for millimetres",
            path.display(),
            MEDIAN_DISTANCE_M.start(),
            MEDIAN_DISTANCE_M.end(),
        ))),
    }
}
