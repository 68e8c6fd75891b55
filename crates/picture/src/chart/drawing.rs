//! The shapes of a chart, and how they become SVG or pixels.

use crate::{
    Colour, Image, PictureError, Size,
    text::{Anchor, TextStyle},
};

/// A position in pixels from the top left.
pub(super) type Place = [f64; 2];

/// Something to draw; lengths are in pixels.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Shape {
    Line {
        points: Vec<Place>,
        width: f64,
        colour: Colour,
    },
    Rectangle {
        corner: Place,
        extent: [f64; 2],
        colour: Colour,
    },
    Circle {
        centre: Place,
        radius: f64,
        fill: Colour,
        stroke: Colour,
        width: f64,
    },
    Text {
        text: String,
        at: Place,
        anchor: Anchor,
        style: TextStyle,
    },
}

/// A finished chart.
#[derive(Debug, Clone)]
pub(super) struct Drawing {
    size: Size,
    shapes: Vec<Shape>,
}

impl Drawing {
    pub(super) fn new(size: Size) -> Self {
        Self {
            size,
            shapes: Vec::new(),
        }
    }

    pub(super) fn size(&self) -> [f64; 2] {
        [self.size.width().into(), self.size.height().into()]
    }

    pub(super) fn add(&mut self, shape: Shape) {
        self.shapes.push(shape);
    }

    pub(super) fn line(&mut self, from: Place, to: Place, width: f64, colour: Colour) {
        self.add(Shape::Line {
            points: vec![from, to],
            width,
            colour,
        });
    }

    pub(super) fn text(&mut self, text: &str, at: Place, anchor: Anchor, style: TextStyle) {
        if !text.is_empty() {
            self.add(Shape::Text {
                text: text.to_owned(),
                at,
                anchor,
                style,
            });
        }
    }

    /// The chart as an SVG document. Its text stays text, in the reader's own sans-serif font.
    pub(super) fn to_svg(&self) -> String {
        let (width, height) = (self.size.width(), self.size.height());
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" \
             font-family=\"'Noto Sans', 'Helvetica Neue', Arial, sans-serif\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
        );
        for shape in &self.shapes {
            svg.push_str(&element(shape));
            svg.push('\n');
        }
        svg.push_str("</svg>\n");
        svg
    }

    /// The chart as pixels, `scale` times as large.
    pub(super) fn to_image(&self, scale: u32) -> Result<Image, PictureError> {
        let (width, height) = (self.size.width(), self.size.height());
        let size = Size::new(width.saturating_mul(scale), height.saturating_mul(scale))?;
        let mut image = Image::filled(size, Colour::WHITE);
        let scale = f64::from(scale);
        for shape in &self.shapes {
            paint(&mut image, shape, scale);
        }
        Ok(image)
    }
}

/// A shape as an SVG element.
fn element(shape: &Shape) -> String {
    match shape {
        Shape::Line {
            points,
            width,
            colour,
        } => {
            let points: Vec<String> = points
                .iter()
                .map(|[x, y]| format!("{x:.1},{y:.1}"))
                .collect();
            format!(
                "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{width}\" \
                 stroke-linecap=\"round\" stroke-linejoin=\"round\"/>",
                points.join(" "),
                hex(*colour)
            )
        }
        Shape::Rectangle {
            corner: [x, y],
            extent: [width, height],
            colour,
        } => format!(
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"{}\"/>",
            hex(*colour)
        ),
        Shape::Circle {
            centre: [x, y],
            radius,
            fill,
            stroke,
            width,
        } => format!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\" fill=\"{}\" stroke=\"{}\" \
             stroke-width=\"{width}\"/>",
            hex(*fill),
            hex(*stroke)
        ),
        Shape::Text {
            text,
            at: [x, y],
            anchor,
            style,
        } => {
            let anchor = match anchor {
                Anchor::Start => "start",
                Anchor::Middle => "middle",
                Anchor::End => "end",
            };
            let weight = if style.bold {
                " font-weight=\"bold\""
            } else {
                ""
            };
            format!(
                "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{}\" fill=\"{}\" \
                 text-anchor=\"{anchor}\"{weight}>{}</text>",
                style.size_px,
                hex(style.colour),
                escaped(text)
            )
        }
    }
}

fn hex(Colour { red, green, blue }: Colour) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// Text that may stand between XML tags; control characters, which may not, become spaces.
fn escaped(text: &str) -> String {
    let mut result = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => result.push_str("&amp;"),
            '<' => result.push_str("&lt;"),
            '>' => result.push_str("&gt;"),
            _ if letter.is_control() => result.push(' '),
            '\u{fffe}' | '\u{ffff}' => result.push(' '),
            _ => result.push(letter),
        }
    }
    result
}

