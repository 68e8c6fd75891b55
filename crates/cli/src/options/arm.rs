//! Options of the arm that has to make the placements.

use std::path::{Path, PathBuf};

use clap::Args;
use ppnpack_robot::arms;
use ppnpack_robot::parameters::BaseParameters;
use ppnpack_robot::station::{ArmStation, StationSettings};

use crate::failure::{Failure, OrInput, Outcome};
use crate::length::parse_coordinate;
use crate::output::print_line;

/// What `--arm` takes for a wish to see the names.
const LIST: &str = "list";

/// The arm that has to make the placements.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Arm")]
pub struct ArmOptions {
    /// The arm that has to be able to make the placements: nachi-mz07l, abb-irb1200-5-90, or a parameter file;
    /// `list` names those that are built in [default: none, placements are not checked for an arm]
    #[arg(long, value_name = "NAME|FILE")]
    arm: Option<String>,

    /// Where the arm stands in the container frame, with a yaw in degrees if it does not look along x
    /// [default: that of the parameter file, beside the reference container]
    #[arg(long, value_name = "X,Y,Z[,YAW]", value_parser = parse_place, allow_hyphen_values = true, requires = "arm")]
    arm_base: Option<Place>,

    /// Where items lie to be picked: the point that the suction cup comes down on; its height is that of what they
    /// lie on [default: 10cm,-35cm,-1cm]
    #[arg(long, value_name = "X,Y,Z[,YAW]", value_parser = parse_place, allow_hyphen_values = true, requires = "arm")]
    arm_pick: Option<Place>,

    /// A TOML file with anything else of the arm's cell, such as the gripper, boxes, clearances, speeds; see
    /// docs/robot.md
    #[arg(long, value_name = "FILE", requires = "arm")]
    arm_cell: Option<PathBuf>,
}

/// A place and a turn about the vertical.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Place {
    position_m: [f64; 3],
    yaw_deg: f64,
}

impl ArmOptions {
    /// Prints the names of the arms where that is all that is wanted; says whether it was.
    ///
    /// # Errors
    /// That they cannot be written.
    pub fn listed(&self) -> Outcome<bool> {
        if self.arm.as_deref() != Some(LIST) {
            return Ok(false);
        }
        for name in arms::names() {
            print_line(name)?;
        }
        Ok(true)
    }

    /// The arm and its cell, as set and at work; `None` where there is no arm.
    ///
    /// # Errors
    /// Which option is wrong, or what of a file.
    pub fn station(&self) -> Outcome<Option<(StationSettings, ArmStation)>> {
        let Some(arm) = &self.arm else {
            return Ok(None);
        };
        let mut settings = match &self.arm_cell {
            Some(path) => read(path)?,
            None => StationSettings::default(),
        };
        settings.arm.clone_from(arm);
        if let Some(place) = self.arm_base {
            settings.base = Some(BaseParameters {
                position_m: place.position_m,
                roll_deg: 0.0,
                pitch_deg: 0.0,
                yaw_deg: place.yaw_deg,
            });
        }
        if let Some(place) = self.arm_pick {
            settings.pick.position_m = place.position_m;
            settings.pick.yaw_deg = place.yaw_deg;
        }
        let station = ArmStation::new(&settings).or_input()?;
        Ok(Some((settings, station)))
    }
}

fn read(path: &Path) -> Outcome<StationSettings> {
    let wrong = |error: &dyn std::fmt::Display| {
        let error = error.to_string();
        let line = error.lines().map(str::trim).collect::<Vec<_>>().join(" ");
        Failure::input(format_args!("--arm-cell {}: {line}", path.display()))
    };
    let text = std::fs::read_to_string(path).map_err(|error| wrong(&error))?;
    toml::from_str(&text).map_err(|error| wrong(&error))
}

fn parse_place(text: &str) -> Result<Place, String> {
    let parts: Vec<&str> = text.split(',').collect();
    let (place, yaw) = match parts.as_slice() {
        [x, y, z] => ([x, y, z], "0"),
        [x, y, z, yaw] => ([x, y, z], *yaw),
        _ => {
            return Err(format!(
                "'{text}' must be three lengths and perhaps an angle in degrees, such as -35cm,16cm,10cm,90"
            ));
        }
    };
    let [x, y, z] = place.map(|length| parse_coordinate(length));
    let yaw_deg: f64 = yaw
        .trim()
        .parse()
        .map_err(|_| format!("'{yaw}' is no angle in degrees"))?;
    Ok(Place {
        position_m: [x?, y?, z?],
        yaw_deg,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_have_three_coordinates_and_perhaps_a_yaw() {
        let place = |position_m, yaw_deg| {
            Ok(Place {
                position_m,
                yaw_deg,
            })
        };
        let plain = parse_place("-35cm,0.16,100mm");
        assert_eq!(plain, place([-0.35, 0.16, 0.1], 0.0));
        assert_eq!(
            parse_place("0, 0, -1cm, -90"),
            place([0.0, 0.0, -0.01], -90.0)
        );
        for text in ["", "1,2", "1,2,3,4,5", "a,b,c", "1,2,3,north", "1,2,inf"] {
            assert!(parse_place(text).is_err(), "{text}");
        }
    }
}
