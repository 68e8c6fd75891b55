//! Times on the command line: a number with a unit.

use crate::unit::split_unit;

/// Parses a time such as `20ms` or `1s`, of at least 0; gives seconds.
///
/// # Errors
/// What is wrong with it, in words.
pub(crate) fn parse_time(text: &str) -> Result<f64, String> {
    let (number, unit) = split_unit(text);
    let seconds = match unit {
        "ms" => 0.001,
        "s" => 1.0,
        unit => return Err(format!("'{unit}' is no unit of time: use ms or s")),
    };
    let number: Result<f64, _> = number.parse();
    match number.map(|number| number * seconds) {
        Ok(seconds) if seconds < 0.0 => Err(format!("'{text}' must not be negative")),
        Ok(seconds) if seconds.is_finite() => Ok(seconds),
        _ => Err(format!("'{text}' is no time: write it like 20ms or 1s")),
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
    fn what_is_no_time_is_named() {
        for (text, named) in [
            ("5", "unit"),
            ("5min", "unit"),
            ("xms", "unit"),
            ("-5s", "negative"),
            ("1.2.3s", "no time"),
            ("1e999s", "no time"),
        ] {
            let refused = parse_time(text).unwrap_err();
            assert!(refused.contains(named), "{text}: {refused}");
        }
    }
}
