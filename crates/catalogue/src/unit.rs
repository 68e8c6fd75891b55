//! Units of length in which mesh files are drawn.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// The unit of a mesh file's coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LengthUnit {
    /// Metres, which the program computes in.
    #[default]
    #[serde(alias = "m")]
    Metres,
    /// Centimetres.
    #[serde(alias = "cm")]
    Centimetres,
    /// Millimetres, the habit of CAD programs and of STL files.
    #[serde(alias = "mm")]
    Millimetres,
    /// Inches of 25.4 mm.
    #[serde(alias = "in")]
    Inches,
}

impl LengthUnit {
    /// All units, the largest first.
    pub const ALL: [Self; 4] = [
        Self::Metres,
        Self::Inches,
        Self::Centimetres,
        Self::Millimetres,
    ];

    /// How many metres one unit is.
    pub fn metres(self) -> f64 {
        match self {
            Self::Metres => 1.0,
            Self::Centimetres => 0.01,
            Self::Millimetres => 0.001,
            Self::Inches => 0.0254,
        }
    }
}

/// The abbreviation that `objects.csv` uses.
impl fmt::Display for LengthUnit {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Metres => "m",
            Self::Centimetres => "cm",
            Self::Millimetres => "mm",
            Self::Inches => "in",
        })
    }
}

impl FromStr for LengthUnit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text.trim().to_ascii_lowercase().as_str() {
            "m" | "metre" | "metres" | "meter" | "meters" => Ok(Self::Metres),
            "cm" | "centimetre" | "centimetres" | "centimeter" | "centimeters" => {
                Ok(Self::Centimetres)
            }
            "mm" | "millimetre" | "millimetres" | "millimeter" | "millimeters" => {
                Ok(Self::Millimetres)
            }
            "in" | "inch" | "inches" => Ok(Self::Inches),
            _ => Err(format!(
                "'{}' is no unit of length: write m, cm, mm or in",
                text.trim()
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn abbreviations_read_back() {
        for unit in LengthUnit::ALL {
            assert_eq!(unit.to_string().parse(), Ok(unit));
        }
        assert_eq!(" Millimeters ".parse(), Ok(LengthUnit::Millimetres));
        assert!("furlong".parse::<LengthUnit>().is_err());
    }
}
