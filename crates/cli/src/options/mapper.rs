//! How points become heights.

use clap::Args;
use ppnpack_perception::doubts::DoubtSettings;
use ppnpack_perception::settings::MapperSettings;

use crate::length::parse_distance;

/// See [`MapperSettings`]. The defaults are those for a sensor without noise.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Points to heights")]
pub(crate) struct MapperOptions {
    /// The standard deviation of the sensor's noise along z; 0: every point counts as it is
    #[arg(long, value_name = "LENGTH", default_value = "0", value_parser = parse_distance, allow_hyphen_values = true)]
    noise: f64,

    /// A point stands for the surface within this distance
    #[arg(long, value_name = "LENGTH", default_value = "0", value_parser = parse_distance, allow_hyphen_values = true)]
    point_radius: f64,

    /// Holes in the map no wider than this are filled where the surface around is level
    #[arg(long, value_name = "LENGTH", default_value = "0", value_parser = parse_distance, allow_hyphen_values = true)]
    largest_hole: f64,

    /// Points this close to the walls are left out
    #[arg(long, value_name = "LENGTH", default_value = "0.5mm", value_parser = parse_distance, allow_hyphen_values = true)]
    wall_margin: f64,

    /// Points this far below the floor lie on it; those further below are left out
    #[arg(long, value_name = "LENGTH", default_value = "1cm", value_parser = parse_distance, allow_hyphen_values = true)]
    floor_tolerance: f64,

    /// How thick the walls are: their tops are then looked for where the container should be; 0: they are not
    #[arg(long, value_name = "LENGTH", default_value = "0", value_parser = parse_distance, allow_hyphen_values = true)]
    wall_thickness: f64,

    /// What stands above the rim by more than this reaches into the container; without it, nothing does
    #[arg(long, value_name = "LENGTH", value_parser = parse_distance, allow_hyphen_values = true)]
    reach_above_rim: Option<f64>,
}

impl MapperOptions {
    pub(crate) fn settings(&self) -> MapperSettings {
        MapperSettings {
            noise_m: self.noise,
            point_radius_m: self.point_radius,
            largest_hole_m: self.largest_hole,
            wall_margin_m: self.wall_margin,
            floor_tolerance_m: self.floor_tolerance,
            doubts: DoubtSettings {
                wall_thickness_m: self.wall_thickness,
                reach_above_rim_m: self.reach_above_rim,
                ..DoubtSettings::default()
            },
            ..MapperSettings::default()
        }
    }
}
