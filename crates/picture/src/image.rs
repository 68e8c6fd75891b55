//! The pixel buffer that all raster pictures are drawn into.

use crate::colour::Colour;
use crate::error::PictureError;

/// The size of a picture in pixels: neither empty nor too large to allocate safely.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    width: u32,
    height: u32,
}

impl Size {
    /// The greatest number of pixels: a renderer needs some 30 bytes for each.
    pub const MAX_PIXELS: usize = 1 << 24;

    /// A size of `width` x `height` pixels.
    ///
    /// # Errors
    /// [`PictureError::Size`] where either is zero or the product exceeds [`Size::MAX_PIXELS`].
    pub fn new(width: u32, height: u32) -> Result<Self, PictureError> {
        let pixels = u64::from(width) * u64::from(height);
        if pixels == 0 || pixels > Self::MAX_PIXELS as u64 {
            return Err(PictureError::Size {
                width,
                height,
                limit: Self::MAX_PIXELS,
            });
        }
        Ok(Self { width, height })
    }

    /// Width in pixels.
    pub fn width(self) -> u32 {
        self.width
    }

    /// Height in pixels.
    pub fn height(self) -> u32 {
        self.height
    }

    /// How many pixels there are.
    pub(crate) fn pixels(self) -> usize {
        self.width as usize * self.height as usize
    }
}

/// An RGBA picture, 8 bits a channel, sRGB, rows from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    size: Size,
    rgba: Vec<u8>,
}

impl Image {
    /// A picture filled with one opaque colour.
    pub fn filled(size: Size, colour: Colour) -> Self {
        let pixel = [colour.red, colour.green, colour.blue, u8::MAX];
        Self {
            size,
            rgba: pixel.repeat(size.pixels()),
        }
    }

    /// An opaque picture from its pixels in rows from the top; missing ones are black.
    pub(crate) fn from_pixels(size: Size, pixels: impl Iterator<Item = Colour>) -> Self {
        let mut image = Self::filled(size, Colour::BLACK);
        for (slot, colour) in image.rgba.chunks_exact_mut(4).zip(pixels) {
            slot.copy_from_slice(&[colour.red, colour.green, colour.blue, u8::MAX]);
        }
        image
    }

    /// The picture's size.
    pub fn size(&self) -> Size {
        self.size
    }

    /// The pixels: red, green, blue, alpha, in rows from the top.
    pub fn rgba(&self) -> &[u8] {
        &self.rgba
    }

    /// The colour of a pixel, or `None` outside the picture.
    pub fn colour(&self, x: u32, y: u32) -> Option<Colour> {
        let start = self.offset(i64::from(x), i64::from(y))?;
        match self.rgba.get(start..start + 3) {
            Some(&[red, green, blue]) => Some(Colour { red, green, blue }),
            _ => None,
        }
    }

    /// Covers a pixel with `colour` to the share `coverage` (0 to 1); outside the picture nothing happens.
    pub(crate) fn blend(&mut self, x: i64, y: i64, colour: Colour, coverage: f32) {
        let Some(start) = self.offset(x, y) else {
            return;
        };
        let Some(pixel) = self.rgba.get_mut(start..start + 3) else {
            return;
        };
        let coverage = coverage.clamp(0.0, 1.0);
        for (old, new) in pixel
            .iter_mut()
            .zip([colour.red, colour.green, colour.blue])
        {
            let mixed = f32::from(*old) + (f32::from(new) - f32::from(*old)) * coverage;
            *old = mixed.round() as u8;
        }
    }

    /// Fills the pixels of a rectangle, as far as it lies within the picture.
    pub(crate) fn fill(&mut self, x: i64, y: i64, width: i64, height: i64, colour: Colour) {
        for row in y.max(0)..y.saturating_add(height).min(i64::from(self.size.height)) {
            for column in x.max(0)..x.saturating_add(width).min(i64::from(self.size.width)) {
                self.blend(column, row, colour, 1.0);
            }
        }
    }

    /// Copies `other` with its top left corner at `(x, y)`, as far as it lies within this picture.
    pub(crate) fn paste(&mut self, x: i64, y: i64, other: &Image) {
        let width = other.size.width as usize * 4;
        for (row, pixels) in (y..).zip(other.rgba.chunks_exact(width)) {
            for (column, pixel) in (x..).zip(pixels.chunks_exact(4)) {
                if let Some(start) = self.offset(column, row)
                    && let Some(slot) = self.rgba.get_mut(start..start + 4)
                {
                    slot.copy_from_slice(pixel);
                }
            }
        }
    }

    /// The picture as the bytes of a PNG file.
    ///
    /// # Errors
    /// [`PictureError::Png`] where the encoder fails.
    pub fn to_png(&self) -> Result<Vec<u8>, PictureError> {
        // Every picture here is opaque: a file without the alpha channel is a quarter smaller.
        let opaque = self
            .rgba
            .chunks_exact(4)
            .all(|pixel| pixel.last() == Some(&u8::MAX));
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.size.width, self.size.height);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_color(if opaque {
            png::ColorType::Rgb
        } else {
            png::ColorType::Rgba
        });
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header()?;
        if opaque {
            let rgb: Vec<u8> = self
                .rgba
                .chunks_exact(4)
                .flat_map(|pixel| pixel.iter().take(3))
                .copied()
                .collect();
            writer.write_image_data(&rgb)?;
        } else {
            writer.write_image_data(&self.rgba)?;
        }
        writer.finish()?;
        Ok(bytes)
    }

    /// Where a pixel's bytes start.
    fn offset(&self, x: i64, y: i64) -> Option<usize> {
        let x = u32::try_from(x).ok().filter(|x| *x < self.size.width)?;
        let y = u32::try_from(y).ok().filter(|y| *y < self.size.height)?;
        Some((y as usize * self.size.width as usize + x as usize) * 4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_sizes_it_cannot_hold() {
        assert!(Size::new(0, 10).is_err());
        assert!(Size::new(10, 0).is_err());
        assert!(Size::new(u32::MAX, u32::MAX).is_err());
        assert!(Size::new(1600, 1200).is_ok());
    }

    #[test]
    fn png_holds_the_pixels() {
        let mut image = Image::filled(Size::new(7, 5).unwrap(), Colour::WHITE);
        image.fill(
            2,
            1,
            100,
            2,
            Colour {
                red: 10,
                green: 20,
                blue: 30,
            },
        );
        let bytes = image.to_png().unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes.as_slice()))
            .read_info()
            .unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!(
            (info.width, info.height, info.color_type),
            (7, 5, png::ColorType::Rgb)
        );
        assert_eq!(pixels[(7 + 2) * 3..][..3], [10, 20, 30]);
        assert_eq!(pixels[..3], [255, 255, 255]);
    }

    #[test]
    fn drawing_outside_is_ignored() {
        let mut image = Image::filled(Size::new(3, 3).unwrap(), Colour::WHITE);
        let other = Image::filled(Size::new(2, 2).unwrap(), Colour::BLACK);
        image.paste(-1, -1, &other);
        image.paste(9, 9, &other);
        image.blend(-5, 100, Colour::BLACK, 1.0);
        assert_eq!(image.colour(0, 0), Some(Colour::BLACK));
        assert_eq!(image.colour(1, 0), Some(Colour::WHITE));
        assert_eq!(image.colour(3, 0), None);
    }
}
