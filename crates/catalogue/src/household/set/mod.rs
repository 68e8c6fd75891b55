//! What is in the set: tables of names, masses and shapes. Lengths are in millimetres, masses in
//! grams, as printed on such goods.

mod boxes;
mod home;
mod packs;
mod produce;
mod tableware;
mod tools;
mod toys;

use super::Category;
use super::solid::Solid;

/// How to make one object.
#[derive(Debug)]
pub(super) struct Recipe {
    pub(super) name: &'static str,
    pub(super) category: Category,
    pub(super) mass_g: f64,
    /// Makes the object in its resting pose.
    pub(super) build: fn() -> Solid,
}

const fn recipe(
    category: Category,
    name: &'static str,
    mass_g: f64,
    build: fn() -> Solid,
) -> Recipe {
    Recipe {
        name,
        category,
        mass_g,
        build,
    }
}

/// Every recipe of the set.
pub(super) fn recipes() -> Vec<&'static Recipe> {
    [
        boxes::RECIPES,
        packs::RECIPES,
        tableware::RECIPES,
        produce::RECIPES,
        tools::RECIPES,
        toys::RECIPES,
        home::RECIPES,
    ]
    .into_iter()
    .flatten()
    .collect()
}
