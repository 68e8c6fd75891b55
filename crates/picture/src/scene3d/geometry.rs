//! A scene as one list of triangles in the scene's frame, ready to draw.

use nalgebra::{Point3, Scalar, Vector3};

use super::normals::corner_normals;
use super::scene::{Item, Scene3d};
use crate::colour::Colour;
use crate::error::PictureError;

/// The greatest number of triangles, and of vertices, in a scene: together some 300 MB.
const MOST_TRIANGLES: usize = 1 << 22;

/// Vertices further from the origin than this, in metres, are taken for mistakes.
const FURTHEST_M: f32 = 1e4;

/// How surfaces look.
#[derive(Debug, Clone, Copy)]
pub(super) struct Material {
    /// The share of light it returns, per channel.
    pub(super) albedo: Vector3<f32>,
    /// The strength of highlights: 0 for dull.
    pub(super) gloss: f32,
}

/// What shading needs of a triangle. Apart from its corners, which drawing goes through many times.
#[derive(Debug, Clone, Copy)]
pub(super) struct Finish {
    /// The shading normals, one per corner, of unit length.
    pub(super) normals: [Vector3<f32>; 3],
    /// Index of the material.
    pub(super) material: u32,
}

/// All that is opaque in a scene. Indices within are valid by construction.
#[derive(Debug, Default)]
pub(super) struct Geometry {
    pub(super) vertices: Vec<Point3<f32>>,
    /// Vertex indices per triangle.
    pub(super) triangles: Vec<[u32; 3]>,
    /// One per triangle.
    pub(super) finishes: Vec<Finish>,
    pub(super) materials: Vec<Material>,
    /// The first so many vertices and triangles cast shadows.
    pub(super) caster_vertices: usize,
    pub(super) caster_triangles: usize,
    /// The height of the ground everything stands on, in metres.
    pub(super) ground_m: f32,
    /// The container's inner dimensions, in metres, if it has sensible ones.
    pub(super) container_m: Option<[f32; 3]>,
    /// Centre and radius, in metres, of what the picture is about: where shadows are worked out.
    pub(super) focus: (Point3<f32>, f32),
}

impl Geometry {
    /// The items and the container's floor and frame.
    ///
    /// # Errors
    /// [`PictureError::SceneTooLarge`] where there are more than [`MOST_TRIANGLES`].
    pub(super) fn of(scene: &Scene3d<'_>) -> Result<Self, PictureError> {
        let mut geometry = Self::default();
        for item in &scene.items {
            geometry.add_item(item)?;
        }
        let (mut lowest, mut highest) = geometry.bounds();
        match scene
            .container_m
            .map(|size| size.map(|extent| extent as f32))
        {
            Some(size)
                if size
                    .iter()
                    .all(|extent| *extent > 0.0 && *extent < FURTHEST_M) =>
            {
                geometry.container_m = Some(size);
                let frame = frame_width(size);
                // Shadows are worked out around the container only, as sharp as they can be.
                lowest = Point3::from([-frame; 3]);
                highest = Point3::from(size) + Vector3::new(0.0, 0.0, 0.3 * size[2]);
                geometry.ground_m = -frame;
                geometry.add_floor(size, frame);
                // The frame casts none: it would draw distracting stripes on the content.
                geometry.mark_casters();
                geometry.add_frame(size, frame);
            }
            _ => {
                geometry.mark_casters();
                geometry.ground_m = lowest.z;
            }
        }
        let radius = (highest - lowest).norm() / 2.0;
        geometry.focus = (nalgebra::center(&lowest, &highest), radius.max(1e-4));
        Ok(geometry)
    }

    /// All that was added so far casts shadows; what comes after does not.
    fn mark_casters(&mut self) {
        self.caster_vertices = self.vertices.len();
        self.caster_triangles = self.triangles.len();
    }

