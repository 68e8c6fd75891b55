//! The value of a scene: the volume that may still be packed, as learned from packings.
//!
//! The value is linear in [`figures`] of the surface with the item on it and of the items that
//! wait: `V = C sum(c_i f_i)`, `C` the container's volume. What all placements of a step share has
//! no influence. With `F` the objective and `v` the item's volume, the best are tried by increasing
//! `F - w (v + V)`, `w` the weight per litre ([`Farsighted`]). `experiments/value.py` learns the
//! coefficients of what `experiment value` packs; docs/results/value.md has their worth.
//!
//! It is a value function of reinforcement learning, by Monte Carlo (Sutton and Barto,
//! *Reinforcement Learning*, 2018, chapter 9), one step of improvement over the objective.

mod figures;
mod ranking;

use ppnpack_numbers::{SettingError, settings, within};

pub use figures::{FIGURES, FIGURES_OF_ITEMS, Squares, figures};
pub use ranking::Farsighted;

/// Learned by `ppnpack-experiments experiment value` from 201 packings of 96 household objects on
/// 2.5 mm and 16 yaws, without a value (sequences 1000 to 1199 and 1201 of the tests' file).
#[rustfmt::skip]
const COEFFICIENTS: [f64; FIGURES] = [
    -0.016907, 0.045459, -0.005003, -0.007437, -0.005139, -0.032349, -0.013268, 0.000641,
    -0.168549, 0.019924, 0.012182, 0.010122, 0.007252, 0.003969, 0.003259, 0.003960,
    0.021107, 0.000907, -0.002891, 0.014021, -0.002356, -0.008185, 0.012512, 0.006580,
    0.004515, 0.013068, 0.004916, -0.017459, -0.003775, -0.006364, 0.016484, 0.013707,
    -0.022191, -0.002861, -0.008503, 0.016255, 0.011674, -0.026028, -0.005757, 0.011662,
    0.019929, 0.013069, -0.020794, -0.003591, -0.003019, 0.011314, 0.005343, -0.010480,
    -0.004459, 0.008119, 0.001429, -0.001120, -0.011115, -0.004211, 0.004067, 0.013078,
    0.008377, -0.013401, 0.208770, -0.030876, -0.010762, 0.004201, 0.003675, 0.108153,
];

settings! {
    /// How much the value of what a placement leaves counts, where the items of the buffer compete
    /// together. The default is what fills containers most tightly.
    pub struct SceneValue {
        /// Worth of a litre, in the objective's units; with 0 nothing is valued.
        pub weight: f64 = 30.0,
        /// One for each of the [`FIGURES`]; where there are none, those that are built in.
        #[serde(skip_serializing_if = "Vec::is_empty")]
        pub coefficients: Vec<f64> = Vec::new(),
    }
}

impl SceneValue {
    /// Nothing is valued.
    pub fn off() -> Self {
        Self {
            weight: 0.0,
            ..Self::default()
        }
    }

    /// Whether scenes are valued.
    pub fn is_on(&self) -> bool {
        self.weight > 0.0
    }

    /// Checks that every number is possible.
    pub fn validate(&self) -> Result<(), SettingError> {
        let weight = within("between 0 and 1000000", 0.0..=1e6);
        weight("the weight of the scene's value", self.weight)?;
        let count = self.coefficients.len();
        if count > 0 {
            let all = within(
                "as many as there are figures",
                FIGURES as f64..=FIGURES as f64,
            );
            all("the number of the scene value's coefficients", count as f64)?;
        }
        let coefficient = within("between -1000 and 1000", -1e3..=1e3);
        let mut coefficients = self.coefficients.iter();
        coefficients.try_for_each(|it| coefficient("a coefficient of the scene's value", *it))
    }

    fn in_use(&self) -> Vec<f64> {
        match self.coefficients.is_empty() {
            true => COEFFICIENTS.to_vec(),
            false => self.coefficients.clone(),
        }
    }
}
