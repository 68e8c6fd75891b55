//! Uncertainty of values.

use crate::range::drawable;

/// An interval of uncertainty around a value, such as a 95 % confidence interval, in the value's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// The lower end.
    pub low: f64,
    /// The upper end.
    pub high: f64,
}

impl Interval {
    /// Whether both ends can be shown.
    pub(crate) fn is_drawable(&self) -> bool {
        drawable(self.low) && drawable(self.high)
    }
}