    /// Adds the sound triangles of an item.
    fn add_item(&mut self, item: &Item<'_>) -> Result<(), PictureError> {
        let mesh = &item.mesh;
        let room = |present: usize, added: usize| present.saturating_add(added) <= MOST_TRIANGLES;
        if !room(self.vertices.len(), mesh.vertices.len())
            || !room(self.triangles.len(), mesh.triangles.len())
        {
            return Err(PictureError::SceneTooLarge {
                limit: MOST_TRIANGLES,
            });
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
        let material = Material {
            albedo: item.colour.to_linear(),
            gloss: 1.0,
        };
        self.add(&vertices, &triangles, material);
        Ok(())
    }

    /// A thin slab under the inner volume.
    fn add_floor(&mut self, [x, y, _]: [f32; 3], thickness: f32) {
        let material = Material {
            albedo: Colour::hex(0xe9ecef).to_linear(),
            gloss: 0.0,
        };
        // A hair below the floor's level, so that faces which rest on it do not flicker through.
        self.add_box([0.0, 0.0, -thickness], [x, y, -0.02 * thickness], material);
    }

    /// Bars along the twelve edges, outside the inner volume.
    fn add_frame(&mut self, [x, y, z]: [f32; 3], width: f32) {
        let material = Material {
            albedo: Colour::hex(0x3e4c59).to_linear(),
            gloss: 0.4,
        };
        let beside = |extent: f32| [(-width, 0.0), (extent, extent + width)];
        for (y0, y1) in beside(y) {
            for (z0, z1) in beside(z) {
                self.add_box([-width, y0, z0], [x + width, y1, z1], material);
            }
            for (x0, x1) in beside(x) {
                self.add_box([x0, y0, -width], [x1, y1, z + width], material);
            }
        }
        for (x0, x1) in beside(x) {
            for (z0, z1) in beside(z) {
                self.add_box([x0, -width, z0], [x1, y + width, z1], material);
            }
        }
    }

    fn add_box(&mut self, lowest: [f32; 3], highest: [f32; 3], material: Material) {
        const FACES: [[u32; 4]; 6] = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let vertices = box_corners(&Point3::from(lowest), &Point3::from(highest));
        let triangles: Vec<[u32; 3]> = FACES
            .iter()
            .flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]])
            .collect();
        self.add(&vertices, &triangles, material);
    }

    /// Adds triangles whose indices are in range.
    fn add(&mut self, vertices: &[Point3<f32>], triangles: &[[u32; 3]], material: Material) {
        let first = self.vertices.len() as u32;
        let number = self.materials.len() as u32;
        let moved = triangles
            .iter()
            .map(|corners| corners.map(|corner| first + corner));
        self.triangles.extend(moved);
        let finish = |normals| Finish {
            normals,
            material: number,
        };
        self.finishes
            .extend(corner_normals(vertices, triangles).into_iter().map(finish));
        self.vertices.extend_from_slice(vertices);
        self.materials.push(material);
    }

    /// The box around all triangles; a metre around the origin where there are none.
    fn bounds(&self) -> (Point3<f32>, Point3<f32>) {
        let corners = self.triangles.iter().flatten();
        let points = corners.filter_map(|corner| self.vertices.get(*corner as usize));
        let bounds = points.fold(None, |bounds: Option<(Point3<f32>, Point3<f32>)>, point| {
            let (lowest, highest) = bounds.unwrap_or((*point, *point));
            Some((lowest.inf(point), highest.sup(point)))
        });
        bounds.unwrap_or((Point3::from([-0.5; 3]), Point3::from([0.5; 3])))
    }
}

/// The corners of a box along the axes; the bits of their numbers are x, y and z.
pub(super) fn box_corners<T: Scalar + Copy>(
    lowest: &Point3<T>,
    highest: &Point3<T>,
) -> [Point3<T>; 8] {
    std::array::from_fn(|number| {
        let end = |bit: u32| {
            if number >> bit & 1 == 0 {
                lowest
            } else {
                highest
            }
        };
        Point3::new(end(0).x, end(1).y, end(2).z)
    })
}

/// The width of the bars along a container's edges, in metres.
fn frame_width([x, y, z]: [f32; 3]) -> f32 {
    0.007 * x.max(y).max(z)
}
