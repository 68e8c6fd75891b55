//! What all charts share: title, legend, axes and grid.

use super::{
    Axis,
    drawing::{Drawing, Place, Shape},
    labels::Area,
};
use crate::{
    Colour, Size,
    text::{Anchor, TextStyle},
};

/// How an entry of the legend is marked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mark {
    Dot,
    HollowDot,
    Line,
}

/// The texts around a chart.
#[derive(Debug, Clone, Copy)]
pub(super) struct Texts<'a> {
    pub(super) title: &'a str,
    pub(super) x_label: &'a str,
    pub(super) y_label: &'a str,
}

/// The area between the axes, in pixels, and what they span.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plot {
    pub(super) area: Area,
    x: Axis,
    y: Axis,
}

pub(super) const TICK: TextStyle = TextStyle {
    size_px: 13.0,
    bold: false,
    colour: Colour::GREY,
};
pub(super) const LABEL: TextStyle = TextStyle {
    size_px: 13.0,
    bold: false,
    colour: Colour::INK,
};
const TITLE: TextStyle = TextStyle {
    size_px: 19.0,
    bold: true,
    colour: Colour::INK,
};

/// Space between the picture's edge and what is drawn, in pixels.
pub(super) const MARGIN: f64 = 22.0;

impl Plot {
    /// Lays out a chart: draws all but its data, and says where the data goes. Entries without a name are left out of
    /// the legend.
    pub(super) fn new(
        size: Size,
        texts: Texts<'_>,
        legend: &[(Mark, Colour, &str)],
        [x, y]: [Axis; 2],
    ) -> (Drawing, Self) {
        let mut drawing = Drawing::new(size);
        let [width, height] = drawing.size();
        let y_ticks = y.ticks();
        let tick_width = y_ticks
            .iter()
            .map(|(_, text)| TICK.width_px(text))
            .fold(0.0, f64::max);

        let below_title = draw_heading(&mut drawing, texts.title, legend);
        let left = MARGIN + tick_width + 10.0;
        let top = below_title + 46.0;
        let area = Area {
            left,
            top,
            right: (width - MARGIN - 6.0).max(left + 1.0),
            bottom: (height - 62.0).max(top + 1.0),
        };
        let plot = Self { area, x, y };

        for (value, text) in y_ticks {
            let across = plot.place(0.0, value)[1];
            drawing.line(
                [area.left, across],
                [area.right, across],
                1.0,
                Colour::FAINT,
            );
            let at = [area.left - 9.0, across + TICK.baseline_below_middle()];
            drawing.text(&text, at, Anchor::End, TICK);
        }
        for (value, text) in x.ticks() {
            let along = plot.along(value);
            drawing.line([along, area.top], [along, area.bottom], 1.0, Colour::FAINT);
            drawing.text(&text, [along, area.bottom + 20.0], Anchor::Middle, TICK);
        }
        drawing.line(
            [area.left, area.bottom],
            [area.right, area.bottom],
            1.25,
            Colour::LINE,
        );
        drawing.text(texts.y_label, [MARGIN, top - 16.0], Anchor::Start, LABEL);
        let middle = (area.left + area.right) / 2.0;
        drawing.text(
            texts.x_label,
            [middle, area.bottom + 46.0],
            Anchor::Middle,
            LABEL,
        );
        (drawing, plot)
    }

    /// Where a value is along x, in pixels.
    pub(super) fn along(&self, x: f64) -> f64 {
        self.area.left + self.x.share(x) * (self.area.right - self.area.left)
    }

    /// Where a pair of values is, in pixels.
    pub(super) fn place(&self, x: f64, y: f64) -> Place {
        let down = self.area.bottom - self.y.share(y) * (self.area.bottom - self.area.top);
        [self.along(x), down]
    }
}

/// Draws title and legend, and returns how far down they reach.
pub(super) fn draw_heading(
    drawing: &mut Drawing,
    title: &str,
    legend: &[(Mark, Colour, &str)],
) -> f64 {
    let [width, _] = drawing.size();
    let fitted = TITLE.fitted(title, width - 2.0 * MARGIN);
    drawing.text(&fitted, [MARGIN, MARGIN + 14.0], Anchor::Start, TITLE);
    let mut y = MARGIN + 14.0;
    // Beyond the right end, so that the first entry starts a line.
    let mut x = width;
    for (mark, colour, name) in legend.iter().filter(|(_, _, name)| !name.is_empty()) {
        let entry = 26.0 + LABEL.width_px(name) + 24.0;
        if x + entry > width - MARGIN {
            x = MARGIN;
            y += 26.0;
        }
        let middle = y - LABEL.baseline_below_middle();
        match mark {
            Mark::Line => drawing.line([x + 1.0, middle], [x + 17.0, middle], 2.5, *colour),
            Mark::Dot => drawing.add(dot([x + 9.0, middle], *colour)),
            Mark::HollowDot => drawing.add(hollow_dot([x + 9.0, middle], *colour)),
        }
        drawing.text(name, [x + 24.0, y], Anchor::Start, LABEL);
        x += entry;
    }
    y
}

/// A point of the chart's own data; the white rim keeps neighbours apart.
pub(super) fn dot(centre: Place, colour: Colour) -> Shape {
    Shape::Circle {
        centre,
        radius: 5.5,
        fill: colour,
        stroke: Colour::WHITE,
        width: 1.0,
    }
}

/// A point of reference data.
pub(super) fn hollow_dot(centre: Place, colour: Colour) -> Shape {
    Shape::Circle {
        centre,
        radius: 4.75,
        fill: Colour::WHITE,
        stroke: colour,
        width: 1.75,
    }
}
