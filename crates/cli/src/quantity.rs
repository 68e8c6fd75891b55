//! Lengths, angles, times and sizes on the command line: a number with a unit; lengths without one are in
//! metres.

use std::time::Duration;

use ppnpack_packing::kernel::grid::ContainerSize;

/// Parses a positive length such as `1cm`, `2.5mm`, `0.01m` or `0.01`; gives metres.
pub fn parse_length(text: &str) -> Result<f64, String> {
    match parse_coordinate(text)? {
        metres if metres > 0.0 => Ok(metres),
        _ => Err(format!("'{text}' must be above 0")),
    }
}

/// Parses a length of at least 0; gives metres.
pub(crate) fn parse_distance(text: &str) -> Result<f64, String> {
    match parse_coordinate(text)? {
        metres if metres >= 0.0 => Ok(metres),
        _ => Err(format!("'{text}' must not be negative")),
    }
}

/// Minimum length, in metres, at which a side without a unit is taken for one in centimetres.
const LEAST_UNLIKELY_M: f64 = 10.0;

/// Parses the three inner lengths of a container, such as `32x32x30cm`.
pub(crate) fn parse_size(text: &str) -> Result<ContainerSize, String> {
    let (digits, unit) = split_unit(text);
    let sides = digits.split(['x', 'X']);
    let sides = sides.map(|side| parse_length(&format!("{side}{unit}")));
    match *sides.collect::<Result<Vec<f64>, _>>()? {
        [x_m, y_m, z_m] if unit.is_empty() && x_m.max(y_m).max(z_m) >= LEAST_UNLIKELY_M => Err(
            format!("'{text}' without a unit is in metres: did you mean {text}cm?"),
        ),
        [x_m, y_m, z_m] => Ok(ContainerSize::cuboid(x_m, y_m, z_m)),
        _ => Err(format!(
            "'{text}' must be three lengths with one unit, such as 32x32x30cm"
        )),
    }
}

/// Parses an angle such as `3deg` or `0.05rad`; gives radians.
pub(crate) fn parse_angle(text: &str) -> Result<f64, String> {
    let (number, unit) = split_unit(text);
    let number: Option<f64> = number.parse().ok();
    let angle = match unit {
        "deg" => number.map(f64::to_radians),
        "rad" => number,
        _ => None,
    };
    let none = || format!("'{text}' is no angle: write it like 3deg or 0.05rad");
    angle.filter(|angle| angle.is_finite()).ok_or_else(none)
}

/// Writes three lengths for people.
pub(crate) fn centimetres(lengths_m: [f64; 3]) -> String {
    let [x, y, z] = lengths_m.map(|length_m| 100.0 * length_m);
    format!("{x:.1} x {y:.1} x {z:.1} cm")
}

/// Parses a length of either sign; gives metres.
pub(crate) fn parse_coordinate(text: &str) -> Result<f64, String> {
    let (number, unit) = split_unit(text);
    let metres = match unit {
        "" | "m" => 1.0,
        "cm" => 0.01,
        "mm" => 0.001,
        "in" => 0.0254,
        _ => {
            return Err(format!(
                "'{unit}' is no unit of length: use m, cm, mm or in"
            ));
        }
    };
    let none = || format!("'{text}' is no length: write it like 1cm, 2.5mm or 0.01m");
    let number: f64 = number.parse().map_err(|_| none())?;
    // Rounding to a picometre keeps 0.1 mm steps exact: 0.2 cm is 0.002 m and not
    // 0.0020000000000000003 m.
    let metres = (number * metres * 1e12).round() / 1e12;
    let is_finite = metres.is_finite();
    is_finite
        .then_some(metres)
        .ok_or_else(|| format!("'{text}' is not finite"))
}

/// Splits a number from the letters of its unit, which may be none; neither is checked.
fn split_unit(text: &str) -> (&str, &str) {
    let text = text.trim();
    let number = text.trim_end_matches(|letter: char| letter.is_ascii_alphabetic());
    (number, text.get(number.len()..).unwrap_or_default())
}

/// The units of sizes, in bytes.
const SIZES: [(&str, f64); 7] = [
    ("B", 1.0),
    ("kB", 1e3),
    ("MB", 1e6),
    ("GB", 1e9),
    ("KiB", 1024.0),
    ("MiB", 1_048_576.0),
    ("GiB", 1_073_741_824.0),
];

/// Parses a time above 0, such as `10min` or `1h`.
pub(crate) fn parse_time(text: &str) -> Result<Duration, String> {
    let time = humantime::parse_duration(text).map_err(|error| error.to_string())?;
    match time.is_zero() {
        true => Err(format!("'{text}' must be above 0")),
        false => Ok(time),
    }
}

/// Parses a size such as `500MB`, of at least 1 byte; gives bytes.
pub(crate) fn parse_bytes(text: &str) -> Result<u64, String> {
    let (number, unit) = split_unit(text);
    let known = SIZES.iter().find(|(known, _)| *known == unit);
    let (_, factor) = known.ok_or_else(|| {
        let known = SIZES.map(|(name, _)| name).join(", ");
        format!("'{unit}' is no unit of size: one of {known} is needed, such as 1GiB")
    })?;
    match number.parse::<f64>().map(|number| number * factor) {
        Ok(bytes) if (1.0..1e18).contains(&bytes) => Ok(bytes as u64),
        _ => Err(format!("'{text}' is no size from 1 B to 1,000,000,000 GB")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_have_units() {
        assert_eq!(parse_length("2.5mm"), Ok(0.0025));
        assert_eq!(parse_length(" 1cm "), Ok(0.01));
        assert_eq!(parse_coordinate("-35cm"), Ok(-0.35));
        assert_eq!(parse_length("0.2cm"), Ok(0.002));
        assert_eq!(parse_length("0.3"), Ok(0.3));
        assert_eq!(parse_size("32x32x30cm"), Ok(ContainerSize::REFERENCE));
        let unitless = parse_size("0.3x0.3x0.16").unwrap();
        assert_eq!([unitless.x_m, unitless.y_m, unitless.z_m], [0.3, 0.3, 0.16]);
    }

    #[test]
    fn angles_have_units() {
        assert_eq!(parse_angle("3deg"), Ok(3.0_f64.to_radians()));
        assert_eq!(parse_angle("0.05rad"), Ok(0.05));
        for text in ["3", "deg", "nandeg", "3cm", ""] {
            assert!(parse_angle(text).is_err(), "{text}");
        }
    }

    #[test]
    fn wrong_lengths_are_refused() {
        for text in ["", "-1cm", "0", "1 furlong", "1km", "nan", "inf", "1e999"] {
            assert!(parse_length(text).is_err(), "{text}");
        }
        assert!(parse_size("32x32x30").unwrap_err().contains("32x32x30cm?"));
        for text in ["32x32cm", "32x32x-30cm", "32", "axbxc", "1x2x3x4"] {
            assert!(parse_size(text).is_err(), "{text}");
        }
    }

    #[test]
    fn times_and_sizes_are_read_with_their_units() {
        assert_eq!(parse_time("10min"), Ok(Duration::from_secs(600)));
        assert_eq!(parse_bytes("500MB"), Ok(500_000_000));
        assert_eq!(parse_bytes("1GiB"), Ok(1 << 30));
        for text in ["0s", "-1h", "5", "5 parsecs", ""] {
            assert!(parse_time(text).is_err(), "{text}");
        }
        for text in ["0B", "12", "1e99GB", "1 GiB", "xMB"] {
            assert!(parse_bytes(text).is_err(), "{text}");
        }
    }
}
