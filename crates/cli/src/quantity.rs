//! Times and sizes on the command line: a number with a unit.

use std::time::Duration;

use crate::length::split_unit;

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
///
/// # Errors
/// What is wrong with it, in words.
pub(crate) fn parse_time(text: &str) -> Result<Duration, String> {
    let time = humantime::parse_duration(text).map_err(|error| error.to_string())?;
    match time.is_zero() {
        true => Err(format!("'{text}' must be above 0")),
        false => Ok(time),
    }
}

/// Parses a size such as `500MB`, of at least 1 byte; gives bytes.
///
/// # Errors
/// What is wrong with it, in words.
pub(crate) fn parse_size(text: &str) -> Result<u64, String> {
    let (number, unit) = split_unit(text);
    let (_, factor) = SIZES
        .iter()
        .find(|(known, _)| *known == unit)
        .ok_or_else(|| {
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
    fn times_and_sizes_are_read_with_their_units() {
        assert_eq!(parse_time("10min"), Ok(Duration::from_secs(600)));
        assert_eq!(parse_size("500MB"), Ok(500_000_000));
        assert_eq!(parse_size("1GiB"), Ok(1 << 30));
        for text in ["0s", "-1h", "5", "5 parsecs", ""] {
            assert!(parse_time(text).is_err(), "{text}");
        }
        for text in ["0B", "12", "1e99GB", "1 GiB", "xMB"] {
            assert!(parse_size(text).is_err(), "{text}");
        }
    }
}
