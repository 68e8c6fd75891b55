//! The networks of the table.

use ppnpack_model::accuracy::SHARES_PERCENT;
use ppnpack_model::architecture::{Architecture, Fusion};
use ppnpack_model::settings::{Loss, TrainingSettings};

/// A row of the table.
#[derive(Debug)]
pub(super) struct Variant {
    pub(super) name: &'static str,
    /// The name of its folder.
    pub(super) key: &'static str,
    pub(super) loss: Loss,
    fusion: Fusion,
    resting_heights: bool,
    /// Table III of the paper, in percent at the shares of [`SHARES_PERCENT`].
    pub(super) paper_percent: Option<[f64; SHARES_PERCENT.len()]>,
}

const FULL: Variant = Variant {
    name: "full",
    key: "full",
    loss: Loss::Ranking,
    fusion: Fusion::Correlation,
    resting_heights: true,
    paper_percent: None,
};

const HEIGHTMAPS: Variant = Variant {
    name: "heightmaps alone (the paper's inputs)",
    key: "heightmaps",
    resting_heights: false,
    paper_percent: Some([81.0, 94.9, 97.2, 98.0, 99.4]),
    ..FULL
};

const NO_RANKING: Variant = Variant {
    name: "heightmaps alone, without ranking",
    key: "no-ranking",
    loss: Loss::Mse,
    paper_percent: Some([62.1, 72.9, 77.0, 79.2, 86.1]),
    ..HEIGHTMAPS
};

const NO_CORRELATION: Variant = Variant {
    name: "heightmaps alone, without ranking and correlation",
    key: "no-ranking-no-correlation",
    fusion: Fusion::Concatenation,
    paper_percent: Some([57.9, 66.9, 70.2, 72.5, 80.8]),
    ..NO_RANKING
};

/// Each but the first lacks one thing more.
pub(super) static VARIANTS: [Variant; 4] = [FULL, HEIGHTMAPS, NO_RANKING, NO_CORRELATION];

impl Variant {
    /// These settings for this network.
    pub(super) fn of(&self, settings: TrainingSettings) -> TrainingSettings {
        TrainingSettings {
            architecture: Architecture {
                fusion: self.fusion,
                resting_heights: self.resting_heights,
                ..settings.architecture
            },
            loss: self.loss,
            ..settings
        }
    }
}
