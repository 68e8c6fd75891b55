//! Presets of the objective's weights.

use clap::ValueEnum;
use ppnpack_packing::objective::Weights;
use serde::Serialize;

/// Weights of the objective.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Objective {
    /// Those of the paper
    #[default]
    Published,
    /// Also low tops: for items in one pose
    Low,
    /// Also low tops, and closer to what lies there: for items in several resting poses
    Dense,
}

impl Objective {
    /// The weights themselves.
    pub fn weights(self) -> Weights {
        match self {
            Self::Published => Weights::default(),
            Self::Low => Weights::low(),
            Self::Dense => Weights::dense(),
        }
    }
}
