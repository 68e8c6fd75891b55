//! Points in text, one a line.

use nalgebra::Point3;

/// Reads `count` points; says which line is none, or that there are fewer. Empty lines are passed
/// over. `one` and `all` are the file's words for a point and for points.
pub(crate) fn points(
    text: &[u8],
    count: usize,
    [one, all]: [&str; 2],
    point: impl Fn(&str) -> Option<Point3<f32>>,
) -> Result<Vec<Point3<f32>>, String> {
    let mut points_m = Vec::with_capacity(count);
    let lines = text.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii);
    for line in lines.filter(|line| !line.is_empty()).take(count) {
        let read = std::str::from_utf8(line).ok().and_then(&point);
        points_m.push(read.ok_or_else(|| {
            let line = String::from_utf8_lossy(line.get(..100).unwrap_or(line));
            format!("'{line}' is no {one}")
        })?);
    }
    match points_m.len() {
        found if found < count => Err(format!("it ends after {found} of {count} {all}")),
        _ => Ok(points_m),
    }
}

/// Reads a number as C writes it, which may give a NaN a sign.
pub(crate) fn number(word: &str) -> Option<f32> {
    let unsigned = word.strip_prefix(['-', '+']).unwrap_or(word);
    if unsigned.to_ascii_lowercase().starts_with("nan") {
        return Some(f32::NAN);
    }
    // As double first, so that a double means the same in text and in bytes.
    word.parse::<f64>().ok().map(|value| value as f32)
}
