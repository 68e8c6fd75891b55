//! Scatter charts: labelled points, with intervals of uncertainty.

use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use crate::frame::{self, ChartError, GREY, Plane};
use crate::labels::{Area, placed};
use crate::range::{around, around_logarithmic, drawable, logarithmic_ticks};

/// More labels than this could not be read, and finding their places takes time quadratic in their number.
const MOST_LABELS: usize = 100;

/// Points in the plane of two measures, such as quality against time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scatter {
    /// What the chart shows.
    pub title: String,
    /// What is along x, with its unit. The scale is logarithmic; points at or below 0 are left out.
    pub x_label: String,
    /// What is along y, with its unit.
    pub y_label: String,
    /// The points, in groups of one colour.
    pub series: Vec<PointSeries>,
}

/// Points of one kind.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PointSeries {
    /// The name in the legend; none if empty.
    pub name: String,
    /// Whether these are others' results, for comparison: they are hollow and grey.
    pub reference: bool,
    /// The points; those that are not finite are left out.
    pub points: Vec<PlotPoint>,
}

/// A point with its uncertainty.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlotPoint {
    /// The text beside it; none if empty. Only the first hundred points of a chart are labelled.
    pub label: String,
    /// The value along x.
    pub x: f64,
    /// The value along y.
    pub y: f64,
    /// The uncertainty along x.
    pub x_interval: Option<Interval>,
    /// The uncertainty along y.
    pub y_interval: Option<Interval>,
}

/// An interval of uncertainty around a value, such as a 95 % confidence interval, in the value's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// The lower end.
    pub low: f64,
    /// The upper end.
    pub high: f64,
}

impl Scatter {
    /// The chart as an SVG document of `[width, height]` pixels.
    ///
    /// # Errors
    /// [`ChartError`] where the library cannot draw it.
    pub fn to_svg(&self, size: [u32; 2]) -> Result<String, ChartError> {
        let points = || self.series.iter().flat_map(PointSeries::shown);
        let x = around_logarithmic(points().flat_map(|point| with_ends(point.x, point.along_x())));
        let y = around(points().flat_map(|point| with_ends(point.y, point.along_y())));
        let ticks = logarithmic_ticks(&x);
        let x = x.log_scale().with_key_points(ticks);
        let labels = [self.x_label.as_str(), &self.y_label];
        frame::document(size, &self.title, |area| {
            let names = self.series.iter().map(|series| &series.name);
            let area = frame::legend(area, names, |area, at, index| {
                let series = self.series.get(index);
                let is_reference = series.is_some_and(|series| series.reference);
                dot(at, self.colour(index), is_reference)
                    .iter()
                    .try_for_each(|circle| Ok(area.draw(circle)?))
            })?;
            let mut plane = frame::plane(&area, x, y, labels, None)?;
            for (index, series) in self.series.iter().enumerate() {
                for point in series.shown() {
                    draw_point(&mut plane, point, self.colour(index), series.reference)?;
                }
            }
            self.draw_labels(&mut plane)
        })
    }

