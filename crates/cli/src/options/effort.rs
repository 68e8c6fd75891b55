//! Efforts on the command line: a time with a unit.

use ppnpack_packing::effort::Effort;

/// Parses an effort such as `20ms` or `1s`.
///
/// # Errors
/// What is wrong with it, in words.
pub(crate) fn parse_effort(text: &str) -> Result<Effort, String> {
    let text = text.trim();
    let number = text.trim_end_matches(|letter: char| letter.is_ascii_alphabetic());
    let seconds = match text.get(number.len()..).unwrap_or("") {
        "ms" => 0.001,
        "s" => 1.0,
        unit => return Err(format!("'{unit}' is no unit of time: use ms or s")),
    };
    let number: f64 = number
        .parse()
        .map_err(|_| format!("'{text}' is no time: write it like 20ms or 1s"))?;
    Effort::new(number * seconds).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn efforts_are_read_with_their_units() {
        assert_eq!(parse_effort("250ms").unwrap().step_s(), 0.25);
        assert_eq!(parse_effort("2s").unwrap().step_s(), 2.0);
    }

    #[test]
    fn what_is_no_effort_is_named() {
        for (text, named) in [
            ("5", "unit"),
            ("5min", "unit"),
            ("xms", "unit"),
            ("0ms", "from 1 ms"),
            ("-5s", "from 1 ms"),
            ("1.2.3s", "no time"),
        ] {
            let refused = parse_effort(text).unwrap_err();
            assert!(refused.contains(named), "{text}: {refused}");
        }
    }
}
