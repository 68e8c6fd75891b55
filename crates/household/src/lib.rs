//! The built-in household set: everyday objects made by this program, for demonstrations and tests
//! that need no files.
//!
//! The set is the same in every run, bit for bit on one build. Every mesh is a closed manifold in a
//! resting pose: it stands on its flat underside at z = 0 and is centred in x and y. Hollow things
//! are hollow: bowls and mugs enclose the volume of their walls only.
//!
//! ```
//! let mut objects = ppnpack_household::OBJECTS.iter();
//! let mug = objects.find(|object| object.name == "mug").ok_or("the set has a mug")?;
//! let mass_kg = mug.density_kg_m3 * mug.mesh.signed_volume_m3();
//! assert!((0.2..0.5).contains(&mass_kg));
//! # Ok::<(), &str>(())
//! ```
//!
//! [`builtin`] is the set for `Catalogue::load`.

mod field;
mod outline;
mod set;
mod simplify;
mod solid;
mod surface_nets;
mod surfaces;
#[cfg(test)]
mod tests;

use std::sync::{Arc, LazyLock};

use ppnpack_catalogue::cache::{CacheDir, kept};
use ppnpack_catalogue::catalogue::{NamedMesh, Source};
use rayon::prelude::*;

/// What stands for the set where a folder of meshes could be named.
pub const BUILTIN: &str = "builtin";

/// All objects of the set, by ascending volume. The first use builds them, in parallel, which takes
/// about a second of one core.
pub static OBJECTS: LazyLock<Arc<[NamedMesh]>> = LazyLock::new(|| built().into());

/// What the set follows from: another text makes it anew.
const SOURCES: [&str; 15] = [
    include_str!("field.rs"),
    include_str!("lib.rs"),
    include_str!("outline.rs"),
    include_str!("set/boxes.rs"),
    include_str!("set/home.rs"),
    include_str!("set/mod.rs"),
    include_str!("set/packs.rs"),
    include_str!("set/produce.rs"),
    include_str!("set/tableware.rs"),
    include_str!("set/tools.rs"),
    include_str!("set/toys.rs"),
    include_str!("simplify.rs"),
    include_str!("solid.rs"),
    include_str!("surface_nets.rs"),
    include_str!("surfaces.rs"),
];

/// The objects that a setting names: the set for [`BUILTIN`], which is kept where models are, else those of a folder of meshes.
pub fn source(name: &str, cache: &CacheDir) -> Source {
    if name != BUILTIN {
        return Source::Folder(name.into());
    }
    let mut hasher = blake3::Hasher::new();
    for source in SOURCES {
        hasher.update(source.as_bytes());
    }
    let name = format!("{}.household", hasher.finalize().to_hex());
    Source::Meshes(kept(cache, &name, || OBJECTS.to_vec()).into())
}

/// The set as the source of a catalogue.
pub fn builtin() -> Source {
    Source::Meshes(Arc::clone(&OBJECTS))
}

fn built() -> Vec<NamedMesh> {
    let recipes = set::recipes().into_par_iter();
    let objects = recipes.map(|(name, mass_g, build)| {
        let mesh = build().into_mesh();
        let volume_m3 = mesh.signed_volume_m3();
        let object = NamedMesh {
            name: name.to_owned(),
            density_kg_m3: mass_g * 1e-3 / volume_m3,
            mesh,
        };
        (volume_m3, object)
    });
    let mut objects: Vec<_> = objects.collect();
    objects.sort_by(|(one_m3, one), (other_m3, other)| {
        one_m3
            .total_cmp(other_m3)
            .then_with(|| one.name.cmp(&other.name))
    });
    objects.into_iter().map(|(_, object)| object).collect()
}
