//! The value of a scene: the volume that may still be packed, as learned from packings.
//!
//! The value is linear in [`figures`] of the surface with the item on it and of the items that
//! still wait: `V = C sum(c_i f_i)`, `C` the container's volume. What is the same for all
//! placements of a step has no influence on it. With `F` the objective and `v` the item's volume,
//! the best placements are tried by increasing `F - w (v + V)`, `w` the weight per litre
//! ([`Farsighted`]). `experiments/value.py` learns the coefficients of what `experiment value`
//! packs; docs/results/value.md says what they are worth.
//!
//! It is a learned value function of reinforcement learning, by Monte Carlo (Sutton and Barto,
//! *Reinforcement Learning*, 2018, chapter 9), with one step of improvement over the objective that
//! it was learned under.

mod built_in;
mod figures;
mod ranking;

use ppnpack_numbers::{SettingError, within};
use serde::{Deserialize, Serialize};

pub use figures::{FIGURES, FIGURES_OF_ITEMS, Squares, figures};
pub use ranking::Farsighted;

/// How much the value of what a placement leaves counts, where the items of the buffer compete
/// together. The default is what fills containers most tightly.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SceneValue {
    /// Worth of a litre, in the objective's units; with 0 nothing is valued.
    pub weight: f64,
    /// One for each of the [`FIGURES`]; where there are none, those that are built in.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub coefficients: Vec<f64>,
}

impl Default for SceneValue {
    fn default() -> Self {
        Self {
            weight: 30.0,
            coefficients: Vec::new(),
        }
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
    ///
    /// # Errors
    /// [`SettingError`] names the first that is not.
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
            true => built_in::COEFFICIENTS.to_vec(),
            false => self.coefficients.clone(),
        }
    }
}
