//! Axes: the range of values they span, and where their ticks go.

/// The most ticks an axis has.
const MOST_TICKS: usize = 40;

/// A range of values along a side of a chart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Axis {
    low: f64,
    high: f64,
    logarithmic: bool,
}

impl Axis {
    /// From `low` to `high` exactly.
    pub(crate) fn linear(low: f64, high: f64) -> Self {
        let high = if high > low { high } else { low + 1.0 };
        Self {
            low,
            high,
            logarithmic: false,
        }
    }

    /// Spans the values with some room around.
    pub(super) fn around(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = range(values).unwrap_or((0.0, 1.0));
        let room = (0.08 * (high - low)).max(1e-3 * high.abs()).max(1e-6);
        Self::linear(low - room, high + room)
    }

    /// Spans the values from zero upwards, with some room above.
    pub(super) fn from_zero(values: impl Iterator<Item = f64>) -> Self {
        let (_, high) = range(values).unwrap_or((0.0, 1.0));
        Self::linear(0.0, if high > 0.0 { 1.06 * high } else { 1.0 })
    }

    /// Spans positive values with some room around, on a logarithmic scale.
    pub(super) fn logarithmic(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = range(values.filter(|value| *value > 0.0)).unwrap_or((0.1, 10.0));
        let room = (high / low).powf(0.09).max(1.3);
        Self {
            low: low / room,
            high: high * room,
            logarithmic: true,
        }
    }

    /// How far along the axis a value is, from 0 to 1.
    pub(super) fn share(&self, value: f64) -> f64 {
        if self.logarithmic {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        }
    }

    /// Round values within the range, with their texts.
    pub(crate) fn ticks(&self) -> Vec<(f64, String)> {
        let decades = (self.high / self.low).log10();
        if self.logarithmic && decades > 0.7 {
            let mantissas: &[f64] = if decades <= 3.5 {
                &[1.0, 2.0, 5.0]
            } else {
                &[1.0]
            };
            let first = self.low.log10().floor() as i32;
            let last = self.high.log10().ceil() as i32;
            let stride = ((last - first) / 10 + 1).unsigned_abs() as usize;
            let ticks = (first..=last).step_by(stride).flat_map(|exponent| {
                mantissas
                    .iter()
                    .map(move |mantissa| (mantissa * 10f64.powi(exponent), exponent))
            });
            let within = ticks.filter(|(value, _)| *value >= self.low && *value <= self.high);
            within
                .take(MOST_TICKS)
                .map(|(value, exponent)| (value, number(value, (-exponent).max(0) as usize)))
                .collect()
        } else {
            let rough = (self.high - self.low) / 6.0;
            let decade = 10f64.powf(rough.log10().floor());
            let step = [1.0, 2.0, 5.0, 10.0]
                .map(|mantissa| mantissa * decade)
                .into_iter()
                .find(|step| *step >= rough * 0.999)
                .unwrap_or(rough);
            let decimals = (-step.log10().floor()).clamp(0.0, 9.0) as usize;
            let first = (self.low / step - 1e-9).ceil();
            (0..MOST_TICKS)
                .map(|index| (first + index as f64) * step)
                .take_while(|value| *value <= self.high + 1e-9 * step)
                .map(|value| (value, number(value, decimals)))
                .collect()
        }
    }
}

/// The least and the greatest of the finite values.
fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values
        .filter(|value| super::drawable(*value))
        .fold(None, |range, value| match range {
            Some((low, high)) => Some((value.min(low), value.max(high))),
            None => Some((value, value)),
        })
}

/// A number with commas between thousands.
fn number(value: f64, decimals: usize) -> String {
    // Adding zero turns a negative zero positive.
    let text = format!("{:.decimals$}", value + 0.0);
    let digits = text.find('.').unwrap_or(text.len());
    let mut grouped = String::with_capacity(text.len() + 4);
    for (index, letter) in text.chars().enumerate() {
        let before_point = digits.saturating_sub(index);
        if index > 0 && before_point > 0 && before_point % 3 == 0 && !grouped.ends_with('-') {
            grouped.push(',');
        }
        grouped.push(letter);
    }
    grouped
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(axis: Axis) -> Vec<String> {
        axis.ticks().into_iter().map(|(_, text)| text).collect()
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(
            texts(Axis::linear(0.0, 30.0)),
            ["0", "5", "10", "15", "20", "25", "30"]
        );
        assert_eq!(
            texts(Axis::linear(39.1, 41.2)),
            ["39.5", "40.0", "40.5", "41.0"]
        );
        assert_eq!(
            texts(Axis::linear(-1.0, 12_000.0)).last().unwrap(),
            "12,000"
        );
        let decades = Axis {
            low: 0.4,
            high: 25.0,
            logarithmic: true,
        };
        assert_eq!(texts(decades), ["0.5", "1", "2", "5", "10", "20"]);
    }

    #[test]
    fn thousands_are_grouped() {
        assert_eq!(number(1_234_567.0, 0), "1,234,567");
        assert_eq!(number(-123.456, 2), "-123.46");
        assert_eq!(number(-0.0, 1), "0.0");
    }

    #[test]
    fn senseless_values_give_a_sound_axis() {
        let odd = [f64::NAN, f64::INFINITY, -3.0, 0.0];
        for axis in [
            Axis::around(odd.into_iter()),
            Axis::from_zero(odd.into_iter()),
            Axis::logarithmic(odd.into_iter()),
            Axis::around([7.0].into_iter()),
            Axis::logarithmic([7.0].into_iter()),
            Axis::logarithmic([1e-9, 1e9].into_iter()),
        ] {
            assert!(axis.low < axis.high, "{axis:?}");
            let ticks = axis.ticks();
            assert!(
                !ticks.is_empty() && ticks.len() <= MOST_TICKS,
                "{axis:?}: {ticks:?}"
            );
        }
    }
}
