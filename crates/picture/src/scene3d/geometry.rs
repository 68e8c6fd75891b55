//! A scene as one list of triangles in the scene's frame, ready to draw.

use nalgebra::{Point3, Scalar};

use super::scene::{Item, Scene3d};
use crate::colour::Colour;
use crate::error::PictureError;

/// Maximum of triangles, and of vertices, in a scene: together some 200 MB.
const MOST_TRIANGLES: usize = 1 << 22;

/// Maximum distance from the origin, in metres: vertices beyond are taken for mistakes.
const FURTHEST_M: f32 = 1e4;

/// The triangles of a scene. Indices within are valid by construction.
#[derive(Debug, Default)]
pub(super) struct Geometry {
    pub(super) vertices: Vec<Point3<f32>>,
    /// Vertex indices per triangle.
    pub(super) triangles: Vec<[u32; 3]>,
    /// Per triangle the number of the item, floor or frame that it is of.
    pub(super) parts: Vec<u32>,
    /// One per part.
    pub(super) colours: Vec<Colour>,
}

impl Geometry {
    /// Collects the items and the container's floor and frame.
    ///
    /// # Errors
    /// [`PictureError`] where there are more than [`MOST_TRIANGLES`].
    pub(super) fn of(scene: &Scene3d<'_>) -> Result<Self, PictureError> {
        let mut geometry = Self::default();
        for item in &scene.items {
            geometry.add_item(item)?;
        }
        let is_sound = |size: &[f32; 3]| size.iter().all(|m| *m > 0.0 && *m < FURTHEST_M);
        let size = scene.container_m;
        let size = size.map(|size| size.map(|extent| extent as f32));
        if let Some(size) = size.filter(is_sound) {
            geometry.add_container(size);
        }
        Ok(geometry)
    }

    /// Adds the sound triangles of an item.
    fn add_item(&mut self, item: &Item<'_>) -> Result<(), PictureError> {
        let mesh = &item.mesh;
        let room = |present: usize, added: usize| present.saturating_add(added) <= MOST_TRIANGLES;
        if !room(self.vertices.len(), mesh.vertices.len())
            || !room(self.triangles.len(), mesh.triangles.len())
        {
            return Err(PictureError::Impossible(format!(
                "the scene has more than {MOST_TRIANGLES} triangles or vertices"
            )));
        }
        let vertices: Vec<Point3<f32>> = mesh
            .vertices
            .iter()
            .map(|vertex| (item.world_from_item * vertex).map(|value| value as f32))
            .collect();
        let sound = |index: u32| {
            vertices
                .get(index as usize)
                .is_some_and(|vertex| vertex.iter().all(|value| value.abs() < FURTHEST_M))
        };
        let triangles: Vec<[u32; 3]> = mesh
            .triangles
            .iter()
            .filter(|[a, b, c]| a != b && b != c && a != c)
            .filter(|triangle| triangle.iter().all(|index| sound(*index)))
            .copied()
            .collect();
        self.colours.push(item.colour);
        self.add(&vertices, &triangles);
        Ok(())
    }

    /// Adds a thin slab under the inner volume and, as a part of its own, bars along the twelve
    /// edges outside of it.
    fn add_container(&mut self, [x, y, z]: [f32; 3]) {
        let width = 0.007 * x.max(y).max(z);
        self.colours.push(Colour::hex(0xe9ecef));
        // A hair below the floor's level, so that faces which rest on it do not flicker through.
        self.add_box([0.0, 0.0, -width], [x, y, -0.02 * width]);

        self.colours.push(Colour::hex(0x3e4c59));
        let beside = |extent: f32| [(-width, 0.0), (extent, extent + width)];
        for (y0, y1) in beside(y) {
            for (z0, z1) in beside(z) {
                self.add_box([-width, y0, z0], [x + width, y1, z1]);
            }
            for (x0, x1) in beside(x) {
                self.add_box([x0, y0, -width], [x1, y1, z + width]);
            }
        }
        for (x0, x1) in beside(x) {
            for (z0, z1) in beside(z) {
                self.add_box([x0, -width, z0], [x1, y + width, z1]);
            }
        }
    }

    fn add_box(&mut self, lowest: [f32; 3], highest: [f32; 3]) {
        const FACES: [[u32; 4]; 6] = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let vertices = box_corners(&Point3::from(lowest), &Point3::from(highest));
        let faces = FACES.iter();
        let triangles: Vec<[u32; 3]> = faces
            .flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]])
            .collect();
        self.add(&vertices, &triangles);
    }

    /// Adds triangles whose indices are in range to the last part.
    fn add(&mut self, vertices: &[Point3<f32>], triangles: &[[u32; 3]]) {
        let first = self.vertices.len() as u32;
        let moved = triangles
            .iter()
            .map(|corners| corners.map(|corner| first + corner));
        self.triangles.extend(moved);
        let part = self.colours.len().saturating_sub(1) as u32;
        self.parts.resize(self.triangles.len(), part);
        self.vertices.extend_from_slice(vertices);
    }
}

/// Gives the corners of a box along the axes; the bits of their numbers are x, y and z.
pub(super) fn box_corners<T: Scalar + Copy>(
    lowest: &Point3<T>,
    highest: &Point3<T>,
) -> [Point3<T>; 8] {
    std::array::from_fn(|number| {
        let end = |bit: u32| match number >> bit & 1 {
            0 => lowest,
            _ => highest,
        };
        Point3::new(end(0).x, end(1).y, end(2).z)
    })
}
