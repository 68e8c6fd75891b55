//! Line charts: how a measure develops.

use plotters::prelude::*;

use crate::frame::{self, ChartError};
use crate::range::{around, drawable, exact, from_zero};

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
    /// The chart as an SVG document of `[width, height]` pixels.
    ///
    /// # Errors
    /// [`ChartError`] where the library cannot draw it.
    pub fn to_svg(&self, size: [u32; 2]) -> Result<String, ChartError> {
        let points = || {
            self.curves
                .iter()
                .flat_map(|curve| &curve.points)
                .filter(|point| is_shown(point))
        };
        // Curves start and end at the sides.
        let x = exact(points().map(|[x, _]| *x)).unwrap_or(0.0..1.0);
        let y = || points().map(|[_, y]| *y);
        let is_near_zero = exact(y()).is_some_and(|y| (0.0..0.5 * y.end).contains(&y.start));
        let y = if is_near_zero {
            from_zero(y())
        } else {
            around(y())
        };
        let labels = [self.x_label.as_str(), &self.y_label];
        frame::document(size, &self.title, |area| {
            let area = frame::legend(
                area,
                self.curves.iter().map(|curve| &curve.name),
                |area, (x, y), index| {
                    let stroke = frame::colour(index).stroke_width(3);
                    Ok(area.draw(&PathElement::new([(x - 8, y), (x + 8, y)], stroke))?)
                },
            )?;
            let mut plane = frame::plane(&area, x, y, labels, None)?;
            for (index, curve) in self.curves.iter().enumerate() {
                let colour = frame::colour(index);
                for run in curve.points.split(|point| !is_shown(point)) {
                    let points = run.iter().map(|[x, y]| (*x, *y));
                    if let [[x, y]] = run {
                        plane.draw_series([Circle::new((*x, *y), 2, colour.filled())])?;
                    } else {
                        plane.draw_series(LineSeries::new(points, colour.stroke_width(2)))?;
                    }
                }
            }
            Ok(())
        })
    }
}

fn is_shown([x, y]: &[f64; 2]) -> bool {
    drawable(*x) && drawable(*y)
}
