//! Galleries: pictures of several things side by side, a column each, under their names.

use crate::colour::Colour;
use crate::error::PictureError;
use crate::image::{Image, Size};
use crate::text::{Anchor, TextStyle};

/// Space around and between pictures, in pixels.
const GAP: u32 = 24;

/// Height of the title's line, in pixels.
const TITLE: u32 = 56;

/// Height of a column's name and the line below it, in pixels.
const CAPTION: u32 = 56;

/// One column of a gallery.
#[derive(Debug, Clone)]
pub struct Column {
    /// What it shows, cut off where it is too long.
    pub name: String,
    /// A line below the name, such as what was measured.
    pub detail: String,
    /// From the top.
    pub pictures: Vec<Image>,
}

/// Columns of pictures under a title. Rows are as high as their highest picture, all columns as wide as the widest one.
///
/// # Errors
/// [`PictureError::Size`] where it has too many pixels.
pub fn gallery(title: &str, columns: &[Column]) -> Result<Image, PictureError> {
    let pictures = columns.iter().flat_map(|column| &column.pictures);
    let width = pictures.map(|image| image.size().width()).max();
    let width = width.unwrap_or(1);
    let heights = row_heights(columns);
    let step = width.saturating_add(GAP);
    let all_heights = heights
        .iter()
        .fold(0_u32, |sum, height| sum.saturating_add(height + GAP));
    let size = Size::new(
        step.saturating_mul(columns.len().max(1) as u32)
            .saturating_add(GAP),
        (TITLE + CAPTION + GAP).saturating_add(all_heights),
    )?;

    let mut sheet = Image::filled(size, Colour::WHITE);
    let heading = TextStyle::new(24.0, Colour::INK).bold();
    let fitted = heading.fitted(title, f64::from(size.width().saturating_sub(2 * GAP)));
    heading.draw(&mut sheet, &fitted, f64::from(GAP), 38.0, Anchor::Start);
    for (number, column) in (0..).zip(columns) {
        let left = GAP + number * step;
        caption(&mut sheet, column, left, width);
        let mut top = TITLE + CAPTION;
        for (picture, height) in column.pictures.iter().zip(&heights) {
            let aside = (width - picture.size().width()) / 2;
            sheet.paste((left + aside).into(), top.into(), picture);
            top += height + GAP;
        }
    }
    Ok(sheet)
}

/// The height of each row, in pixels.
fn row_heights(columns: &[Column]) -> Vec<u32> {
    let mut heights = Vec::new();
    for column in columns {
        heights.resize(heights.len().max(column.pictures.len()), 0);
        for (height, picture) in heights.iter_mut().zip(&column.pictures) {
            *height = picture.size().height().max(*height);
        }
    }
    heights
}

/// Writes what a column shows over it.
fn caption(sheet: &mut Image, column: &Column, left: u32, width: u32) {
    let middle = f64::from(left) + f64::from(width) / 2.0;
    let lines = [
        (TextStyle::new(20.0, Colour::INK).bold(), &column.name, 20),
        (TextStyle::new(15.0, Colour::GREY), &column.detail, 42),
    ];
    for (style, text, below) in lines {
        let text = style.fitted(text, width.into());
        let baseline = f64::from(TITLE + below);
        style.draw(sheet, &text, middle, baseline, Anchor::Middle);
    }
}
