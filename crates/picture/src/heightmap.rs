//! Heightmaps as pictures: colours for heights, axes in centimetres, and a colour bar.

use crate::colour::Colour;
use crate::error::PictureError;
use crate::image::{Image, Size};
use crate::text::{Anchor, TextStyle};
use crate::ticks::ticks;

/// The longer side of the map itself, in pixels, unless it has more cells than that.
const MAP: usize = 720;

/// Space for the axes and the title, and for the colour bar, in pixels.
const LEFT: i64 = 84;
const TOP: i64 = 64;
const BOTTOM: i64 = 72;
const RIGHT: i64 = 150;

/// Heights on a grid, seen from above.
#[derive(Debug, Clone, Copy)]
pub struct HeightField<'a> {
    /// Cells along x.
    pub nx: usize,
    /// Cells along y.
    pub ny: usize,
    /// The edge of a cell, in metres.
    pub cell_m: f64,
    /// The height of cell `(x, y)` at `x * ny + y`, in metres. One that is not finite means that
    /// the cell is empty.
    pub heights_m: &'a [f64],
    /// The height of the upper end of the colour scale, in metres; the greatest height where there
    /// is none.
    pub scale_top_m: Option<f64>,
}

impl HeightField<'_> {
    /// # Errors
    /// [`PictureError`] where there are no cells, too many, or another number of heights.
    fn check(&self) -> Result<(), PictureError> {
        let Self { nx, ny, .. } = *self;
        let found = self.heights_m.len();
        if nx.checked_mul(ny) != Some(found) {
            return Err(PictureError::Impossible(format!(
                "a height field of {nx} x {ny} cells needs as many heights, but {found} were given"
            )));
        }
        let side = |cells: usize| u32::try_from(cells).unwrap_or(u32::MAX);
        Size::new(side(nx), side(ny)).map(drop)
    }

    /// Gives the height at the upper end of the colour scale.
    fn top_m(&self) -> f64 {
        let heights = self.heights_m.iter().copied();
        let finite = heights.filter(|height| height.is_finite());
        let highest = finite.fold(0.0, f64::max);
        sound_length(self.scale_top_m.unwrap_or(highest))
    }

    /// Draws the cells, squares of so many pixels.
    fn draw_cells(&self, image: &mut Image, cell: i64) {
        let top_m = self.top_m();
        for (x, column) in (0..).zip(self.heights_m.chunks_exact(self.ny)) {
            for (y, height_m) in (0..).zip(column) {
                let colour = if height_m.is_finite() {
                    Colour::of_share(height_m / top_m)
                } else {
                    Colour::FAINT
                };
                let row = self.ny as i64 - 1 - y;
                image.fill(LEFT + x * cell, TOP + row * cell, cell, cell, colour);
            }
        }
    }
}

/// Draws a height field with x to the right and y up.
///
/// # Errors
/// [`PictureError`] where the number of heights is not `nx * ny`, or the field is empty or too
/// large.
pub fn heightmap(title: &str, field: &HeightField<'_>) -> Result<Image, PictureError> {
    field.check()?;
    let (nx, ny) = (field.nx, field.ny);
    // Cells are squares of whole pixels: blurred cells would suggest heights that nobody measured.
    let cell = (MAP / nx.max(ny)).max(1) as i64;
    let (width, height) = (cell * nx as i64, cell * ny as i64);
    // Narrow fields still need room for the title, flat ones for the colour bar.
    let side = |pixels: i64| u32::try_from(pixels).unwrap_or(u32::MAX);
    let frame_width = side(LEFT + RIGHT + width.max(320));
    let frame_height = side(TOP + BOTTOM + height.max(200));
    let mut image = Image::filled(Size::new(frame_width, frame_height)?, Colour::WHITE);

    let top_m = field.top_m();
    image.fill(LEFT - 1, TOP - 1, width + 2, height + 2, Colour::LINE);
    field.draw_cells(&mut image, cell);

    let heading = TextStyle::new(22.0, Colour::INK).bold();
    let fitted = heading.fitted(title, f64::from(frame_width) - LEFT as f64 - 16.0);
    heading.draw(&mut image, &fitted, LEFT as f64 - 1.0, 38.0, Anchor::Start);
    let cell_cm = 100.0 * sound_length(field.cell_m);
    draw_x_axis(&mut image, width, height, cell_cm * nx as f64);
    draw_upright_axis(&mut image, LEFT, height, cell_cm * ny as f64, Side::Left);
    let above = TOP as f64 - 12.0;
    label(&mut image, "y (cm)", LEFT as f64 - 10.0, above, Anchor::End);

    let bar = LEFT + width + 36;
    let bar_height = height.max(160);
    image.fill(bar - 1, TOP - 1, 26, bar_height + 2, Colour::LINE);
    for row in 0..bar_height {
        let share = 1.0 - (row as f64 + 0.5) / bar_height as f64;
        image.fill(bar, TOP + row, 24, 1, Colour::of_share(share));
    }
    draw_upright_axis(&mut image, bar + 24, bar_height, 100.0 * top_m, Side::Right);
    label(&mut image, "height (cm)", bar as f64, above, Anchor::Start);
    Ok(image)
}

/// Gives a length in metres that an axis can span: a centimetre in place of one that makes no
/// sense.
fn sound_length(length_m: f64) -> f64 {
    if length_m > 1e-9 && length_m < 1e9 {
        length_m
    } else {
        0.01
    }
}

/// The side of its line on which an axis has its text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Left,
    Right,
}

/// Draws ticks below the map, from 0 to `end_cm`.
fn draw_x_axis(image: &mut Image, width: i64, height: i64, end_cm: f64) {
    let style = TextStyle::new(15.0, Colour::GREY);
    let y = TOP + height;
    for (value, text) in ticks(end_cm) {
        let x = LEFT as f64 + value / end_cm * width as f64;
        image.fill(x.round() as i64, y + 1, 1, 6, Colour::LINE);
        style.draw(image, &text, x, y as f64 + 24.0, Anchor::Middle);
    }
    let middle = LEFT as f64 + width as f64 / 2.0;
    label(image, "x (cm)", middle, y as f64 + 50.0, Anchor::Middle);
}

/// Draws ticks along an upright line at `x`, from 0 at its lower end to `end_cm`.
fn draw_upright_axis(image: &mut Image, x: i64, height: i64, end_cm: f64, side: Side) {
    let style = TextStyle::new(15.0, Colour::GREY);
    for (value, text) in ticks(end_cm) {
        let y = (TOP + height) as f64 - value / end_cm * height as f64;
        let (tick, place, anchor) = match side {
            Side::Left => (x - 7, x as f64 - 11.0, Anchor::End),
            Side::Right => (x + 1, x as f64 + 11.0, Anchor::Start),
        };
        image.fill(tick, y.round() as i64, 6, 1, Colour::LINE);
        let baseline = y + style.baseline_below_middle();
        style.draw(image, &text, place, baseline, anchor);
    }
}

fn label(image: &mut Image, text: &str, x: f64, y: f64, anchor: Anchor) {
    TextStyle::new(15.0, Colour::INK).draw(image, text, x, y, anchor);
}
