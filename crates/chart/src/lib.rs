//! Charts of results as SVG, drawn by `plotters`: lines, labelled points with intervals, bars.
//!
//! Text stays text, in the reader's own sans-serif font, and equal input gives equal bytes. Values that cannot be shown,
//! such as NaN, are left out.
//!
//! ```
//! use ppnpack_chart::{Curve, Lines};
//!
//! let chart = Lines {
//!     title: "Container filled".to_owned(),
//!     x_label: "Items placed".to_owned(),
//!     y_label: "Filled (%)".to_owned(),
//!     curves: vec![Curve { name: "SDFM".to_owned(), points: vec![[0.0, 0.0], [1.0, 4.5], [2.0, 7.0]] }],
//! };
//! let svg = chart.to_svg([720, 380])?;
//! assert!(svg.starts_with("<svg") && svg.contains("Filled (%)"));
//! # Ok::<(), ppnpack_chart::ChartError>(())
//! ```

mod bars;
mod frame;
mod labels;
mod lines;
mod range;
mod scatter;

pub use bars::{Bar, Bars};
pub use frame::ChartError;
pub use lines::{Curve, Lines};
pub use scatter::{Interval, PlotPoint, PointSeries, Scatter};
