//! When a container is closed, by rules that are set, and why.

use serde::{Deserialize, Serialize};

use crate::kernel::grid::ContainerSize;
use crate::streams::orders::{ContainerRules, Sharing};

/// Rules by which a container is closed early. Without any, one is closed where nothing fits into
/// any.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ClosingRules {
    /// Share of the volume in percent at which it is closed; without it that closes none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fill_percent: Option<f64>,
    /// Closed as soon as all items are in it of its order, where a container is for one.
    pub order_complete: bool,
}

/// Rules that do not go together.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ClosingError {
    /// A share that is none.
    #[error("closing.fill_percent: {0} is no share of a container's volume: give 1 to 100 percent")]
    Percent(String),
    /// Containers are not of one order.
    #[error(
        "closing.order_complete: containers are shared: set rules.sharing to \"one-order\", or leave it out"
    )]
    SharedOrders,
}

/// Why a container was closed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Closing {
    /// Nothing in the buffer had a valid placement in any open container; it was the fullest.
    #[error("no item of the buffer fits into an open container, and this was the fullest")]
    NothingFits,
    /// It was as full as is set.
    #[error("it is filled to {percent:.0} %, and is to be closed at {full_at:.0} %")]
    Full {
        /// Filled share in percent.
        percent: f64,
        /// Filled share in percent at which it is closed.
        full_at: f64,
    },
    /// It was for one order, which is complete.
    #[error("all items that were announced of its order are in it")]
    OrderComplete,
}

impl Closing {
    /// The rule, in short.
    pub fn rule(&self) -> &'static str {
        match self {
            Self::NothingFits => "nothing fits",
            Self::Full { .. } => "full",
            Self::OrderComplete => "order complete",
        }
    }
}

/// Filled volume of a container.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fill {
    /// The volume of the items in it, in cubic metres.
    pub items_m3: f64,
    /// Its own, in cubic metres.
    pub container_m3: f64,
}

impl Fill {
    /// A container of this size with so much in it.
    pub fn of(items_m3: f64, size: ContainerSize) -> Self {
        Self {
            items_m3,
            container_m3: size.volume_m3(),
        }
    }

    /// How much of it is filled, in percent.
    pub fn percent(&self) -> f64 {
        100.0 * self.items_m3 / self.container_m3
    }
}

impl ClosingRules {
    /// Checks that the rules go together, and with the others.
    pub fn validate(&self, rules: &ContainerRules) -> Result<(), ClosingError> {
        let percent = self.fill_percent;
        if let Some(percent) = percent.filter(|percent| !(1.0..=100.0).contains(percent)) {
            return Err(ClosingError::Percent(percent.to_string()));
        }
        if self.order_complete && rules.sharing != Sharing::OneOrder {
            return Err(ClosingError::SharedOrders);
        }
        Ok(())
    }

    /// Why a container is closed by how full it is.
    pub fn closing(&self, fill: &Fill) -> Option<Closing> {
        let percent = fill.percent();
        let full_at = self.fill_percent.filter(|full_at| percent >= *full_at)?;
        Some(Closing::Full { percent, full_at })
    }
}

/// The fullest of these containers, by the share of its volume; of equal ones the first.
pub fn fullest(fills: &[Fill]) -> Option<usize> {
    let fills = fills.iter().enumerate();
    // Of equal ones, `min_by` gives the first.
    let fullest = fills.min_by(|(_, a), (_, b)| b.percent().total_cmp(&a.percent()));
    fullest.map(|(at, _)| at)
}
