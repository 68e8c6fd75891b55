//! What volume of items a container comes to hold: not known before it is full, but estimated, with its spread.

/// From how many full containers an estimate is learned.
pub const LEAST_LEARNED: usize = 5;

/// How far a learned spread is from none at least, as a share of the mean: containers that came out alike by chance promise nothing.
const LEAST_SPREAD: f64 = 0.02;

/// What a container comes to hold, taken as normally distributed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Capacity {
    /// The mean, in cubic metres.
    pub mean_m3: f64,
    /// The standard deviation, in cubic metres; with 0 it holds the mean exactly.
    pub spread_m3: f64,
}

impl Capacity {
    /// Learned from what containers held into which nothing went any more, in cubic metres; `None` where these are too few.
    pub fn learned(held_m3: &[f64]) -> Option<Self> {
        if held_m3.len() < LEAST_LEARNED {
            return None;
        }
        let count = held_m3.len() as f64;
        let mean_m3 = held_m3.iter().sum::<f64>() / count;
        let squares: f64 = held_m3.iter().map(|held| (held - mean_m3).powi(2)).sum();
        let spread_m3 = (squares / (count - 1.0)).sqrt();
        Some(Self {
            mean_m3,
            spread_m3: spread_m3.max(LEAST_SPREAD * mean_m3),
        })
    }

    /// The probability that a container that holds so much takes so much more: of those that come to hold what it holds already, the
    /// share that comes to hold that, too.
    pub fn certainty(&self, held_m3: f64, further_m3: f64) -> f64 {
        if further_m3 <= 0.0 {
            return 1.0;
        }
        if self.spread_m3 <= 0.0 {
            return match held_m3 + further_m3 <= self.mean_m3 {
                true => 1.0,
                false => 0.0,
            };
        }
        let ln_holds = |volume_m3: f64| ln_survival((volume_m3 - self.mean_m3) / self.spread_m3);
        let certainty = (ln_holds(held_m3 + further_m3) - ln_holds(held_m3)).exp();
        certainty.clamp(0.0, 1.0)
    }
}

/// The logarithm of the probability that a standard normal variable is greater.
fn ln_survival(deviations: f64) -> f64 {
    let z = deviations / std::f64::consts::SQRT_2;
    ln_complement(z) - std::f64::consts::LN_2
}

/// From here on the complementary error function is near the smallest numbers that there are.
const FAR: f64 = 25.0;

/// The logarithm of the complementary error function; far out the first term of its asymptotic series, which is exact to a thousandth there.
fn ln_complement(z: f64) -> f64 {
    match z > FAR {
        true => -z * z - (z * std::f64::consts::PI.sqrt()).ln(),
        false => libm::erfc(z).ln(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_certainty_is_that_of_tables_of_the_normal_distribution() {
        let capacity = Capacity {
            mean_m3: 0.01,
            spread_m3: 0.001,
        };
        // Half of all containers come to hold the mean, and an empty one is no condition.
        assert!((capacity.certainty(0.0, 0.01) - 0.5).abs() < 1e-9);
        assert!((capacity.certainty(0.0, 0.011) - 0.158_655_254).abs() < 1e-8);
        // Of those that hold the mean, the share that holds a deviation more.
        assert!((capacity.certainty(0.01, 0.001) - 0.317_310_508).abs() < 1e-8);
    }

    #[test]
    fn the_certainty_goes_on_evenly_far_from_the_mean() {
        let near = ln_complement(FAR - 1e-9);
        let far = ln_complement(FAR + 1e-9);
        assert!((near - far).abs() < 1e-3, "{near} {far}");
        let capacity = Capacity {
            mean_m3: 0.01,
            spread_m3: 1e-5,
        };
        let certainty = capacity.certainty(0.02, 1e-6);
        assert!((0.0..1.0).contains(&certainty), "{certainty}");
    }
}
