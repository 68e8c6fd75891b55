//! Numbers in text.

/// A number as C writes it, which may give a NaN a sign.
pub(crate) fn number(word: &str) -> Option<f32> {
    let unsigned = word.strip_prefix(['-', '+']).unwrap_or(word);
    if unsigned.to_ascii_lowercase().starts_with("nan") {
        return Some(f32::NAN);
    }
    // As double first, so that a double means the same in text and in bytes.
    word.parse::<f64>().ok().map(|value| value as f32)
}
