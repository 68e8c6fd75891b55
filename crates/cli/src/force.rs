//! Forces on the command line: a number with a unit, newtons where none is given.

use crate::unit::split_unit;

/// Parses a force such as `20N` or `20`, of at least 0; gives newtons.
///
/// # Errors
/// What is wrong with it, in words.
pub(crate) fn parse_force(text: &str) -> Result<f64, String> {
    let (number, unit) = split_unit(text);
    if !matches!(unit, "" | "N") {
        return Err(format!("'{unit}' is no unit of force: use N"));
    }
    match number.parse::<f64>() {
        Ok(newtons) if newtons < 0.0 => Err(format!("'{text}' must not be negative")),
        Ok(newtons) if newtons.is_finite() => Ok(newtons),
        _ => Err(format!("'{text}' is no force: write it like 20N")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forces_are_read_in_newtons() {
        assert_eq!(parse_force("20N"), Ok(20.0));
        assert_eq!(parse_force(" 0.5 "), Ok(0.5));
        assert_eq!(parse_force("0"), Ok(0.0));
    }

    #[test]
    fn what_is_no_force_is_named() {
        for (text, named) in [
            ("5kg", "unit"),
            ("-5N", "negative"),
            ("N", "no force"),
            ("1e999", "no force"),
        ] {
            let refused = parse_force(text).unwrap_err();
            assert!(refused.contains(named), "{text}: {refused}");
        }
    }
}
