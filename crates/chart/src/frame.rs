//! What all charts share: the document, its title and legend, axes and grid, and the looks.

use std::ops::Range;

use plotters::chart::ChartContext;
use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::range::tick;

/// A part of the document.
pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

/// The plane between the axes.
pub(crate) type Plane<'a, 'b, X> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<X, RangedCoordf64>>;

/// Titles and names.
pub(crate) const INK: RGBColor = RGBColor(0x1f, 0x29, 0x33);
/// Secondary text, and what is there for comparison.
pub(crate) const GREY: RGBColor = RGBColor(0x61, 0x6e, 0x7c);
const AXIS: RGBColor = RGBColor(0x9a, 0xa5, 0xb1);
const GRID: RGBColor = RGBColor(0xe4, 0xe7, 0xeb);

/// The colours of curves and points (Okabe and Ito), told apart by colour-blind readers too.
const SERIES: [RGBColor; 8] = [
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x00, 0x9e, 0x73),
    RGBColor(0xcc, 0x79, 0xa7),
    RGBColor(0xe6, 0x9f, 0x00),
    RGBColor(0x56, 0xb4, 0xe9),
    RGBColor(0x5c, 0x66, 0x70),
    RGBColor(0x00, 0x00, 0x00),
];

const FONT: &str = "'Noto Sans', 'Helvetica Neue', Arial, sans-serif";

/// Space between the document's edge and what is drawn, in pixels.
const MARGIN: i32 = 22;

/// The height of a line of the legend, in pixels.
const LINE: i32 = 24;

/// A chart that the library cannot draw.
#[derive(Debug, thiserror::Error)]
#[error("the chart cannot be drawn: {0}")]
pub struct ChartError(String);

impl<E: std::error::Error + Send + Sync> From<DrawingAreaErrorKind<E>> for ChartError {
    fn from(error: DrawingAreaErrorKind<E>) -> Self {
        Self(error.to_string())
    }
}

/// The colour of a series by its index; they repeat after eight.
pub(crate) fn colour(index: usize) -> RGBColor {
    SERIES.get(index % SERIES.len()).copied().unwrap_or(INK)
}

/// A style of text of so many pixels, anchored at its left, right or middle, and at half of its height.
pub(crate) fn text(size_px: f64, colour: RGBColor, anchor: HPos) -> TextStyle<'static> {
    // The backend divides sizes by 1.24.
    let font = FontDesc::new(FontFamily::Name(FONT), size_px * 1.24, FontStyle::Normal);
    let style = TextStyle::from(font).pos(Pos::new(anchor, VPos::Center));
    TextStyle {
        color: colour.to_backend_color(),
        ..style
    }
}

/// A document of `[width, height]` pixels with a title and what `draw` draws below it.
pub(crate) fn document(
    [width, height]: [u32; 2],
    title: &str,
    draw: impl FnOnce(&Area<'_>) -> Result<(), ChartError>,
) -> Result<String, ChartError> {
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (width, height)).into_drawing_area();
        root.fill(&WHITE)?;
        let (head, body) = root.split_vertically(48);
        let bold = FontDesc::new(FontFamily::Name(FONT), 19.0 * 1.24, FontStyle::Bold);
        let style = TextStyle::from(bold)
            .color(&INK)
            .pos(Pos::new(HPos::Left, VPos::Center));
        head.draw(&Text::new(title.to_owned(), (MARGIN, 29), style))?;
        draw(&body)?;
        root.present()?;
    }
    Ok(svg)
}

/// Draws names, each beside the mark of its index, into lines as wide as the area; returns what is below.
pub(crate) fn legend<'a, 'n>(
    area: &Area<'a>,
    names: impl Iterator<Item = &'n String>,
    mark: impl Fn(&Area<'a>, (i32, i32), usize) -> Result<(), ChartError>,
) -> Result<Area<'a>, ChartError> {
    let style = text(13.0, INK, HPos::Left);
    let (right, mut x, mut y) = (area.dim_in_pixel().0 as i32 - MARGIN, MARGIN, 10);
    let mut used = 0;
    for (index, name) in names.enumerate().filter(|(_, name)| !name.is_empty()) {
        let width = 26 + area.estimate_text_size(name, &style)?.0 as i32;
        if x > MARGIN && x + width > right {
            (x, y) = (MARGIN, y + LINE);
        }
        mark(area, (x + 9, y), index)?;
        area.draw(&Text::new(name.clone(), (x + 24, y), style.clone()))?;
        x += width + 20;
        used = y + LINE / 2;
    }
    Ok(area.split_vertically(used).1)
}

/// Draws axes, with their ticks and the labels of x and y, and a grid. Names take `names_px` left of the y axis, which
/// then has no ticks.
pub(crate) fn plane<'a, 'b, X>(
    area: &'a Area<'b>,
    x: X,
    y: Range<f64>,
    [x_label, y_label]: [&str; 2],
    names_px: Option<u32>,
) -> Result<Plane<'a, 'b, X::CoordDescType>, ChartError>
where
    X: AsRangedCoord<Value = f64>,
    X::CoordDescType: ValueFormatter<f64>,
{
    let mut plane = ChartBuilder::on(area)
        .margin(MARGIN)
        .margin_top(12)
        .x_label_area_size(46)
        .y_label_area_size(names_px.unwrap_or(54))
        .build_cartesian_2d(x, y)?;
    plane
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .axis_style(AXIS)
        .x_labels(9)
        .y_labels(if names_px.is_some() { 0 } else { 7 })
        .x_label_formatter(&tick)
        .y_label_formatter(&tick)
        .label_style(text(13.0, GREY, HPos::Center))
        .axis_desc_style(text(13.0, INK, HPos::Center))
        .x_desc(x_label)
        .y_desc(y_label)
        .draw()?;
    Ok(plane)
}
