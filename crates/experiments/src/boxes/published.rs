//! Figures of others on the benchmark.

use serde::Serialize;

use super::rules::Setting;

/// Where a figure is from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Source {
    /// The heuristics of the reference environment (the published code of PCT), run as they are on 60 to 300 episodes.
    Environment,
    /// Zhao, Yu and Xu, *Learning Efficient Online 3D Bin Packing on Packing Configuration Trees*, ICLR 2022, Table 2:
    /// 2,000 instances.
    Paper,
    /// The same paper's Table 1, as others quote it.
    Quoted,
}

impl Source {
    /// For the table.
    fn in_words(self) -> &'static str {
        match self {
            Self::Environment => "reference environment's own, 60 to 300 episodes",
            Self::Paper => "PCT, ICLR 2022, Table 2",
            Self::Quoted => "PCT, ICLR 2022, Table 1 as others quote it",
        }
    }
}

/// A figure of others.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Published {
    pub(super) setting: Setting,
    method: &'static str,
    source: Source,
    utilisation_percent: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    boxes: Option<f64>,
}

impl Published {
    const fn heuristic(setting: Setting, method: &'static str, utilisation_percent: f64) -> Self {
        Self {
            setting,
            method,
            source: Source::Environment,
            utilisation_percent,
            boxes: None,
        }
    }

    const fn paper(setting: Setting, [utilisation_percent, boxes]: [f64; 2]) -> Self {
        Self {
            setting,
            method: "PCT & EV",
            source: Source::Paper,
            utilisation_percent,
            boxes: Some(boxes),
        }
    }

    const fn quoted(setting: Setting, utilisation_percent: f64) -> Self {
        Self {
            setting,
            method: "PCT & EMS",
            source: Source::Quoted,
            utilisation_percent,
            boxes: None,
        }
    }

    /// A row of the table.
    pub(super) fn row(&self) -> String {
        let boxes = self.boxes.map(|boxes| format!("{boxes:.1}"));
        format!(
            "| *{}*, {} | {:.1} | {} | | |\n",
            self.method,
            self.source.in_words(),
            self.utilisation_percent,
            boxes.unwrap_or_default(),
        )
    }
}

/// All of them.
pub(super) const PUBLISHED: [Published; 14] = {
    use Setting::{Free, Stable};
    [
        Published::paper(Stable, [76.0, 29.4]),
        Published::quoted(Stable, 75.8),
        Published::heuristic(Stable, "DBL", 59.8),
        Published::heuristic(Stable, "HM", 57.8),
        Published::heuristic(Stable, "LSAH", 52.6),
        Published::heuristic(Stable, "OnlineBPH", 50.2),
        Published::heuristic(Stable, "BR", 49.3),
        Published::quoted(Free, 86.0),
        Published::paper(Free, [85.3, 32.8]),
        Published::heuristic(Free, "DBL", 69.7),
        Published::heuristic(Free, "LSAH", 64.3),
        Published::heuristic(Free, "HM", 63.8),
        Published::heuristic(Free, "OnlineBPH", 59.6),
        Published::heuristic(Free, "BR", 57.1),
    ]
};
