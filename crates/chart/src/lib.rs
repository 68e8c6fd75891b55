//! Line charts of results as SVG, drawn by `plotters`.
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

use std::ops::Range;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Curves over a common x, such as utilisation over steps.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Lines {
    /// What the chart shows.
    pub title: String,
    /// What is along x, with its unit.
    pub x_label: String,
    /// What is along y, with its unit. The axis starts at zero unless all values are far above it or some below.
    pub y_label: String,
    /// The curves; each has its own colour.
    pub curves: Vec<Curve>,
}

/// One line of a line chart.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Curve {
    /// The name in the legend; none if empty.
    pub name: String,
    /// Its points `[x, y]` in order; one that is not finite leaves a gap.
    pub points: Vec<[f64; 2]>,
}

/// A chart that the library cannot draw.
#[derive(Debug, thiserror::Error)]
#[error("the chart cannot be drawn: {0}")]
pub struct ChartError(String);

impl<E: std::error::Error + Send + Sync> From<DrawingAreaErrorKind<E>> for ChartError {
    fn from(error: DrawingAreaErrorKind<E>) -> Self {
        Self(error.to_string())
    }
}

/// Titles and names.
const INK: RGBColor = RGBColor(0x1f, 0x29, 0x33);
/// Secondary text.
const GREY: RGBColor = RGBColor(0x61, 0x6e, 0x7c);
const AXIS: RGBColor = RGBColor(0x9a, 0xa5, 0xb1);
const GRID: RGBColor = RGBColor(0xe4, 0xe7, 0xeb);

/// The colours of curves (Okabe and Ito), told apart by colour-blind readers too; they repeat.
const COLOURS: [RGBColor; 6] = [
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x00, 0x9e, 0x73),
    RGBColor(0xcc, 0x79, 0xa7),
    RGBColor(0xe6, 0x9f, 0x00),
    RGBColor(0x56, 0xb4, 0xe9),
];

const FONT: &str = "'Noto Sans', 'Helvetica Neue', Arial, sans-serif";

/// Space between the document's edge and what is drawn, in pixels.
const MARGIN: i32 = 22;

impl Lines {
    /// The chart as an SVG document of `[width, height]` pixels.
    ///
    /// # Errors
    /// [`ChartError`] where the library cannot draw it.
    pub fn to_svg(&self, [width, height]: [u32; 2]) -> Result<String, ChartError> {
        let mut svg = String::new();
        let root = SVGBackend::with_string(&mut svg, (width, height)).into_drawing_area();
        root.fill(&WHITE)?;
        let (head, body) = root.split_vertically(48);
        let title = text(19.0, INK, HPos::Left);
        head.draw(&Text::new(self.title.clone(), (MARGIN, 29), title))?;
        let (x, y) = self.spans();
        let mut plane = ChartBuilder::on(&body)
            .margin(MARGIN)
            .margin_top(12)
            .x_label_area_size(46)
            .y_label_area_size(54)
            .build_cartesian_2d(x, y)?;
        plane
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(GRID)
            .axis_style(AXIS)
            .x_labels(9)
            .y_labels(7)
            .x_label_formatter(&tick)
            .y_label_formatter(&tick)
            .label_style(text(13.0, GREY, HPos::Center))
            .axis_desc_style(text(13.0, INK, HPos::Center))
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .draw()?;
        for (curve, colour) in self.curves.iter().zip(COLOURS.into_iter().cycle()) {
            let mut name = Some(&curve.name).filter(|name| !name.is_empty());
            for run in curve.points.split(|point| !is_shown(point)) {
                let points = run.iter().map(|[x, y]| (*x, *y));
                let line = LineSeries::new(points, colour.stroke_width(2));
                // A point between two gaps has no length.
                let line = line.point_size(if run.len() == 1 { 2 } else { 0 });
                let drawn = plane.draw_series(line)?;
                if let Some(name) = name.take() {
                    let mark = move |(x, y)| {
                        PathElement::new([(x, y), (x + 16, y)], colour.stroke_width(3))
                    };
                    drawn.label(name).legend(mark);
                }
            }
        }
        plane
            .configure_series_labels()
            .background_style(WHITE)
            .label_font(text(13.0, INK, HPos::Left))
            .draw()?;
        root.present()?;
        drop((plane, head, body, root));
        Ok(svg)
    }

    /// What the axes span: curves start and end at the sides.
    fn spans(&self) -> (Range<f64>, Range<f64>) {
        let points = || {
            let points = self.curves.iter().flat_map(|curve| &curve.points);
            points.filter(|point| is_shown(point))
        };
        let x = spanned(points().map(|[x, _]| *x)).unwrap_or(0.0..1.0);
        let Some(Range { start, end }) = spanned(points().map(|[_, y]| *y)) else {
            return (x, 0.0..1.0);
        };
        let room = (0.08 * (end - start)).max(1e-3 * end.abs());
        let is_near_zero = (0.0..0.5 * end).contains(&start);
        let from = if is_near_zero { 0.0 } else { start - room };
        (x, from..end + room)
    }
}

/// A style of text of so many pixels, anchored at its left, right or middle, and at half of its height.
fn text(size_px: f64, colour: RGBColor, anchor: HPos) -> TextStyle<'static> {
    // The backend divides sizes by 1.24.
    let font = FontDesc::new(FontFamily::Name(FONT), size_px * 1.24, FontStyle::Normal);
    let style = TextStyle::from(font).pos(Pos::new(anchor, VPos::Center));
    TextStyle {
        color: colour.to_backend_color(),
        ..style
    }
}

/// Values that a chart can show: neither infinite, nor so large that differences vanish.
fn is_shown(point: &[f64; 2]) -> bool {
    point.iter().all(|value| value.abs() < 1e12)
}

/// From the least to the greatest value, and at least 1 wide where these are one.
fn spanned(values: impl Iterator<Item = f64>) -> Option<Range<f64>> {
    let ends = values.map(|value| value..value);
    let Range { start, end } =
        ends.reduce(|one, other| one.start.min(other.start)..one.end.max(other.end))?;
    Some(start..if end > start { end } else { start + 1.0 })
}

/// A tick's text: no more digits than it has, but for errors of rounding.
fn tick(value: &f64) -> String {
    let rounded: f64 = format!("{value:.6e}").parse().unwrap_or(*value);
    // Ticks next to zero are zero but for errors of rounding.
    if rounded.abs() < 1e-9 {
        "0".to_owned()
    } else {
        rounded.to_string()
    }
}
