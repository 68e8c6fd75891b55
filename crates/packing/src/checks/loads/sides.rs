//! A solid as it lies, seen from above and from below.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::{Isometry3, Point2};

use crate::scene::content::LyingSolid;
use crate::scene::model::Model;
use crate::scene::model::mesh::Bounds;
use crate::scene::model::raster::{Raster, rasterise};

/// The upper and the lower side of a solid in the squares of a raster that it covers.
#[derive(Debug)]
pub(super) struct Sides {
    model: Arc<Model>,
    container_from_item: Isometry3<f64>,
    xs: Range<usize>,
    ys: Range<usize>,
    /// Row-major; the lowest above the highest where there is no material.
    heights_m: Vec<Heights>,
    pub(super) centre_of_mass: Point2<f64>,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Heights {
    pub(super) lowest_m: f32,
    pub(super) highest_m: f32,
}

impl Heights {
    const NOTHING: Self = Self {
        lowest_m: f32::INFINITY,
        highest_m: f32::NEG_INFINITY,
    };

    fn of_material(self) -> Option<Self> {
        (self.lowest_m <= self.highest_m).then_some(self)
    }
}

impl Sides {
    /// Draws the part of a solid within a raster from the origin.
    pub(super) fn new(solid: &LyingSolid, raster: &Raster) -> Self {
        let posed = solid.model.mesh.transformed(&solid.container_from_item);
        let squares = |bounds: Bounds| bounds.squares(raster.pitch_m, [raster.nx, raster.ny]);
        let [xs, ys] = posed.bounds().map_or([0..0, 0..0], squares);
        let mut sides = Self {
            model: Arc::clone(&solid.model),
            container_from_item: solid.container_from_item,
            heights_m: vec![Heights::NOTHING; xs.len() * ys.len()],
            xs,
            ys,
            centre_of_mass: (solid.container_from_item * solid.model.mass.centre_of_mass_m).xy(),
        };
        for triangle in posed.corners() {
            rasterise(&triangle, raster, |x, y, lowest_m, highest_m| {
                let index = sides.index(x, y);
                if let Some(heights) = index.and_then(|index| sides.heights_m.get_mut(index)) {
                    heights.lowest_m = heights.lowest_m.min(lowest_m as f32);
                    heights.highest_m = heights.highest_m.max(highest_m as f32);
                }
            });
        }
        sides
    }

    fn index(&self, x: usize, y: usize) -> Option<usize> {
        let is_inside = self.xs.contains(&x) && self.ys.contains(&y);
        is_inside.then(|| (x - self.xs.start) * self.ys.len() + y - self.ys.start)
    }

    pub(super) fn is_of(&self, solid: &LyingSolid) -> bool {
        Arc::ptr_eq(&self.model, &solid.model)
            && self.container_from_item == solid.container_from_item
    }

    pub(super) fn at(&self, x: usize, y: usize) -> Option<Heights> {
        self.heights_m.get(self.index(x, y)?)?.of_material()
    }

    pub(super) fn squares(&self) -> impl Iterator<Item = (usize, usize, Heights)> + '_ {
        let squares = self.heights_m.iter().enumerate();
        squares.filter_map(|(index, heights)| {
            let (x, y) = (index / self.ys.len(), index % self.ys.len());
            Some((self.xs.start + x, self.ys.start + y, heights.of_material()?))
        })
    }

    /// Whether the rectangles around both have squares in common.
    pub(super) fn may_meet(&self, other: &Self) -> bool {
        let overlap = |one: &Range<usize>, other: &Range<usize>| {
            one.start < other.end && other.start < one.end
        };
        overlap(&self.xs, &other.xs) && overlap(&self.ys, &other.ys)
    }
}
