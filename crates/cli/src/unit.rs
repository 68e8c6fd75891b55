//! Units on the command line.

/// A number and the letters of its unit, which may be none; neither is checked.
pub(crate) fn split_unit(text: &str) -> (&str, &str) {
    let text = text.trim();
    let number = text.trim_end_matches(|letter: char| letter.is_ascii_alphabetic());
    (number, text.get(number.len()..).unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_is_what_letters_there_are_at_the_end() {
        assert_eq!(split_unit(" 2.5mm "), ("2.5", "mm"));
        assert_eq!(split_unit("32x30cm"), ("32x30", "cm"));
        assert_eq!(split_unit("-1"), ("-1", ""));
        assert_eq!(split_unit("ms"), ("", "ms"));
        assert_eq!(split_unit(""), ("", ""));
    }
}
