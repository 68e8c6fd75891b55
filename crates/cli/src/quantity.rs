//! Times, forces and sizes on the command line: a number with a unit.

use std::time::Duration;

use crate::unit::split_unit;

/// A kind of quantity.
struct Quantity {
    name: &'static str,
    /// Each with how much of the first it is; the first is what is given.
    units: &'static [(&'static str, f64)],
    /// For who wrote another unit.
    use_units: &'static str,
    example: &'static str,
}

const TIME: Quantity = Quantity {
    name: "time",
    units: &[("s", 1.0), ("ms", 0.001)],
    use_units: "ms or s",
    example: "20ms or 1s",
};

const AGE: Quantity = Quantity {
    name: "time",
    units: &[("s", 1.0), ("min", 60.0), ("h", 3_600.0), ("d", 86_400.0)],
    use_units: "s, min, h or d",
    example: "10min or 1h",
};

const SIZE: Quantity = Quantity {
    name: "size",
    units: &[
        ("B", 1.0),
        ("kB", 1e3),
        ("MB", 1e6),
        ("GB", 1e9),
        ("KiB", 1024.0),
        ("MiB", 1_048_576.0),
        ("GiB", 1_073_741_824.0),
    ],
    use_units: "B, kB, MB, GB, KiB, MiB or GiB",
    example: "500MB or 1GiB",
};

/// Parses a time such as `20ms` or `1s`, of at least 0; gives seconds.
///
/// # Errors
/// What is wrong with it, in words.
pub(crate) fn parse_time(text: &str) -> Result<f64, String> {
    TIME.parse(text)
}

/// Parses a longer time such as `10min`, above 0.
///
/// # Errors
/// What is wrong with it, in words.
pub(crate) fn parse_age(text: &str) -> Result<Duration, String> {
    let seconds = AGE.parse(text)?;
    let age = Duration::try_from_secs_f64(seconds).ok();
    age.filter(|age| !age.is_zero())
        .ok_or_else(|| format!("'{text}' is no time above 0 that can be waited for"))
}

/// Parses a size such as `500MB`, of at least 1 byte; gives bytes.
///
/// # Errors
/// What is wrong with it, in words.
pub(crate) fn parse_size(text: &str) -> Result<u64, String> {
    match SIZE.parse(text)? {
        bytes if (1.0..1e18).contains(&bytes) => Ok(bytes as u64),
        _ => Err(format!("'{text}' is no size from 1 B to 1,000,000,000 GB")),
    }
}

impl Quantity {
    fn parse(&self, text: &str) -> Result<f64, String> {
        let Self {
            name,
            use_units,
            example,
            ..
        } = self;
        let (number, unit) = split_unit(text);
        let mut units = self.units.iter();
        let known = units.find(|(known, _)| *known == unit);
        let unknown = || format!("'{unit}' is no unit of {name}: use {use_units}");
        let (_, factor) = known.ok_or_else(unknown)?;
        match number.parse::<f64>().map(|number| number * factor) {
            Ok(value) if value < 0.0 => Err(format!("'{text}' must not be negative")),
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(format!("'{text}' is no {name}: write it like {example}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_read_with_their_units() {
        assert_eq!(parse_time("250ms"), Ok(0.25));
        assert_eq!(parse_time(" 2s "), Ok(2.0));
        assert_eq!(parse_time("0s"), Ok(0.0));
    }

    #[test]
    fn ages_and_sizes_are_read_with_their_units() {
        assert_eq!(parse_age("10min"), Ok(Duration::from_secs(600)));
        assert_eq!(parse_age("0.5h"), Ok(Duration::from_secs(1_800)));
        assert_eq!(parse_size("500MB"), Ok(500_000_000));
        assert_eq!(parse_size("1 GiB").map_err(|_| ()), Err(()));
        assert_eq!(parse_size("1GiB"), Ok(1 << 30));
        for text in ["0s", "1ms", "-1h"] {
            assert!(parse_age(text).is_err(), "{text}");
        }
        for text in ["0B", "12", "1e99GB"] {
            assert!(parse_size(text).is_err(), "{text}");
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        let times = [
            ("5", "unit"),
            ("5min", "unit"),
            ("xms", "unit"),
            ("-5s", "negative"),
            ("1.2.3s", "no time"),
            ("1e999s", "no time"),
        ];
        for (text, named) in times {
            let refused = parse_time(text).unwrap_err();
            assert!(refused.contains(named), "{text}: {refused}");
        }
    }
}
