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
    if z < 0.0 {
        return (1.0 - 0.5 * ln_complement(-z).exp()).ln();
    }
    ln_complement(z) - std::f64::consts::LN_2
}

/// The logarithm of the complementary error function, for numbers from 0 on; wrong by less than 1.2e-7. Press et al., Numerical Recipes in C,
/// second edition, section 6.2, erfcc.
fn ln_complement(z: f64) -> f64 {
    const FACTORS: [f64; 10] = [
        -1.265_512_23,
        1.000_023_68,
        0.374_091_96,
        0.096_784_18,
        -0.186_288_06,
        0.278_868_07,
        -1.135_203_98,
        1.488_515_87,
        -0.822_152_23,
        0.170_872_77,
    ];
    let t = 1.0 / (1.0 + 0.5 * z);
    let factors = FACTORS.iter().rev();
    let sum = factors.fold(0.0, |sum, factor| sum * t + factor);
    t.ln() - z * z + sum
}
