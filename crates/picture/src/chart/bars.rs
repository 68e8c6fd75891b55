//! Bar charts: one measure of several things.

use super::{
    Axis, Interval, drawable,
    drawing::{Drawing, Shape},
    plot::{LABEL, MARGIN, TICK, draw_heading},
};
use crate::{Colour, Image, PictureError, Size, text::Anchor};

/// Horizontal bars from zero, one below the other in the given order, each with its value.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Bars {
    /// What the chart shows.
    pub title: String,
    /// What the bars measure, with its unit.
    pub value_label: String,
    /// How many decimals the values are shown with.
    pub decimals: usize,
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
    /// The value's uncertainty.
    pub interval: Option<Interval>,
    /// Whether it is others' result, for comparison: it is grey.
    pub reference: bool,
}

impl Bars {
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
        let mut drawing = Drawing::new(size);
        let [width, height] = drawing.size();
        let top = draw_heading(&mut drawing, &self.title, &[]) + 22.0;
        let names = self
            .bars
            .iter()
            .map(|bar| LABEL.width_px(&bar.label))
            .fold(0.0, f64::max);
        let left = MARGIN + names.min(0.4 * width) + 12.0;
        let values: Vec<String> = self.bars.iter().map(|bar| self.text(bar)).collect();
        let value_width = values
            .iter()
            .map(|text| LABEL.width_px(text))
            .fold(0.0, f64::max);
        let right = (width - MARGIN - value_width - 12.0).max(left + 1.0);
        let bottom = (height - 62.0).max(top + 1.0);

        let ends = self
            .bars
            .iter()
            .flat_map(|bar| [Some(bar.value), bar.interval.map(|ends| ends.high)]);
        let axis = Axis::from_zero(ends.flatten());
        let along = |value: f64| left + axis.share(value) * (right - left);
        for (value, text) in axis.ticks() {
            let x = along(value);
            drawing.line([x, top], [x, bottom], 1.0, Colour::FAINT);
            drawing.text(&text, [x, bottom + 20.0], Anchor::Middle, TICK);
        }
        let step = (bottom - top) / self.bars.len().max(1) as f64;
        for (index, (bar, text)) in self.bars.iter().zip(&values).enumerate() {
            let middle = top + (index as f64 + 0.5) * step;
            let baseline = middle + LABEL.baseline_below_middle();
            let name = LABEL.fitted(&bar.label, left - 12.0 - MARGIN);
            drawing.text(&name, [left - 10.0, baseline], Anchor::End, LABEL);
            let colour = if bar.reference {
                Colour::LINE
            } else {
                Colour::of_series(0)
            };
            let mut end = left;
            if drawable(bar.value) && bar.value >= 0.0 {
                end = along(bar.value);
                let thickness = (0.62 * step).min(34.0);
                let corner = [left, middle - thickness / 2.0];
                let extent = [end - left, thickness];
                drawing.add(Shape::Rectangle {
                    corner,
                    extent,
                    colour,
                });
            }
            if let Some(Interval { low, high }) = bar.interval
                && drawable(low)
                && drawable(high)
            {
                let (low, high) = (along(low.max(0.0)), along(high.max(0.0)));
                let dark = colour.mixed(Colour::INK, 0.6);
                drawing.line([low, middle], [high, middle], 1.5, dark);
                for x in [low, high] {
                    drawing.line([x, middle - 4.0], [x, middle + 4.0], 1.5, dark);
                }
                end = end.max(high);
            }
            drawing.text(text, [end + 8.0, baseline], Anchor::Start, LABEL);
        }
        drawing.line([left, top], [left, bottom], 1.25, Colour::LINE);
        let middle = (left + right) / 2.0;
        drawing.text(
            &self.value_label,
            [middle, bottom + 46.0],
            Anchor::Middle,
            LABEL,
        );
        drawing
    }

    fn text(&self, bar: &Bar) -> String {
        let decimals = self.decimals.min(9);
        if drawable(bar.value) {
            format!("{:.decimals$}", bar.value)
        } else {
            String::new()
        }
    }
}
