//! What each object may carry.

use std::sync::Arc;

use clap::Args;
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_catalogue::object::Model;
use ppnpack_cli::failure::{Failure, Outcome};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

/// An object whose limit the catalogue does not say may carry so many times its own mass: a factor between two, drawn once an object, its
/// logarithm evenly
#[derive(Debug, Clone, Copy, Args, Serialize)]
pub(super) struct LimitOptions {
    /// The least factor of its own mass that an object of unknown limit may carry
    #[arg(long, value_name = "FACTOR", default_value_t = 0.5)]
    pub(super) least_factor: f64,

    /// The greatest
    #[arg(long, value_name = "FACTOR", default_value_t = 5.0)]
    pub(super) greatest_factor: f64,

    /// The seed of the factors
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    pub(super) limits_seed: u64,
}

impl LimitOptions {
    /// What each object may carry, in kilograms, by its index.
    pub(super) fn draw(&self, catalogue: &Catalogue) -> Outcome<Vec<f64>> {
        let (least, greatest) = (self.least_factor, self.greatest_factor);
        if !(least > 0.0 && least <= greatest && greatest.is_finite()) {
            return Err(Failure::input(format_args!(
                "--least-factor {least} --greatest-factor {greatest}: give two above 0, the least first"
            )));
        }
        let mut random = ChaCha8Rng::seed_from_u64(self.limits_seed);
        let limits = catalogue.objects.iter().map(|object| {
            // Drawn for all, so that one that is known changes no other.
            let factor = least * (greatest / least).powf(random.random::<f64>());
            let model = &object.model;
            model.carries_kg.unwrap_or(factor * model.mass.mass_kg)
        });
        Ok(limits.collect())
    }
}

/// The catalogue with these limits, or without any.
pub(super) fn with_limits(catalogue: &Catalogue, limits_kg: Option<&[f64]>) -> Catalogue {
    let mut catalogue = catalogue.clone();
    for (index, object) in catalogue.objects.iter_mut().enumerate() {
        let carries_kg = limits_kg.and_then(|limits_kg| limits_kg.get(index).copied());
        let limited = |model: &Arc<Model>| {
            Arc::new(Model {
                carries_kg,
                ..Model::clone(model)
            })
        };
        object.model = limited(&object.model);
        for posed in &mut object.poses {
            posed.model = limited(&posed.model);
        }
    }
    catalogue
}
