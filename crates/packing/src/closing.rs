//! When a container is closed, by rules that are set, and why.

use std::collections::BTreeSet;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::containers::ContainerChoice;
use crate::grid::ContainerSize;
use crate::orders::{ContainerRules, Sharing};

/// When a container is closed though others go on. Without any rule one is closed only where nothing fits into any.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ClosingRules {
    /// One whose items fill less than so many percent of its volume is not closed because items do not fit: not by `none_of_last`, not by
    /// `rest_of_order`, and where nothing fits into any not as long as another one is filled so far. A complete order closes it
    /// nevertheless.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least_fill_percent: Option<f64>,
    /// Closed as soon as its items fill so many percent of its volume; where it is not given, that closes none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fill_percent: Option<f64>,
    /// Closed as soon as so many items were looked at in it one after another, since the last was packed into it, and none had a valid
    /// placement, whether they had one in another container or not. Items that rules keep out are not counted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub none_of_last: Option<usize>,
    /// With `certainty_percent` of the rules: where all of an order that waits would fit into an empty container with that certainty and
    /// into no open one, the fullest is closed of those whose orders are complete.
    pub rest_of_order: bool,
    /// Closed as soon as all items are in it of its order, where a container is for one.
    pub order_complete: bool,
}

/// Rules that do not go together.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ClosingError {
    /// A share that is none.
    #[error("closing.{0}: {1} is no share of a container's volume: give 1 to 100 percent")]
    Percent(&'static str, String),
    /// No items.
    #[error("closing.none_of_last: 0 items say nothing: give at least 1, or leave it out")]
    NoItems,
    /// One that is full is not filled enough.
    #[error(
        "closing.least_fill_percent: it is more than fill_percent, which closes before: give no more than that, or leave one out"
    )]
    FullBeforeLeast,
    /// Containers are not searched to the end.
    #[error(
        "closing.none_of_last: with choice = \"best\" it is not looked whether an item fits at all into a container while another one has \
         a better place for it: set choice to \"fullest\", or leave it out"
    )]
    BestChoice,
    /// There is no estimate.
    #[error("closing.rest_of_order: set rules.certainty_percent, too, or leave it out")]
    NoCertainty,
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
        /// How full it is.
        percent: f64,
        /// How full it is to be.
        full_at: f64,
    },
    /// So many items in a row had no valid placement in it.
    #[error("none of the last {0} items fitted")]
    NoneOfLast(usize),
    /// An order that waits is not expected to fit whole.
    #[error("the rest of order {order} ({rest_m3:.4} m³) fits with {percent:.0} % certainty")]
    RestOfOrder {
        /// The order.
        order: Arc<str>,
        /// The volume of what is left of it, in cubic metres.
        rest_m3: f64,
        /// With which certainty that fits into the container.
        percent: f64,
    },
    /// It was for one order, which is complete.
    #[error("all items that were announced of its order are in it")]
    OrderComplete,
}

impl Closing {
    /// Whether nothing went into it any more, so that it says what containers come to hold.
    pub fn is_as_full_as_it_gets(&self) -> bool {
        matches!(self, Self::NothingFits | Self::NoneOfLast(_))
    }

    /// The rule, in short.
    pub fn rule(&self) -> &'static str {
        match self {
            Self::NothingFits => "nothing fits",
            Self::Full { .. } => "full",
            Self::NoneOfLast(_) => "none of the last fitted",
            Self::RestOfOrder { .. } => "rest of order",
            Self::OrderComplete => "order complete",
        }
    }
}

/// How full a container is.
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
            container_m3: size.x_m * size.y_m * size.z_m,
        }
    }

    /// How much of it is filled, in percent.
    pub fn percent(&self) -> f64 {
        100.0 * self.items_m3 / self.container_m3
    }
}

/// The items that were looked at in vain in a container, since the last was packed into it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Missed {
    arrivals: BTreeSet<usize>,
}

