//! What the axes span.

use std::ops::Range;

/// Values that a chart can show: neither infinite, nor so large that differences vanish.
pub(crate) fn drawable(value: f64) -> bool {
    value.abs() < 1e12
}

/// From the least to the greatest drawable value.
fn spanned(values: impl Iterator<Item = f64>) -> Option<Range<f64>> {
    let ends = values.filter(|value| drawable(*value));
    ends.map(|value| value..value)
        .reduce(|one, other| one.start.min(other.start)..one.end.max(other.end))
}

/// From the least to the greatest drawable value, and at least 1 wide where these are one.
pub(crate) fn exact(values: impl Iterator<Item = f64>) -> Option<Range<f64>> {
    let Range { start, end } = spanned(values)?;
    Some(start..if end > start { end } else { start + 1.0 })
}

/// Spans the values with some room around.
pub(crate) fn around(values: impl Iterator<Item = f64>) -> Range<f64> {
    let Some(Range { start, end }) = spanned(values) else {
        return 0.0..1.0;
    };
    let room = (0.08 * (end - start)).max(1e-3 * end.abs()).max(1e-6);
    start - room..end + room
}

/// Spans the values from zero upwards, with some room above.
pub(crate) fn from_zero(values: impl Iterator<Item = f64>) -> Range<f64> {
    let highest = values.filter(|value| drawable(*value)).fold(0.0, f64::max);
    0.0..if highest > 0.0 { 1.06 * highest } else { 1.0 }
}

/// Spans positive values by a factor more on either side.
pub(crate) fn around_logarithmic(values: impl Iterator<Item = f64>) -> Range<f64> {
    let positive = values.filter(|value| *value > 0.0);
    let Range { start, end } = spanned(positive).unwrap_or(0.1..10.0);
    let room = (end / start).powf(0.09).max(1.5);
    start / room..end * room
}

/// Round values on a logarithmic scale: the library offers powers of ten alone.
pub(crate) fn logarithmic_ticks(range: &Range<f64>) -> Vec<f64> {
    let decades = (range.end / range.start).log10();
    let factors = match decades {
        ..0.7 => &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0][..],
        ..3.5 => &[1.0, 2.0, 5.0],
        _ => &[1.0],
    };
    let stride = (decades / 10.0).ceil().max(1.0) as usize;
    let exponents =
        (range.start.log10().floor() as i32..=range.end.log10().ceil() as i32).step_by(stride);
    let ticks = exponents.flat_map(|exponent| {
        factors
            .iter()
            .map(move |factor| factor * 10f64.powi(exponent))
    });
    ticks.filter(|tick| range.contains(tick)).collect()
}

/// A tick's text: no more digits than it has, but for errors of rounding.
pub(crate) fn tick(value: &f64) -> String {
    let rounded: f64 = format!("{value:.6e}").parse().unwrap_or(*value);
    // Ticks next to zero are zero but for errors of rounding.
    if rounded.abs() < 1e-9 {
        "0".to_owned()
    } else {
        rounded.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn senseless_values_give_a_sound_range() {
        let odd = [f64::NAN, f64::INFINITY, -3.0, 0.0];
        for range in [
            around(odd.into_iter()),
            from_zero(odd.into_iter()),
            around_logarithmic(odd.into_iter()),
            around([7.0].into_iter()),
            exact([7.0].into_iter()).unwrap(),
        ] {
            assert!(range.start < range.end, "{range:?}");
        }
        assert_eq!(exact([f64::NAN].into_iter()), None);
    }

    #[test]
    fn logarithmic_ticks_are_round_and_few() {
        assert_eq!(
            logarithmic_ticks(&(0.4..25.0)),
            [0.5, 1.0, 2.0, 5.0, 10.0, 20.0]
        );
        for values in [&[7.0][..], &[1e-9, 1e9], &[1.01], &[]] {
            let ticks = logarithmic_ticks(&around_logarithmic(values.iter().copied()));
            assert!((1..=25).contains(&ticks.len()), "{values:?}: {ticks:?}");
        }
        assert_eq!(tick(&(0.1 + 0.2)), "0.3");
        assert_eq!(tick(&-1e-17), "0");
    }
}
