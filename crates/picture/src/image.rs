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
    /// Maximum of pixels: a renderer needs some 30 bytes for each.
    pub const MAX_PIXELS: usize = 1 << 24;

    /// Makes a size of `width` x `height` pixels.
    ///
    /// # Errors
    /// [`PictureError`] where either is zero or the product exceeds [`Size::MAX_PIXELS`].
    pub fn new(width: u32, height: u32) -> Result<Self, PictureError> {
        let pixels = u64::from(width) * u64::from(height);
        if pixels == 0 || pixels > Self::MAX_PIXELS as u64 {
            let limit = Self::MAX_PIXELS;
            return Err(PictureError::Impossible(format!(
                "a picture of {width} x {height} pixels: it needs at least 1 and at most {limit} pixels"
            )));
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

/// An opaque sRGB picture, 8 bits a channel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    size: Size,
    pixels: Vec<Colour>,
}

impl Image {
    /// Makes a picture of one colour.
    pub fn filled(size: Size, colour: Colour) -> Self {
        Self {
            size,
            pixels: vec![colour; size.pixels()],
        }
    }

    /// Makes a picture from its pixels in rows from the top; missing ones are black.
    pub(crate) fn from_pixels(size: Size, pixels: impl Iterator<Item = Colour>) -> Self {
        let mut pixels: Vec<Colour> = pixels.collect();
        pixels.resize(size.pixels(), Colour::BLACK);
        Self { size, pixels }
    }

    /// Gives its size.
    pub fn size(&self) -> Size {
        self.size
    }

    /// Gives the pixels, in rows from the top.
    pub fn pixels(&self) -> &[Colour] {
        &self.pixels
    }

    /// Gives the colour of a pixel, or `None` outside the picture.
    pub fn colour(&self, x: u32, y: u32) -> Option<Colour> {
        let index = self.index(x.into(), y.into())?;
        self.pixels.get(index).copied()
    }

    /// Covers a pixel with `colour` to the share `coverage` (0 to 1); outside the picture nothing
    /// happens.
    pub(crate) fn blend(&mut self, x: i64, y: i64, colour: Colour, coverage: f32) {
        let coverage = coverage.clamp(0.0, 1.0);
        if let Some(pixel) = self.pixel(x, y) {
            *pixel = pixel.with(colour, |old, new| {
                (f32::from(old) + (f32::from(new) - f32::from(old)) * coverage).round() as u8
            });
        }
    }

    /// Fills the pixels of a rectangle, as far as it lies within the picture.
    pub(crate) fn fill(&mut self, x: i64, y: i64, width: i64, height: i64, colour: Colour) {
        for row in y.max(0)..y.saturating_add(height).min(self.size.height.into()) {
            for column in x.max(0)..x.saturating_add(width).min(self.size.width.into()) {
                if let Some(pixel) = self.pixel(column, row) {
                    *pixel = colour;
                }
            }
        }
    }

    /// Copies `other` with its top left corner at `(x, y)`, as far as it lies within this picture.
    pub(crate) fn paste(&mut self, x: i64, y: i64, other: &Image) {
        let rows = other.pixels.chunks_exact(other.size.width as usize);
        for (row, colours) in (y..).zip(rows) {
            for (column, colour) in (x..).zip(colours) {
                if let Some(pixel) = self.pixel(column, row) {
                    *pixel = *colour;
                }
            }
        }
    }

    /// Writes the picture as the bytes of a PNG file.
    pub fn to_png(&self) -> Result<Vec<u8>, PictureError> {
        let channels = |colour: &Colour| [colour.red, colour.green, colour.blue];
        let rgb: Vec<u8> = self.pixels.iter().flat_map(channels).collect();
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.size.width, self.size.height);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&rgb)?;
        writer.finish()?;
        Ok(bytes)
    }

    fn pixel(&mut self, x: i64, y: i64) -> Option<&mut Colour> {
        let index = self.index(x, y)?;
        self.pixels.get_mut(index)
    }

    /// Gives the index of a pixel; `None` outside the picture.
    fn index(&self, x: i64, y: i64) -> Option<usize> {
        let x = u32::try_from(x).ok().filter(|x| *x < self.size.width)?;
        let y = u32::try_from(y).ok().filter(|y| *y < self.size.height)?;
        Some(y as usize * self.size.width as usize + x as usize)
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
        image.fill(2, 1, 100, 2, Colour::hex(0x0a141e));
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
