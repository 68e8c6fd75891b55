//! What is in the set: tables of names, masses and shapes. Lengths are in millimetres, masses in
//! grams, as printed on such goods.

mod boxes;
mod home;
mod packs;
mod produce;
mod tableware;
mod tools;
mod toys;

use crate::recipe::Recipe;

/// Every recipe of the set.
pub(crate) fn recipes() -> Vec<&'static Recipe> {
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
