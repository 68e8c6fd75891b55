//! Scenes to be drawn.

use nalgebra::{Isometry3, Point3};

use crate::colour::Colour;

/// A mesh to draw, borrowed from wherever it is kept.
///
/// Triangles that name a missing vertex, or one that is not finite, are skipped. Winding does not
/// matter.
#[derive(Debug, Clone, Copy)]
pub struct TriangleMesh<'a> {
    /// Vertex positions, in metres.
    pub vertices: &'a [Point3<f64>],
    /// Vertex indices per triangle.
    pub triangles: &'a [[u32; 3]],
}

/// An object in a scene.
#[derive(Debug, Clone, Copy)]
pub struct Item<'a> {
    /// Its shape, in its own frame.
    pub mesh: TriangleMesh<'a>,
    /// Its pose: takes points of its own frame to the scene's.
    pub world_from_item: Isometry3<f64>,
    /// Its colour; see [`Colour::of_item`].
    pub colour: Colour,
}

/// A scene to be drawn: z points up, lengths are in metres.
#[derive(Debug, Clone, Default)]
pub struct Scene3d<'a> {
    /// The objects, in any order.
    pub items: Vec<Item<'a>>,
    /// The container's inner dimensions, in metres; its inner bottom corner is the origin. Without
    /// one, the items stand on the ground.
    pub container_m: Option<[f64; 3]>,
}
