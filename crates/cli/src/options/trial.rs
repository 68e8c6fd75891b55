//! Options of the tries that placements go through in a simulation before they are made.

use clap::Args;
use ppnpack_packing::effort::Effort;
use ppnpack_packing::trial::{TrialLimits, TrialSettings};

use super::conditions::Conditions;
use crate::failure::{OrInput, Outcome};
use crate::length::parse_distance;
use crate::quantity::{parse_force, parse_time};

/// How placements are tried in a twin of the cell.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Simulated check")]
pub(crate) struct TrialOptions {
    /// How many placements of an item a step may try in a simulated twin of the cell; the best one that stays is made.
    /// With 0 nothing is tried [default: 40 under robot conditions, 0 under the reference's]
    #[arg(long, value_name = "COUNT")]
    tries: Option<usize>,

    /// About how long a step may take, such as 20ms or 1s, in place of --tries: below 250ms nothing is tried. It decides the same
    /// on every machine
    #[arg(long, value_name = "TIME", value_parser = parse_effort, conflicts_with = "tries")]
    effort: Option<Effort>,

    /// The most that an item may tilt as it is tried, in degrees. What counts as steady in the end is 30 degrees and 20 mm
    #[arg(
        long,
        value_name = "DEGREES",
        default_value_t = 25.0,
        allow_hyphen_values = true
    )]
    tilt_limit: f64,

    /// The most that it may slide
    #[arg(long, value_name = "LENGTH", default_value = "18mm", value_parser = parse_distance, allow_hyphen_values = true)]
    slide_limit: f64,

    /// The most that any other item may be moved by it
    #[arg(long, value_name = "LENGTH", default_value = "20mm", value_parser = parse_distance, allow_hyphen_values = true)]
    disturbance_limit: f64,

    /// The greatest force with which it may press on any other item, such as 20N [default: as it comes]
    #[arg(long, value_name = "FORCE", value_parser = parse_force, allow_hyphen_values = true)]
    load_limit: Option<f64>,

    /// How far above the rim an item may reach as it is placed, if it sinks below the rim when it is tried
    #[arg(long, value_name = "LENGTH", default_value = "20mm", value_parser = parse_distance, allow_hyphen_values = true)]
    above_rim: f64,
}

fn parse_effort(text: &str) -> Result<Effort, String> {
    Effort::new(parse_time(text)?).map_err(|error| error.to_string())
}

impl TrialOptions {
    /// The settings, by default those that suit the conditions.
    ///
    /// # Errors
    /// Which of them is wrong.
    pub(crate) fn settings(&self, conditions: Conditions) -> Outcome<TrialSettings> {
        let usual = conditions.usual().trial;
        let limits = TrialLimits {
            tilt_rad: self.tilt_limit.to_radians(),
            slide_m: self.slide_limit,
            disturbance_m: self.disturbance_limit,
            load_n: self.load_limit,
            ..usual.limits
        };
        let tries = self.tries.or(self.effort.map(Effort::tries_per_item));
        let settings = TrialSettings {
            limits,
            tries_per_item: tries.unwrap_or(usual.tries_per_item),
            above_rim_m: self.above_rim,
            ..usual
        };
        settings.validate().or_input()?;
        Ok(settings)
    }
}
