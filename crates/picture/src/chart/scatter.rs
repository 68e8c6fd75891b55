//! Scatter charts: labelled points, with intervals of uncertainty.

use super::{
    Axis, Interval, drawable,
    drawing::Drawing,
    labels::{Area, placed},
    plot::{LABEL, Mark, Plot, Texts, dot, hollow_dot},
};
use crate::{Colour, Image, PictureError, Size, text::Anchor, text::TextStyle};

/// More labels than this could not be read, and finding their places takes time quadratic in their number.
const MOST_LABELS: usize = 100;

/// Points in the plane of two measures, such as quality against time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scatter {
    /// What the chart shows.
    pub title: String,
    /// What is along x, with its unit.
    pub x_label: String,
    /// What is along y, with its unit.
    pub y_label: String,
    /// Whether x is on a logarithmic scale; then points at or below 0 are left out.
    pub logarithmic_x: bool,
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

impl Scatter {
    /// The chart as an SVG document.
    pub fn to_svg(&self, size: Size) -> String {
        self.drawing(size).to_svg()
    }

    /// The chart as pixels, twice as many along each side as `size` says, for sharp text.
    ///
    /// # Errors
    /// [`PictureError::Size`] where those are too many.
    pub fn to_image(&self, size: Size) -> Result<Image, PictureError> {
        self.drawing(size).to_image(2)
    }

    fn drawing(&self, size: Size) -> Drawing {
        let points = || self.series.iter().flat_map(|series| &series.points);
        let points = || points().filter(|point| self.shows(point));
        let xs = points().flat_map(|point| {
            [
                Some(point.x),
                end(point.x_interval, low),
                end(point.x_interval, high),
            ]
        });
        let ys = points().flat_map(|point| {
            [
                Some(point.y),
                end(point.y_interval, low),
                end(point.y_interval, high),
            ]
        });
        let x = if self.logarithmic_x {
            Axis::logarithmic(xs.flatten())
        } else {
            Axis::around(xs.flatten())
        };
        let legend: Vec<(Mark, Colour, &str)> = self
            .series
            .iter()
            .enumerate()
            .map(|(index, series)| {
                let mark = if series.reference {
                    Mark::HollowDot
                } else {
                    Mark::Dot
                };
                (mark, self.colour(index), series.name.as_str())
            })
            .collect();
        let texts = Texts {
            title: &self.title,
            x_label: &self.x_label,
            y_label: &self.y_label,
        };
        let (mut drawing, plot) = Plot::new(size, texts, &legend, [x, Axis::around(ys.flatten())]);

        let mut obstacles = Vec::new();
        let mut labelled = Vec::new();
        for (index, series) in self.series.iter().enumerate() {
            let colour = self.colour(index);
            for point in series.points.iter().filter(|point| self.shows(point)) {
                let place = plot.place(point.x, point.y);
                obstacles.push(Area::around(place, 7.0));
                obstacles.extend(self.draw_intervals(&mut drawing, &plot, point, colour));
                drawing.add(if series.reference {
                    hollow_dot(place, colour)
                } else {
                    dot(place, colour)
                });
                if !point.label.is_empty() && labelled.len() < MOST_LABELS {
                    let style = label_style(series, colour);
                    let extent = [style.width_px(&point.label), style.size_px];
                    labelled.push(((place, extent), style, point.label.as_str()));
                }
            }
        }
        let points: Vec<_> = labelled.iter().map(|(point, _, _)| *point).collect();
        for (spot, (_, style, text)) in placed(&points, obstacles, plot.area)
            .into_iter()
            .zip(&labelled)
        {
            let baseline = (spot.top + spot.bottom) / 2.0 + style.baseline_below_middle();
            let middle = (spot.left + spot.right) / 2.0;
            drawing.text(text, [middle, baseline], Anchor::Middle, *style);
        }
        drawing
    }

    /// Draws a point's intervals, and returns the space they take.
    fn draw_intervals(
        &self,
        drawing: &mut Drawing,
        plot: &Plot,
        point: &PlotPoint,
        colour: Colour,
    ) -> Vec<Area> {
        let pale = colour.mixed(Colour::WHITE, 0.35);
        let mut taken = Vec::new();
        let x = point.x_interval.filter(|interval| {
            drawable(interval.low)
                && drawable(interval.high)
                && (!self.logarithmic_x || interval.low > 0.0 && interval.high > 0.0)
        });
        let y = point
            .y_interval
            .filter(|ends| drawable(ends.low) && drawable(ends.high));
        let x_ends =
            x.map(|Interval { low, high }| [plot.place(low, point.y), plot.place(high, point.y)]);
        let y_ends =
            y.map(|Interval { low, high }| [plot.place(point.x, low), plot.place(point.x, high)]);
        for (ends, [cap_x, cap_y]) in [(x_ends, [0.0, 4.0]), (y_ends, [4.0, 0.0])] {
            let Some([from, to]) = ends else { continue };
            drawing.line(from, to, 1.5, pale);
            for [x, y] in [from, to] {
                drawing.line([x - cap_x, y - cap_y], [x + cap_x, y + cap_y], 1.5, pale);
            }
            taken.push(Area {
                left: from[0].min(to[0]) - 4.0,
                right: from[0].max(to[0]) + 4.0,
                top: from[1].min(to[1]) - 4.0,
                bottom: from[1].max(to[1]) + 4.0,
            });
        }
        taken
    }

    fn shows(&self, point: &PlotPoint) -> bool {
        drawable(point.x) && drawable(point.y) && (!self.logarithmic_x || point.x > 0.0)
    }

    /// Reference series are grey; the others take the palette's colours in turn.
    fn colour(&self, index: usize) -> Colour {
        match self.series.get(index) {
            Some(series) if series.reference => Colour::GREY,
            _ => {
                let before = self.series.iter().take(index);
                Colour::of_series(before.filter(|series| !series.reference).count())
            }
        }
    }
}

fn label_style(series: &PointSeries, colour: Colour) -> TextStyle {
    if series.reference {
        TextStyle { colour, ..LABEL }
    } else {
        // Darker than the point, as thin letters look paler.
        TextStyle {
            colour: colour.mixed(Colour::INK, 0.45),
            ..LABEL
        }
    }
}

fn low(interval: Interval) -> f64 {
    interval.low
}

fn high(interval: Interval) -> f64 {
    interval.high
}

fn end(interval: Option<Interval>, which: impl Fn(Interval) -> f64) -> Option<f64> {
    interval.map(which)
}
