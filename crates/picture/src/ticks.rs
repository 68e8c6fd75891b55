//! Round values along an axis.

/// Maximum of ticks of an axis.
const MOST_TICKS: usize = 40;

/// Gives round values from zero to `end`, about six of them, with their texts.
pub(crate) fn ticks(end: f64) -> Vec<(f64, String)> {
    let rough = end / 6.0;
    let decade = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .map(|mantissa| mantissa * decade)
        .into_iter()
        .find(|step| *step >= rough * 0.999)
        .unwrap_or(rough);
    let decimals = (-step.log10().floor()).clamp(0.0, 9.0) as usize;
    (0..MOST_TICKS)
        .map(|index| index as f64 * step)
        .take_while(|value| *value <= end + 1e-9 * step)
        .map(|value| (value, format!("{value:.decimals$}")))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round() {
        let texts = |end| {
            let ticks = ticks(end).into_iter();
            ticks.map(|(_, text)| text).collect::<Vec<_>>()
        };
        assert_eq!(texts(30.0), ["0", "5", "10", "15", "20", "25", "30"]);
        assert_eq!(texts(1.1), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(texts(12_000.0).last().unwrap(), "12000");
    }
}