    /// Writes the labels beside their points.
    fn draw_labels<X: Ranged<ValueType = f64>>(
        &self,
        plane: &mut Plane<'_, '_, X>,
    ) -> Result<(), ChartError> {
        let place = |x: f64, y: f64| {
            let (right, down) = plane.plotting_area().map_coordinate(&(x, y));
            [f64::from(right), f64::from(down)]
        };
        let (mut obstacles, mut labels, mut extents) = (Vec::new(), Vec::new(), Vec::new());
        for (index, series) in self.series.iter().enumerate() {
            let style = frame::text(13.0, darker(self.colour(index)), HPos::Center);
            for point in series.shown() {
                let PlotPoint { x, y, .. } = *point;
                obstacles.push(Area::of([place(x, y); 2], 7.0));
                let along_x = point.along_x();
                let along_x = along_x.map(|ends| [place(ends.low, y), place(ends.high, y)]);
                let along_y = point.along_y();
                let along_y = along_y.map(|ends| [place(x, ends.low), place(x, ends.high)]);
                let lines = [along_x, along_y].into_iter().flatten();
                obstacles.extend(lines.map(|line| Area::of(line, 4.0)));
                if !point.label.is_empty() && labels.len() < MOST_LABELS {
                    let (width, height) = plane
                        .plotting_area()
                        .estimate_text_size(&point.label, &style)?;
                    extents.push((
                        place(x, y),
                        [f64::from(width) + 8.0, f64::from(height.max(13))],
                    ));
                    labels.push((point, style.clone()));
                }
            }
        }
        let (across, down) = plane.plotting_area().get_pixel_range();
        let ends = [[across.start, down.start], [across.end, down.end]];
        let bounds = Area::of(ends.map(|end| end.map(f64::from)), 0.0);
        let spots = placed(&extents, obstacles, bounds);
        for (((point, style), ([x, y], _)), spot) in labels.into_iter().zip(extents).zip(spots) {
            let [right, down] = spot.middle();
            let offset = ((right - x).round() as i32, (down - y).round() as i32);
            let text = Text::new(point.label.clone(), offset, style);
            plane.draw_series([EmptyElement::at((point.x, point.y)) + text])?;
        }
        Ok(())
    }

    /// Reference series are grey; the others take the palette's colours in turn.
    fn colour(&self, index: usize) -> RGBColor {
        match self.series.get(index) {
            Some(series) if series.reference => GREY,
            _ => {
                let before = self.series.iter().take(index);
                frame::colour(before.filter(|series| !series.reference).count())
            }
        }
    }
}

impl PointSeries {
    fn shown(&self) -> impl Iterator<Item = &PlotPoint> {
        let is_shown = |at: &&PlotPoint| drawable(at.x) && drawable(at.y) && at.x > 0.0;
        self.points.iter().filter(is_shown)
    }
}

impl PlotPoint {
    /// The interval along x, where it can be shown.
    fn along_x(&self) -> Option<Interval> {
        let ends = self.x_interval.filter(Interval::is_drawable);
        ends.filter(|ends| ends.low > 0.0)
    }

    /// The interval along y, where it can be shown.
    fn along_y(&self) -> Option<Interval> {
        self.y_interval.filter(Interval::is_drawable)
    }
}

impl Interval {
    fn is_drawable(&self) -> bool {
        drawable(self.low) && drawable(self.high)
    }
}

/// Draws a point and its intervals, which are paler.
fn draw_point<X: Ranged<ValueType = f64>>(
    plane: &mut Plane<'_, '_, X>,
    point: &PlotPoint,
    colour: RGBColor,
    is_reference: bool,
) -> Result<(), ChartError> {
    let PlotPoint { x, y, .. } = *point;
    let pale = colour.mix(0.5).stroke_width(1);
    if let Some(Interval { low, high }) = point.along_x() {
        plane.draw_series([ErrorBar::new_horizontal(y, low, x, high, pale, 8)])?;
    }
    if let Some(Interval { low, high }) = point.along_y() {
        plane.draw_series([ErrorBar::new_vertical(x, low, y, high, pale, 8)])?;
    }
    plane.draw_series(dot((x, y), colour, is_reference))?;
    Ok(())
}

fn with_ends(value: f64, interval: Option<Interval>) -> impl Iterator<Item = f64> {
    let ends = interval
        .into_iter()
        .flat_map(|Interval { low, high }| [low, high]);
    ends.chain([value])
}

/// A point; a reference is hollow. The white below keeps neighbours apart.
fn dot<C: Copy>(at: C, colour: RGBColor, is_reference: bool) -> [Circle<C, i32>; 2] {
    let (rim, mark) = if is_reference {
        (5, colour.stroke_width(2))
    } else {
        (6, colour.filled())
    };
    [
        Circle::new(at, rim, WHITE.filled()),
        Circle::new(at, 5, mark),
    ]
}

/// As a text's colour: thin letters look paler than points.
fn darker(RGBColor(red, green, blue): RGBColor) -> RGBColor {
    let channel = |value: u8| (u16::from(value) * 5 / 8) as u8;
    RGBColor(channel(red), channel(green), channel(blue))
}
