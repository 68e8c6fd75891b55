//! Antialiased text in pictures, from a font inside the program.

use std::sync::LazyLock;

use ab_glyph::{Font, FontRef, PxScale, ScaleFont, point};

use crate::colour::Colour;
use crate::image::Image;

/// Noto Sans, under the SIL Open Font License 1.1. Absent if it could not be read: then pictures
/// lack their text.
static REGULAR: LazyLock<Option<FontRef<'static>>> =
    LazyLock::new(|| FontRef::try_from_slice(notosans::REGULAR_TTF).ok());
static BOLD: LazyLock<Option<FontRef<'static>>> =
    LazyLock::new(|| FontRef::try_from_slice(notosans::BOLD_TTF).ok());

/// The look of a text.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TextStyle {
    /// The height of the font's em square, in pixels.
    pub(crate) size_px: f64,
    pub(crate) bold: bool,
    pub(crate) colour: Colour,
}

/// The point of a text that is given, from left to right.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

impl Anchor {
    /// Gives the left end of a text of this width, anchored at `x`.
    pub(crate) fn left(self, x: f64, width: f64) -> f64 {
        match self {
            Self::Start => x,
            Self::Middle => x - width / 2.0,
            Self::End => x - width,
        }
    }
}

impl TextStyle {
    pub(crate) fn new(size_px: f64, colour: Colour) -> Self {
        Self {
            size_px,
            bold: false,
            colour,
        }
    }

    pub(crate) fn bold(self) -> Self {
        Self { bold: true, ..self }
    }

    /// Measures from a text's middle down to its baseline, in pixels: half the height of digits.
    pub(crate) fn baseline_below_middle(self) -> f64 {
        0.36 * self.size_px
    }

    fn font(self) -> Option<&'static FontRef<'static>> {
        if self.bold {
            BOLD.as_ref()
        } else {
            REGULAR.as_ref()
        }
    }

    /// Converts the size: the library scales by the distance from ascent to descent, not by the em.
    fn scale(self, font: &FontRef<'_>) -> PxScale {
        let per_em = font.units_per_em().unwrap_or(1_000.0);
        PxScale::from(self.size_px as f32 * font.height_unscaled() / per_em)
    }

    /// Measures the width of a text in pixels.
    pub(crate) fn width_px(self, text: &str) -> f64 {
        self.font().map_or(0.0, |font| {
            let scaled = font.as_scaled(self.scale(font));
            let advance = |letter| scaled.h_advance(scaled.glyph_id(letter));
            f64::from(text.chars().map(advance).sum::<f32>())
        })
    }

    /// Gives the text, or as much of its start as fits a width in pixels, followed by an ellipsis.
    pub(crate) fn fitted(self, text: &str, width_px: f64) -> String {
        if self.width_px(text) <= width_px {
            return text.to_owned();
        }
        let mut letters: Vec<char> = text.chars().collect();
        while letters.pop().is_some() {
            let short: String = letters.iter().collect::<String>().trim_end().to_owned() + "…";
            if self.width_px(&short) <= width_px {
                return short;
            }
        }
        String::new()
    }

    /// Writes a line of text with its anchor at `x` and its baseline at `y`, in pixels.
    pub(crate) fn draw(self, image: &mut Image, text: &str, x: f64, y: f64, anchor: Anchor) {
        let Some(font) = self.font() else { return };
        let scale = self.scale(font);
        let mut pen = anchor.left(x, self.width_px(text)) as f32;
        for letter in text.chars() {
            let id = font.glyph_id(letter);
            let glyph = id.with_scale_and_position(scale, point(pen, y as f32));
            pen += font.as_scaled(scale).h_advance(id);
            let Some(outline) = font.outline_glyph(glyph) else {
                continue;
            };
            let corner = outline.px_bounds().min;
            let (left, top) = (corner.x as i64, corner.y as i64);
            outline.draw(|column, row, coverage| {
                image.blend(
                    left.saturating_add(column.into()),
                    top.saturating_add(row.into()),
                    self.colour,
                    coverage,
                );
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Size;

    const STYLE: TextStyle = TextStyle {
        size_px: 20.0,
        bold: false,
        colour: Colour::BLACK,
    };

    #[test]
    fn text_leaves_ink_where_it_is_anchored() {
        let size = Size::new(200, 40).unwrap();
        let mut image = Image::filled(size, Colour::WHITE);
        STYLE.draw(&mut image, "Höhe 12 cm³", 190.0, 30.0, Anchor::End);
        let ink = |x| (0..40).any(|y| image.colour(x, y) != Some(Colour::WHITE));
        assert!((170..190).any(ink));
        assert!(!(0..40).any(ink) && !(192..200).any(ink));
    }

    #[test]
    fn long_texts_are_cut_to_fit() {
        assert_eq!(STYLE.fitted("short", 500.0), "short");
        let cut = STYLE.fitted("a rather long name of an object", 120.0);
        assert!(cut.ends_with('…') && STYLE.width_px(&cut) <= 120.0, "{cut}");
        assert_eq!(STYLE.fitted("name", 1.0), "");
    }
}
