//! Colours: the item palette and the colour map of heights.

use nalgebra::Vector3;

/// An opaque sRGB colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Colour {
    /// Red, 0 to 255.
    pub red: u8,
    /// Green, 0 to 255.
    pub green: u8,
    /// Blue, 0 to 255.
    pub blue: u8,
}

/// Knots of the viridis colour map at equal distances.
const VIRIDIS: [Colour; 9] = [
    Colour::hex(0x440154),
    Colour::hex(0x472d7b),
    Colour::hex(0x3b528b),
    Colour::hex(0x2c728e),
    Colour::hex(0x21918c),
    Colour::hex(0x28ae80),
    Colour::hex(0x5ec962),
    Colour::hex(0xaddc30),
    Colour::hex(0xfde725),
];

impl Colour {
    pub(crate) const BLACK: Self = Self::hex(0x000000);
    pub(crate) const WHITE: Self = Self::hex(0xffffff);
    /// Titles and names.
    pub(crate) const INK: Self = Self::hex(0x1f2933);
    /// Secondary text.
    pub const GREY: Self = Self::hex(0x616e7c);
    /// Axes and frames.
    pub(crate) const LINE: Self = Self::hex(0x9aa5b1);
    /// Grid lines.
    pub(crate) const FAINT: Self = Self::hex(0xe4e7eb);

    /// Makes a colour from `0xrrggbb`.
    pub(crate) const fn hex(rgb: u32) -> Self {
        Self {
            red: (rgb >> 16) as u8,
            green: (rgb >> 8) as u8,
            blue: rgb as u8,
        }
    }

    /// Gives the colour of the item with this index or catalogue number: always the same one.
    ///
    /// Hues advance by the golden angle in `OKLCh`: items of neighbouring numbers differ clearly,
    /// and any number of items spread evenly. Lightness alternates to keep similar hues apart.
    pub fn of_item(index: usize) -> Self {
        const GOLDEN_ANGLE_DEG: f64 = 137.507_764;
        const LIGHTNESS: [f64; 3] = [0.70, 0.78, 0.62];
        let lightness = LIGHTNESS.get(index % 3).copied().unwrap_or(0.72);
        let hue_deg = (250.0 + (index % 3_600) as f64 * GOLDEN_ANGLE_DEG) % 360.0;
        Self::from_oklch(lightness, 0.115, hue_deg.to_radians())
    }

    /// Gives the colour of a height on a perceptually even map: `share` 0 is dark violet, 1 is
    /// yellow.
    pub fn of_share(share: f64) -> Self {
        let last = VIRIDIS.len() - 1;
        // It is 0 where it is no number.
        let position = share.max(0.0).clamp(0.0, 1.0) * last as f64;
        let knot = (position as usize).min(last - 1);
        match VIRIDIS.get(knot..knot + 2) {
            Some(&[low, high]) => low.mixed(high, position - knot as f64),
            _ => Self::BLACK,
        }
    }

    /// Mixes this colour (`share` 0) and another (1), channel by channel.
    pub(crate) fn mixed(self, other: Self, share: f64) -> Self {
        self.with(other, |from, to| {
            (f64::from(from) + (f64::from(to) - f64::from(from)) * share).round() as u8
        })
    }

    /// Makes each channel from both colours' channels.
    pub(crate) fn with(self, other: Self, channel: impl Fn(u8, u8) -> u8) -> Self {
        Self {
            red: channel(self.red, other.red),
            green: channel(self.green, other.green),
            blue: channel(self.blue, other.blue),
        }
    }

    /// Makes a colour from the bytes of its channels.
    pub(crate) fn from_channels(channels: Vector3<u8>) -> Self {
        Self {
            red: channels.x,
            green: channels.y,
            blue: channels.z,
        }
    }

    /// Gives the nearest sRGB colour to an `OKLCh` one; `hue` in radians. Chroma shrinks until the
    /// colour can be displayed.
    fn from_oklch(lightness: f64, chroma: f64, hue: f64) -> Self {
        let linear = (0..=16)
            .map(|step| oklab_to_linear(lightness, chroma * (1.0 - f64::from(step) / 16.0), hue))
            .find(|rgb| rgb.iter().all(|channel| (0.0..=1.0).contains(channel)))
            .unwrap_or_else(|| Vector3::repeat(0.5));
        Self::from_channels(linear.map(srgb_byte))
    }
}

/// Gives an sRGB channel from linear light, 0 to 1.
fn srgb_byte(linear: f64) -> u8 {
    let value = if linear <= 0.003_130_8 {
        linear * 12.92
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    };
    (value * 255.0).round() as u8
}

/// Gives linear sRGB from `OKLab` in polar form (Ottosson 2020).
fn oklab_to_linear(lightness: f64, chroma: f64, hue: f64) -> Vector3<f64> {
    let (b, a) = hue.sin_cos();
    let (a, b) = (a * chroma, b * chroma);
    let l = (lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let m = (lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let s = (lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b).powi(3);
    Vector3::new(
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn item_colours_are_stable_and_distinct() {
        let colours: Vec<Colour> = (0..40).map(Colour::of_item).collect();
        for (index, colour) in colours.iter().enumerate() {
            assert_eq!(*colour, Colour::of_item(index));
            assert!(
                !colours[..index].contains(colour),
                "item {index} repeats a colour"
            );
        }
    }

    #[test]
    fn heights_run_from_dark_to_light() {
        let luminance = |share| {
            let Colour { red, green, blue } = Colour::of_share(share);
            Vector3::new(red, green, blue)
                .map(f64::from)
                .dot(&Vector3::new(0.2, 0.7, 0.1))
        };
        let steps: Vec<f64> = (0..=20)
            .map(|step| luminance(f64::from(step) / 20.0))
            .collect();
        assert!(steps.windows(2).all(|pair| pair[0] < pair[1]), "{steps:?}");
        assert_eq!(Colour::of_share(f64::NAN), Colour::of_share(0.0));
    }
}
