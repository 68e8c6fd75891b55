//! Meshes to packable items.

pub mod mesh;
pub mod object;
