//! Bar charts: one measure of several things.

use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use crate::frame::{self, ChartError, INK};
use crate::range::{drawable, from_zero};

/// Horizontal bars from zero, one below the other in the given order, each with its value to one decimal.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Bars {
    /// What the chart shows.
    pub title: String,
    /// What the bars measure, with its unit.
    pub value_label: String,
    /// The bars.
    pub bars: Vec<Bar>,
}

/// One bar.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Bar {
    /// Its name, left of it.
    pub label: String,
    /// Its length; bars that are negative or not finite have none.
    pub value: f64,
}

impl Bars {
    /// The chart as an SVG document of `[width, height]` pixels.
    ///
    /// # Errors
    /// [`ChartError`] where the library cannot draw it.
    pub fn to_svg(&self, size: [u32; 2]) -> Result<String, ChartError> {
        let values = self.bars.iter().map(|bar| bar.value);
        // The last tenth is for the value beside the longest bar.
        let x = 0.0..1.1 * from_zero(values).end;
        let name_style = frame::text(13.0, INK, HPos::Right);
        let value_style = frame::text(13.0, INK, HPos::Left);
        frame::document(size, &self.title, |area| {
            let mut names_px = 0;
            for bar in &self.bars {
                names_px = names_px.max(area.estimate_text_size(&bar.label, &name_style)?.0);
            }
            // From the top down.
            let y = self.bars.len().max(1) as f64..0.0;
            let labels = [self.value_label.as_str(), ""];
            let mut plane = frame::plane(area, x, y, labels, Some(names_px + 12))?;
            for (index, bar) in self.bars.iter().enumerate() {
                let middle = index as f64 + 0.5;
                let name = Text::new(bar.label.clone(), (-10, 0), name_style.clone());
                plane.draw_series([EmptyElement::at((0.0, middle)) + name])?;
                if !drawable(bar.value) {
                    continue;
                }
                let length = bar.value.max(0.0);
                let corners = [(0.0, middle - 0.25), (length, middle + 0.25)];
                plane.draw_series([Rectangle::new(corners, frame::colour(0).filled())])?;
                let value = format!("{:.1}", bar.value);
                let value = Text::new(value, (8, 0), value_style.clone());
                plane.draw_series([EmptyElement::at((length, middle)) + value])?;
            }
            Ok(())
        })
    }
}