fn paint(image: &mut Image, shape: &Shape, scale: f64) {
    let scaled = |[x, y]: Place| [x * scale, y * scale];
    match shape {
        Shape::Line {
            points,
            width,
            colour,
        } => {
            for pair in points.windows(2) {
                if let &[from, to] = pair {
                    paint_line(image, scaled(from), scaled(to), width * scale, *colour);
                }
            }
        }
        Shape::Rectangle {
            corner,
            extent,
            colour,
        } => {
            let [left, top] = scaled(*corner);
            let [width, height] = scaled(*extent);
            let covered = |low: f64, high: f64, pixel: i64| {
                (high.min(pixel as f64 + 1.0) - low.max(pixel as f64)).clamp(0.0, 1.0)
            };
            visit(image, [left, top], [left + width, top + height], |x, y| {
                (
                    covered(left, left + width, x) * covered(top, top + height, y),
                    *colour,
                )
            });
        }
        Shape::Circle {
            centre,
            radius,
            fill,
            stroke,
            width,
        } => {
            let (centre, radius, half) = (scaled(*centre), radius * scale, width * scale / 2.0);
            let reach = radius + half + 1.0;
            let low = centre.map(|place| place - reach);
            let high = centre.map(|place| place + reach);
            visit(image, low, high, |x, y| {
                let distance = (x as f64 + 0.5 - centre[0]).hypot(y as f64 + 0.5 - centre[1]);
                let inner = (radius - half + 0.5 - distance).clamp(0.0, 1.0);
                let outer = (radius + half + 0.5 - distance).clamp(0.0, 1.0);
                (outer, stroke.mixed(*fill, inner))
            });
        }
        Shape::Text {
            text,
            at,
            anchor,
            style,
        } => {
            let [x, y] = scaled(*at);
            let style = TextStyle {
                size_px: style.size_px * scale,
                ..*style
            };
            style.draw(image, text, x, y, *anchor);
        }
    }
}

/// A straight line with round ends: each pixel is covered by how near its centre is.
fn paint_line(image: &mut Image, from: Place, to: Place, width: f64, colour: Colour) {
    let reach = width / 2.0 + 1.0;
    let along = [to[0] - from[0], to[1] - from[1]];
    let squared = along[0] * along[0] + along[1] * along[1];
    let low = [from[0].min(to[0]) - reach, from[1].min(to[1]) - reach];
    let high = [from[0].max(to[0]) + reach, from[1].max(to[1]) + reach];
    visit(image, low, high, |x, y| {
        let offset = [x as f64 + 0.5 - from[0], y as f64 + 0.5 - from[1]];
        let share = if squared > 0.0 {
            ((offset[0] * along[0] + offset[1] * along[1]) / squared).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let distance = (offset[0] - share * along[0]).hypot(offset[1] - share * along[1]);
        (
            (width / 2.0 + 0.5 - distance).clamp(0.0, width.min(1.0)),
            colour,
        )
    });
}

/// Blends the colour that `coverage` gives for each pixel between two corners.
fn visit(
    image: &mut Image,
    low: Place,
    high: Place,
    mut coverage: impl FnMut(i64, i64) -> (f64, Colour),
) {
    let (width, height) = (
        i64::from(image.size().width()),
        i64::from(image.size().height()),
    );
    let [left, top] = low.map(|place| place.floor().max(0.0) as i64);
    let [right, bottom] = high.map(|place| place.ceil() as i64);
    for y in top..bottom.min(height) {
        for x in left..right.min(width) {
            let (share, colour) = coverage(x, y);
            if share > 0.0 {
                image.blend(x, y, colour, share as f32);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped() {
        assert_eq!(escaped("a < b & c\u{7}"), "a &lt; b &amp; c ");
    }

    #[test]
    fn painted_shapes_cover_their_area() {
        let mut drawing = Drawing::new(Size::new(40, 40).unwrap());
        drawing.line([5.0, 20.5], [35.0, 20.5], 3.0, Colour::BLACK);
        drawing.add(Shape::Rectangle {
            corner: [2.0, 30.0],
            extent: [4.5, 4.0],
            colour: Colour::BLACK,
        });
        let image = drawing.to_image(1).unwrap();
        assert_eq!(image.colour(20, 20), Some(Colour::BLACK));
        assert_eq!(image.colour(20, 24), Some(Colour::WHITE));
        assert_eq!(image.colour(3, 31), Some(Colour::BLACK));
        assert_eq!(image.colour(6, 31).map(|colour| colour.red), Some(128));
        assert_eq!(
            drawing.to_image(3).unwrap().size(),
            Size::new(120, 120).unwrap()
        );
    }
}
