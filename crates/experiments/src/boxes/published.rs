//! Figures of others on the benchmark.

use serde::Serialize;

use super::rules::Setting;

/// The heuristics of the reference environment (the published code of PCT), run as they are.
const ENVIRONMENT: &str = "reference environment's own, 60 to 300 episodes";

/// Zhao, Yu and Xu, *Learning Efficient Online 3D Bin Packing on Packing Configuration Trees*, ICLR 2022: 2,000 instances.
const PAPER: &str = "PCT, ICLR 2022, Table 2";
const QUOTED: &str = "PCT, ICLR 2022, Table 1 as others quote it";

/// A figure of others.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Published {
    pub(super) setting: Setting,
    method: &'static str,
    source: &'static str,
    utilisation_percent: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    boxes: Option<f64>,
}

impl Published {
    const fn new(
        setting: Setting,
        method: &'static str,
        source: &'static str,
        percent: f64,
    ) -> Self {
        Self {
            setting,
            method,
            source,
            utilisation_percent: percent,
            boxes: None,
        }
    }

    const fn with_boxes(self, boxes: f64) -> Self {
        Self {
            boxes: Some(boxes),
            ..self
        }
    }

    /// A row of the table.
    pub(super) fn row(&self) -> String {
        let boxes = self.boxes.map(|boxes| format!("{boxes:.1}"));
        format!(
            "| *{}*, {} | {:.1} | {} | | |\n",
            self.method,
            self.source,
            self.utilisation_percent,
            boxes.unwrap_or_default(),
        )
    }
}

/// All of them.
pub(super) const PUBLISHED: [Published; 14] = {
    use Setting::{Free, Stable};
    [
        Published::new(Stable, "PCT & EV", PAPER, 76.0).with_boxes(29.4),
        Published::new(Stable, "PCT & EMS", QUOTED, 75.8),
        Published::new(Stable, "DBL", ENVIRONMENT, 59.8),
        Published::new(Stable, "HM", ENVIRONMENT, 57.8),
        Published::new(Stable, "LSAH", ENVIRONMENT, 52.6),
        Published::new(Stable, "OnlineBPH", ENVIRONMENT, 50.2),
        Published::new(Stable, "BR", ENVIRONMENT, 49.3),
        Published::new(Free, "PCT & EMS", QUOTED, 86.0),
        Published::new(Free, "PCT & EV", PAPER, 85.3).with_boxes(32.8),
        Published::new(Free, "DBL", ENVIRONMENT, 69.7),
        Published::new(Free, "LSAH", ENVIRONMENT, 64.3),
        Published::new(Free, "HM", ENVIRONMENT, 63.8),
        Published::new(Free, "OnlineBPH", ENVIRONMENT, 59.6),
        Published::new(Free, "BR", ENVIRONMENT, 57.1),
    ]
};
