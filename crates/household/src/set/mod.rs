//! What is in the set: tables of names, masses and shapes. Lengths are in millimetres, masses in
//! grams, as printed on such goods.

mod boxes;
mod home;
mod packs;
mod produce;
mod tableware;
mod tools;
mod toys;

use crate::solid::Solid;

/// An object's name and mass, and what makes it in its resting pose.
pub(crate) type Recipe = (&'static str, f64, fn() -> Solid);

/// Every recipe of the set.
pub(crate) fn recipes() -> Vec<Recipe> {
    [
        boxes::RECIPES,
        packs::RECIPES,
        tableware::RECIPES,
        produce::RECIPES,
        tools::RECIPES,
        toys::RECIPES,
        home::RECIPES,
    ]
    .concat()
}
