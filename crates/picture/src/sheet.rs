//! Contact sheets: many objects in one picture, with their names.

use nalgebra::Isometry3;

use crate::colour::Colour;
use crate::error::PictureError;
use crate::image::{Image, Size};
use crate::scene3d::{Camera, Item, Scene3d, TriangleMesh, render};
use crate::text::{Anchor, TextStyle};

/// Space around and between tiles, in pixels.
const GAP: u32 = 16;

/// Height of the title's line, in pixels.
const TITLE: u32 = 56;

/// One object of a contact sheet.
#[derive(Debug, Clone, Copy)]
pub struct Tile<'a> {
    /// Its shape, in metres; drawn as large as fits, z up.
    pub mesh: TriangleMesh<'a>,
    /// Its colour; see [`Colour::of_item`].
    pub colour: Colour,
    /// Its name, cut off where it is too long.
    pub name: &'a str,
    /// A line below the name, such as its size and volume.
    pub detail: &'a str,
}

/// Draws a sheet of tiles under a title, each `tile_px` pixels wide, in order, about 4 : 3 in all.
///
/// # Errors
/// [`PictureError`] where the sheet has too many pixels, `tile_px` is 0, or a mesh is oversized.
pub fn contact_sheet(title: &str, tiles: &[Tile<'_>], tile_px: u32) -> Result<Image, PictureError> {
    let picture = Size::new(tile_px, tile_px.saturating_mul(4) / 5)?;
    let name = TextStyle::new((f64::from(tile_px) * 0.062).max(9.0), Colour::INK).bold();
    let detail = TextStyle::new((f64::from(tile_px) * 0.052).max(8.0), Colour::GREY);
    let caption = (2.1 * name.size_px + 1.4 * detail.size_px) as u32;

    let columns = ((tiles.len() as f64 * 1.3).sqrt().ceil() as u32).max(1);
    let rows = (tiles.len() as u32).div_ceil(columns).max(1);
    let step_x = tile_px.saturating_add(GAP);
    let step_y = picture.height().saturating_add(caption + GAP);
    let size = Size::new(
        columns.saturating_mul(step_x).saturating_add(GAP),
        rows.saturating_mul(step_y).saturating_add(TITLE + GAP),
    )?;

    let mut sheet = Image::filled(size, Colour::WHITE);
    let heading = TextStyle::new(24.0, Colour::INK).bold();
    let fitted = heading.fitted(title, f64::from(size.width().saturating_sub(2 * GAP)));
    heading.draw(&mut sheet, &fitted, f64::from(GAP), 38.0, Anchor::Start);
    for (number, tile) in (0..).zip(tiles) {
        let x = GAP + number % columns * step_x;
        let y = TITLE + number / columns * step_y;
        sheet.paste(x.into(), y.into(), &portrait(tile, picture)?);
        let middle = f64::from(x) + f64::from(tile_px) / 2.0;
        let below = f64::from(y + picture.height());
        let first = 1.35 * name.size_px;
        let second = first + 1.4 * detail.size_px;
        let lines = [(name, tile.name, first), (detail, tile.detail, second)];
        for (style, text, offset) in lines {
            let text = style.fitted(text, tile_px.into());
            style.draw(&mut sheet, &text, middle, below + offset, Anchor::Middle);
        }
    }
    Ok(sheet)
}

/// Draws one object.
fn portrait(tile: &Tile<'_>, size: Size) -> Result<Image, PictureError> {
    let item = Item {
        mesh: tile.mesh,
        world_from_item: Isometry3::identity(),
        colour: tile.colour,
    };
    let scene = Scene3d {
        items: vec![item],
        container_m: None,
    };
    render(&scene, &Camera::overlooking(&scene), size)
}
