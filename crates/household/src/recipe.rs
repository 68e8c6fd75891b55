//! What an object of the set is made from.

use crate::solid::Solid;

/// What kind of thing an object is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Category {
    /// Cartons and books.
    Boxes,
    /// Metal cans and tubes of card.
    Cans,
    /// Jars of glass.
    Jars,
    /// Bottles with their content.
    Bottles,
    /// Bags that bulge.
    SoftPacks,
    /// Cups, bowls, plates, pots; empty.
    Tableware,
    /// Forks, spoons, knives.
    Cutlery,
    /// Fruit and vegetables.
    Produce,
    /// Hand tools.
    Tools,
    /// Toys and balls.
    Toys,
    /// Everything else about the house.
    Household,
}

/// How to make one object.
#[derive(Debug)]
pub(crate) struct Recipe {
    pub(crate) name: &'static str,
    pub(crate) category: Category,
    pub(crate) mass_g: f64,
    /// Makes the object in its resting pose.
    pub(crate) build: fn() -> Solid,
}

pub(crate) const fn recipe(
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
