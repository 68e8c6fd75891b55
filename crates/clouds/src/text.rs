//! Words, numbers and points in text of any encoding.

use nalgebra::Point3;

/// Reads a number as C writes it, such as `.5` and `-nan(ind)`.
pub fn number(word: &[u8]) -> Option<f64> {
    let unsigned = word.strip_prefix(b"-").unwrap_or(word);
    let unsigned = unsigned.strip_prefix(b"+").unwrap_or(unsigned);
    if unsigned.to_ascii_lowercase().starts_with(b"nan") || word.contains(&b'#') {
        return Some(f64::NAN);
    }
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// Gives the words of a line.
pub fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty())
}

/// Quotes the beginning of a line in a reason.
pub fn quoted(line: &[u8]) -> String {
    String::from_utf8_lossy(line.get(..100).unwrap_or(line)).into_owned()
}

/// Reads `count` points, one a line; says which line is none, or that there are fewer. Empty lines
/// are passed over. `one` and `all` are the file's words for a point and for points.
pub(crate) fn points(
    text: &[u8],
    count: usize,
    [one, all]: [&str; 2],
    point: impl Fn(&[u8]) -> Option<Point3<f32>>,
) -> Result<Vec<Point3<f32>>, String> {
    let mut points_m = Vec::with_capacity(count);
    let lines = text.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii);
    for line in lines.filter(|line| !line.is_empty()).take(count) {
        points_m.push(point(line).ok_or_else(|| format!("'{}' is no {one}", quoted(line)))?);
    }
    match points_m.len() {
        found if found < count => Err(format!("it ends after {found} of {count} {all}")),
        _ => Ok(points_m),
    }
}
