//! The built-in household set: 96 everyday objects, for demonstrations and tests that need no
//! files.
//!
//! Every mesh is a closed manifold in a resting pose: it stands on its flat underside at z = 0 and
//! is centred in x and y. Hollow things are hollow: bowls and mugs enclose the volume of their
//! walls only.
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

use std::sync::{Arc, LazyLock};

use nalgebra::Point3;
use ppnpack_catalogue::catalogue::{NamedMesh, Source};
use ppnpack_catalogue::mesh::Mesh;

/// Name of the set where a folder of meshes could be named.
pub const BUILTIN: &str = "builtin";

/// All objects of the set, by ascending volume.
pub static OBJECTS: LazyLock<Arc<[NamedMesh]>> = LazyLock::new(|| {
    let read = postcard::from_bytes::<Vec<Stored>>(FILE);
    #[expect(clippy::expect_used, reason = "the file is part of the program")]
    let stored = read.expect("the built-in objects are whole");
    stored.into_iter().map(object).collect()
});

/// The objects in postcard, in the order of [`OBJECTS`].
const FILE: &[u8] = include_bytes!("../objects.postcard");

/// An object's name, density in kg/m^3, vertices in whole micrometres and triangles. Each
/// coordinate is the difference to that of the vertex before, each corner to the corner before.
type Stored = (String, f64, Vec<[i32; 3]>, Vec<[i32; 3]>);

/// Number that stands for a coordinate of -0.0.
const NEGATIVE_ZERO: i32 = i32::MIN;

/// Gives the objects that a setting names: the set for [`BUILTIN`], else those of a folder of
/// meshes.
pub fn source(name: &str) -> Source {
    if name == BUILTIN {
        builtin()
    } else {
        Source::Folder(name.into())
    }
}

/// Gives the set as the source of a catalogue.
pub fn builtin() -> Source {
    Source::Meshes(Arc::clone(&OBJECTS))
}

fn object((name, density_kg_m3, steps, turns): Stored) -> NamedMesh {
    let metres = |micrometres: i32| match micrometres {
        NEGATIVE_ZERO => -0.0,
        whole => f64::from(whole) / 1e6,
    };
    let mut last = [0_i32; 3];
    let vertices = steps.iter().map(|step| {
        for (coordinate, step) in last.iter_mut().zip(step) {
            *coordinate = coordinate.wrapping_add(*step);
        }
        Point3::from(last.map(metres))
    });
    let vertices = vertices.collect();
    let mut last = 0_i32;
    let triangles = turns.iter().map(|turns| {
        turns.map(|turn| {
            last = last.wrapping_add(turn);
            last as u32
        })
    });
    NamedMesh {
        name,
        mesh: Mesh {
            vertices,
            triangles: triangles.collect(),
        },
        density_kg_m3,
    }
}
