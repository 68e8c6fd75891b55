//! Options of what items and the container may carry.

use clap::Args;
use ppnpack_packing::loads::LoadSettings;

use crate::failure::{OrInput, Outcome};

/// How it is seen to that no item carries more than its `carries_kg` in `objects.csv`.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Loads")]
pub(crate) struct LoadOptions {
    /// The estimated load of an item is held against what it may carry this many times
    #[arg(long, value_name = "FACTOR", default_value_t = LoadSettings::default().margin, allow_hyphen_values = true)]
    load_margin: f64,

    /// The load of an item where the placement was tried is held against what it may carry this many times
    #[arg(long, value_name = "FACTOR", default_value_t = LoadSettings::default().tried_margin, allow_hyphen_values = true)]
    tried_load_margin: f64,

    /// How far out of balance the container may be: the mass in it times the distance of its centre of mass from the
    /// container's middle, in kg m [default: as it comes]
    #[arg(long, value_name = "NUMBER", allow_hyphen_values = true)]
    imbalance: Option<f64>,
}

impl LoadOptions {
    /// The settings.
    ///
    /// # Errors
    /// Which of them is wrong.
    pub(crate) fn settings(&self) -> Outcome<LoadSettings> {
        let settings = LoadSettings {
            margin: self.load_margin,
            tried_margin: self.tried_load_margin,
            imbalance_kg_m: self.imbalance,
        };
        settings.validate().or_input()?;
        Ok(settings)
    }
}
