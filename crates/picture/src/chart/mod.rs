//! Charts of results, as SVG or as a picture.
//!
//! A chart is laid out as a list of shapes, which is then written as SVG, with its text as text, or painted.

mod axis;
mod bars;
mod drawing;
mod labels;
mod lines;
mod plot;
mod scatter;

pub(crate) use axis::Axis;
pub use bars::{Bar, Bars};
pub use lines::{Curve, Lines};
pub use scatter::{PlotPoint, PointSeries, Scatter};

/// An interval of uncertainty around a value, such as a 95 % confidence interval, in the value's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// The lower end.
    pub low: f64,
    /// The upper end.
    pub high: f64,
}

/// Values a chart can show: neither infinite, nor so large that differences vanish.
fn drawable(value: f64) -> bool {
    value.abs() < 1e12
}
