//! A solid as it lies, seen from above and from below.

use std::sync::Arc;

use nalgebra::{Isometry3, Point2};

use crate::content::LyingSolid;
use crate::model::Model;
use crate::model::raster::{Raster, rasterise};

/// The upper and the lower side of a solid in the squares of a raster that it covers.
#[derive(Debug)]
pub(super) struct Sides {
    model: Arc<Model>,
    container_from_item: Isometry3<f64>,
    first: (usize, usize),
    size: (usize, usize),
    /// Row-major; `None` where there is no material.
    heights_m: Vec<Option<Heights>>,
    /// The centre of mass from above, in metres in the container frame.
    centre_of_mass: Point2<f64>,
}

/// The lowest and the highest point of a solid within a square, in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Heights {
    pub(super) lowest_m: f32,
    pub(super) highest_m: f32,
}

impl Sides {
    /// Draws the part of a solid within a raster.
    pub(super) fn new(solid: &LyingSolid, raster: &Raster) -> Self {
        let posed = solid.model.mesh.transformed(&solid.container_from_item);
        let bounds = posed.bounds();
        let along = |low_m: f64, high_m: f64, origin_m: f64, count: usize| {
            // Casts saturate: what is outside becomes 0 or the count.
            let first = (((low_m - origin_m) / raster.pitch_m).floor() as usize).min(count);
            let end = (((high_m - origin_m) / raster.pitch_m).ceil() as usize).min(count);
            (first, end.saturating_sub(first))
        };
        let (x, y) = bounds.map_or(((0, 0), (0, 0)), |bounds| {
            let (low, high) = (bounds.lowest, bounds.highest);
            (
                along(low.x, high.x, raster.origin.x, raster.nx),
                along(low.y, high.y, raster.origin.y, raster.ny),
            )
        });
        let mut sides = Self {
            model: Arc::clone(&solid.model),
            container_from_item: solid.container_from_item,
            first: (x.0, y.0),
            size: (x.1, y.1),
            heights_m: vec![None; x.1 * y.1],
            centre_of_mass: (solid.container_from_item * solid.model.mass.centre_of_mass_m).xy(),
        };
        for triangle in posed.corners() {
            rasterise(&triangle, raster, |x, y, lowest_m, highest_m| {
                sides.extend(x, y, lowest_m as f32, highest_m as f32);
            });
        }
        sides
    }

    fn extend(&mut self, x: usize, y: usize, lowest_m: f32, highest_m: f32) {
        let Some(heights) = self
            .index(x, y)
            .and_then(|index| self.heights_m.get_mut(index))
        else {
            return;
        };
        let before = heights.unwrap_or(Heights {
            lowest_m,
            highest_m,
        });
        *heights = Some(Heights {
            lowest_m: before.lowest_m.min(lowest_m),
            highest_m: before.highest_m.max(highest_m),
        });
    }

    fn index(&self, x: usize, y: usize) -> Option<usize> {
        let (x, y) = (x.checked_sub(self.first.0)?, y.checked_sub(self.first.1)?);
        (x < self.size.0 && y < self.size.1).then_some(x * self.size.1 + y)
    }

    /// Whether it is the solid, where it lies.
    pub(super) fn is_of(&self, solid: &LyingSolid) -> bool {
        Arc::ptr_eq(&self.model, &solid.model)
            && self.container_from_item == solid.container_from_item
    }

    /// Its centre of mass from above, in metres in the container frame.
    pub(super) fn centre_of_mass(&self) -> &Point2<f64> {
        &self.centre_of_mass
    }

    /// Its heights in a square, where it has material there.
    pub(super) fn at(&self, x: usize, y: usize) -> Option<Heights> {
        *self.heights_m.get(self.index(x, y)?)?
    }

    /// The squares in which it has material, by their indices along x and y.
    pub(super) fn squares(&self) -> impl Iterator<Item = (usize, usize, Heights)> + '_ {
        let squares = self.heights_m.iter().enumerate();
        squares.filter_map(|(index, heights)| {
            let (x, y) = (index / self.size.1, index % self.size.1);
            Some((self.first.0 + x, self.first.1 + y, (*heights)?))
        })
    }

    /// Whether the rectangles around both have squares in common.
    pub(super) fn may_meet(&self, other: &Self) -> bool {
        let overlaps = |one: usize, length: usize, other: usize, other_length: usize| {
            one < other + other_length && other < one + length
        };
        overlaps(self.first.0, self.size.0, other.first.0, other.size.0)
            && overlaps(self.first.1, self.size.1, other.first.1, other.size.1)
    }
}
