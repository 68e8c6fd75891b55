//! Loads: what rests on each item, and what it may carry.
//!
//! Who rests on whom follows from the solids as they lie, and how weight is spread below from
//! statics (`bearing.rs`). Friction on walls and wedged items are left out, and contacts are known
//! only as well as poses: limits are held with a margin, but never against more than all that is
//! above.

mod balance;
mod bearing;
mod check;
mod contacts;
mod pile;
mod sides;
mod stack;

use ppnpack_numbers::{SettingError, settings, within};

pub use balance::BalanceCheck;
pub use bearing::bearing_shares;
pub use check::LoadCheck;
pub use pile::Pile;

use crate::checks::check::BoxedCheck;
use crate::ranking::refusal::{Cause, Refusal};

/// Note on an item of unknown mass.
const UNKNOWN_MASS: &str =
    "the item's mass is not known: it was left out of the loads and of the balance";

settings! {
    /// Settings of loads and balance.
    #[derive(Copy)]
    pub struct LoadSettings {
        /// The estimated load of an item is held against what it may carry this many times.
        pub margin: f64 = 1.5,
        /// The load of an item where the placement was tried is held against what it may carry this
        /// many times, but never more than all that is above.
        pub tried_margin: f64 = 2.0,
        /// How far out of balance a container may be: the mass in it times the distance of its
        /// centre of mass from the container's middle, along the floor, in kg m; `None`: as it
        /// comes.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub imbalance_kg_m: Option<f64> = None,
    }
}

impl LoadSettings {
    /// Checks that every number is possible.
    pub fn validate(&self) -> Result<(), SettingError> {
        let factor = within("between 1 and 1000", 1.0..=1e3);
        factor("the margin of loads", self.margin)?;
        factor("the margin of tried loads", self.tried_margin)?;
        let imbalance = within("between 0 and 100000 kg m", 0.0..=1e5);
        imbalance(
            "the container's imbalance",
            self.imbalance_kg_m.unwrap_or(0.0),
        )
    }

    /// The checks of loads and of the container's balance.
    pub fn checks(&self) -> Vec<BoxedCheck> {
        let load: BoxedCheck = Box::new(LoadCheck::new(self.margin));
        let balance = self.imbalance_kg_m.map(BalanceCheck::new);
        let balance = balance.map(|check| -> BoxedCheck { Box::new(check) });
        std::iter::once(load).chain(balance).collect()
    }
}

/// Load of an item, against its limit.
#[derive(Debug, Clone, PartialEq)]
pub struct Load {
    /// The item that carries it.
    pub item: String,
    /// Estimated load, in kilograms.
    pub estimated_kg: f64,
    /// Greatest possible load, in kilograms.
    pub carries_kg: f64,
}

impl Load {
    /// How much of what it may carry it does.
    pub fn share(&self) -> f64 {
        if self.estimated_kg > 0.0 {
            self.estimated_kg / self.carries_kg
        } else {
            0.0
        }
    }

    /// Refuses what would load an item with more than it may carry. The excess is rounded up to two
    /// digits, so that there are few different refusals.
    pub fn refusal(&self) -> Refusal {
        let over_g = (self.estimated_kg - self.carries_kg) * 1e3;
        let digit = 10_f64.powf(over_g.max(1.0).log10().floor() - 1.0).max(1.0);
        // What is over by less than a millionth of a digit is rounding.
        let over_g = (over_g / digit - 1e-6).ceil().max(1.0) * digit;
        let detail = format!(
            "{} would carry up to {over_g:.0} g more than it may",
            self.item
        );
        Refusal::because(Cause::Load, detail)
    }
}
