//! Limits of loads.

use std::sync::Arc;

use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_catalogue::object::Model;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// An object whose limit the catalogue does not say may carry between so many times its own mass: a
/// factor drawn once an object, its logarithm evenly.
pub(super) const FACTORS: [f64; 2] = [0.5, 5.0];

/// Draws the limit of each object, in kilograms, by its index.
pub(super) fn draw(catalogue: &Catalogue) -> Vec<f64> {
    let [least, greatest] = FACTORS;
    let mut random = ChaCha8Rng::seed_from_u64(0);
    let limits = catalogue.objects.iter().map(|object| {
        // Drawn for all, so that one that is known changes no other.
        let factor = least * (greatest / least).powf(random.random::<f64>());
        let model = &object.model;
        model.carries_kg.unwrap_or(factor * model.mass.mass_kg)
    });
    limits.collect()
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
