//! The built-in household set: everyday objects made by this program, for demonstrations and tests
//! that need no files.
//!
//! The set is the same on every call, bit for bit on one build. Every mesh is a closed manifold
//! that stands on its flat underside at z = 0 and is centred in x and y. Hollow things are hollow:
//! bowls and mugs enclose the volume of their walls only.
//!
//! ```
//! let objects = ppnpack_household::objects();
//! let mug = objects.iter().find(|object| object.name == "mug").ok_or("the set has a mug")?;
//! assert!((0.2..0.5).contains(&mug.mass_kg()));
//! # Ok::<(), &str>(())
//! ```
//!
//! [`builtin`] is the set for `Catalogue::load`.

mod field;
mod outline;
mod recipe;
mod set;
mod simplify;
mod solid;
mod surface_nets;
mod surfaces;
#[cfg(test)]
mod tests;

use ppnpack_catalogue::catalogue::{NamedMesh, Source};
use ppnpack_catalogue::mesh::Mesh;
use rayon::prelude::*;

use recipe::Recipe;

pub use recipe::Category;

/// What stands for the set where a folder of meshes could be named.
pub const BUILTIN: &str = "builtin";

/// The objects that a setting names: the set for [`BUILTIN`], else those of a folder of meshes.
pub fn source(name: &str) -> Source {
    if name == BUILTIN {
        builtin()
    } else {
        Source::Folder(name.into())
    }
}

/// The set as the source of a catalogue. It is built on each call, which takes about a second of one core.
pub fn builtin() -> Source {
    let named = |object: HouseholdObject| NamedMesh {
        name: object.name.to_owned(),
        mesh: object.mesh,
        density_kg_m3: object.density_kg_m3,
    };
    Source::Meshes(objects().into_iter().map(named).collect())
}

/// An everyday object.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct HouseholdObject {
    /// Unique in the set; lower case with underscores.
    pub name: &'static str,
    /// What kind of thing it is.
    pub category: Category,
    /// Mass over enclosed volume, in kilograms per cubic metre: a full can is denser than a pack of
    /// crisps.
    pub density_kg_m3: f64,
    /// The surface, in metres, in a resting pose on the plane z = 0, centred in x and y.
    pub mesh: Mesh,
}

impl HouseholdObject {
    /// The enclosed volume, in cubic metres.
    pub fn volume_m3(&self) -> f64 {
        self.mesh.signed_volume_m3()
    }

    /// The mass, in kilograms.
    pub fn mass_kg(&self) -> f64 {
        self.density_kg_m3 * self.volume_m3()
    }

    fn from_recipe(recipe: &Recipe) -> Self {
        let mesh = (recipe.build)().into_mesh();
        Self {
            name: recipe.name,
            category: recipe.category,
            density_kg_m3: recipe.mass_g * 1e-3 / mesh.signed_volume_m3(),
            mesh,
        }
    }
}

/// All objects of the set, by ascending volume. They are built on each call, in parallel.
pub fn objects() -> Vec<HouseholdObject> {
    let mut objects: Vec<_> = set::recipes()
        .into_par_iter()
        .map(HouseholdObject::from_recipe)
        .collect();
    objects.sort_by(|a, b| {
        a.volume_m3()
            .total_cmp(&b.volume_m3())
            .then(a.name.cmp(b.name))
    });
    objects
}
