//! Line charts: how a measure develops.

use super::{
    Axis, drawable,
    drawing::{Drawing, Place, Shape},
    plot::{Mark, Plot, Texts},
};
use crate::{Colour, Image, PictureError, Size};

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

impl Lines {
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
        let points = || {
            self.curves
                .iter()
                .flat_map(|curve| &curve.points)
                .filter(|point| shown(point))
        };
        let legend: Vec<(Mark, Colour, &str)> = self
            .curves
            .iter()
            .enumerate()
            .map(|(index, curve)| (Mark::Line, Colour::of_series(index), curve.name.as_str()))
            .collect();
        let texts = Texts {
            title: &self.title,
            x_label: &self.x_label,
            y_label: &self.y_label,
        };
        let axes = [
            x_axis(points().map(|[x, _]| *x)),
            y_axis(points().map(|[_, y]| *y)),
        ];
        let (mut drawing, plot) = Plot::new(size, texts, &legend, axes);
        for (index, curve) in self.curves.iter().enumerate() {
            let colour = Colour::of_series(index);
            for run in curve.points.split(|point| !shown(point)) {
                let points: Vec<Place> = run.iter().map(|[x, y]| plot.place(*x, *y)).collect();
                match points.as_slice() {
                    [] => {}
                    [only] => drawing.line(*only, *only, 4.0, colour),
                    _ => drawing.add(Shape::Line {
                        points,
                        width: 2.25,
                        colour,
                    }),
                }
            }
        }
        drawing
    }
}

fn shown([x, y]: &[f64; 2]) -> bool {
    drawable(*x) && drawable(*y)
}

/// Exactly the range of the values: curves start and end at the sides.
fn x_axis(values: impl Iterator<Item = f64>) -> Axis {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    if low <= high {
        Axis::linear(low, high)
    } else {
        Axis::linear(0.0, 1.0)
    }
}

fn y_axis(values: impl Iterator<Item = f64> + Clone) -> Axis {
    let lowest = values.clone().fold(f64::INFINITY, f64::min);
    let highest = values.clone().fold(f64::NEG_INFINITY, f64::max);
    if (0.0..0.5 * highest).contains(&lowest) {
        Axis::from_zero(values)
    } else {
        Axis::around(values)
    }
}