impl Missed {
    /// The item of this arrival was looked at, and has no valid placement. No more of them are kept than the rule asks for.
    pub fn note(&mut self, arrival: usize, rules: &ClosingRules) {
        if self.arrivals.len() < rules.none_of_last.unwrap_or_default() {
            self.arrivals.insert(arrival);
        }
    }

    /// An item was packed.
    pub fn forget(&mut self) {
        self.arrivals.clear();
    }

    /// How many items they are.
    pub fn count(&self) -> usize {
        self.arrivals.len()
    }
}

impl ClosingRules {
    /// Checks that the rules go together, and with the others.
    ///
    /// # Errors
    /// [`ClosingError`] where they do not.
    pub fn validate(
        &self,
        rules: &ContainerRules,
        choice: ContainerChoice,
    ) -> Result<(), ClosingError> {
        let percents = [
            ("least_fill_percent", self.least_fill_percent),
            ("fill_percent", self.fill_percent),
        ];
        for (name, percent) in percents {
            if let Some(percent) = percent.filter(|percent| !(1.0..=100.0).contains(percent)) {
                return Err(ClosingError::Percent(name, percent.to_string()));
            }
        }
        let full_at = self.fill_percent.unwrap_or(f64::INFINITY);
        if self.least_fill_percent.is_some_and(|least| least > full_at) {
            return Err(ClosingError::FullBeforeLeast);
        }
        match self.none_of_last {
            Some(0) => return Err(ClosingError::NoItems),
            Some(_) if choice == ContainerChoice::Best => return Err(ClosingError::BestChoice),
            _ => {}
        }
        if self.rest_of_order && rules.certainty_percent.is_none() {
            return Err(ClosingError::NoCertainty);
        }
        if self.order_complete && rules.sharing != Sharing::OneOrder {
            return Err(ClosingError::SharedOrders);
        }
        Ok(())
    }

    /// Whether a container may leave as items do not fit.
    pub fn is_filled_enough(&self, fill: &Fill) -> bool {
        let least = self.least_fill_percent;
        least.is_none_or(|least| fill.percent() >= least)
    }

    /// Why a container is closed by how full it is, or by what did not fit into it.
    pub fn closing(&self, fill: &Fill, missed: &Missed) -> Option<Closing> {
        let percent = fill.percent();
        if let Some(full_at) = self.fill_percent.filter(|full_at| percent >= *full_at) {
            return Some(Closing::Full { percent, full_at });
        }
        let is_begun = fill.items_m3 > 0.0;
        let count = self.none_of_last?;
        let is_done = is_begun && missed.count() >= count && self.is_filled_enough(fill);
        is_done.then_some(Closing::NoneOfLast(count))
    }

    /// The fullest of the containers that could be closed, each with why, which may leave; of equal ones the first. `fills` is of all.
    pub fn fullest_that_may_leave(
        &self,
        fills: &[Fill],
        closings: impl Iterator<Item = (usize, Closing)>,
    ) -> Option<(usize, Closing)> {
        let filled = closings.filter_map(|(at, closing)| Some((fills.get(at)?, at, closing)));
        let may_leave = filled.filter(|(fill, _, _)| self.is_filled_enough(fill));
        // Of equal ones, `min_by` gives the first.
        let fullest = may_leave.min_by(|(a, _, _), (b, _, _)| b.items_m3.total_cmp(&a.items_m3));
        fullest.map(|(_, at, closing)| (at, closing))
    }

    /// The fullest of these containers that may leave as items do not fit; of equal ones the first. Where none may, the fullest.
    pub fn fullest(&self, fills: &[Fill]) -> Option<usize> {
        let among = |may_leave: bool| {
            let fills = fills.iter().enumerate();
            let fills = fills.filter(|(_, fill)| !may_leave || self.is_filled_enough(fill));
            // Of equal ones, `min_by` gives the first.
            let fullest = fills.min_by(|(_, a), (_, b)| b.items_m3.total_cmp(&a.items_m3));
            fullest.map(|(at, _)| at)
        };
        among(true).or_else(|| among(false))
    }
}
