//! Heightmaps of a container: in grid units, and the finer surface in metres they are made from.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::kernel::grid::{Grid, MAX_UNITS, Units};
use crate::kernel::item::ItemView;
use crate::kernel::placement::{Placement, RestingPlacement};

/// Why a heightmap or a surface could not be made, for people.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct HeightmapError(String);

impl HeightmapError {
    /// Refuses the height of the cell with this index, which is not within 0 and a limit.
    fn height(index: usize, ny: usize, height: f64, limit: f64) -> Self {
        let (x, y) = (index / ny, index % ny);
        Self(format!(
            "the height {height} of cell ({x}, {y}) is not within 0 and {limit}"
        ))
    }
}

/// The height of a container's content per cell, in units, from the floor.
///
/// Row-major: cell `(x, y)` is at `x * ny + y`. Everything below a height counts as full.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Heightmap {
    nx: usize,
    ny: usize,
    heights: Vec<Units>,
}

impl Heightmap {
    /// An empty container: in each cell the greatest height of its inside surface, 0 of a box.
    pub fn empty(grid: &Grid) -> Self {
        let mut heightmap = Self::flat(grid);
        if !grid.container().is_box() {
            let resolution = grid.resolution();
            let inside_m = grid.inside_m(resolution.cell_m(), [grid.nx(), grid.ny()]);
            let units = inside_m.map(|height_m| resolution.units_above(f64::from(height_m)));
            heightmap.heights = units.collect();
        }
        heightmap
    }

    /// A heightmap at the height of the floor.
    pub(crate) fn flat(grid: &Grid) -> Self {
        Self {
            nx: grid.nx(),
            ny: grid.ny(),
            heights: vec![0; grid.nx() * grid.ny()],
        }
    }

    /// A heightmap of `nx` x `ny` cells from its heights in units, row-major.
    ///
    /// # Errors
    /// [`HeightmapError`] where the count differs or a height is negative or above [`MAX_UNITS`].
    pub fn from_units(nx: usize, ny: usize, heights: Vec<Units>) -> Result<Self, HeightmapError> {
        check_heights(nx, ny, &heights, MAX_UNITS, f64::from(MAX_UNITS))?;
        Ok(Self { nx, ny, heights })
    }

    /// Cells along x.
    pub fn nx(&self) -> usize {
        self.nx
    }

    /// Cells along y.
    pub fn ny(&self) -> usize {
        self.ny
    }

    /// The heights in units, row-major.
    pub fn heights(&self) -> &[Units] {
        &self.heights
    }

    /// The heights of the cells with index `x` along x.
    pub fn row(&self, x: usize) -> &[Units] {
        self.heights
            .get(x * self.ny..(x + 1) * self.ny)
            .unwrap_or(&[])
    }

    /// The height of a cell, in units; `None` outside the grid.
    pub fn get(&self, x: usize, y: usize) -> Option<Units> {
        let index = (y < self.ny).then_some(x * self.ny + y)?;
        self.heights.get(index).copied()
    }

    /// Raises a cell to at least `height` units; nothing happens outside the grid.
    pub fn raise(&mut self, x: usize, y: usize, height: Units) {
        if let Some(cell) = self.cell_mut(x, y) {
            *cell = (*cell).max(height.min(MAX_UNITS));
        }
    }

    pub(crate) fn lower(&mut self, x: usize, y: usize, height: Units) {
        if let Some(cell) = self.cell_mut(x, y) {
            *cell = (*cell).min(height);
        }
    }

    fn cell_mut(&mut self, x: usize, y: usize) -> Option<&mut Units> {
        let index = (y < self.ny).then_some(x * self.ny + y)?;
        self.heights.get_mut(index)
    }

    /// Raises the cells that an item's view covers to its upper surface where it rests.
    pub(crate) fn place(&mut self, view: &ItemView, at: &RestingPlacement) {
        let Placement { x, y, .. } = at.placement;
        for (cell_x, cell_y, _, top) in view.cells() {
            self.raise(x + cell_x, y + cell_y, at.resting_height + top);
        }
    }

    /// The greatest height, in units.
    pub fn max(&self) -> Units {
        self.heights.iter().copied().max().unwrap_or(0)
    }

    /// Gives the greatest height of what lies in the container, in units. Leaning walls do not
    /// count: a cell of theirs may be seen a unit higher than it is.
    pub fn highest_content(&self, grid: &Grid) -> Units {
        if grid.container().is_box() {
            return self.max();
        }
        let empty = Self::empty(grid);
        let cells = self.heights.iter().zip(&empty.heights);
        let content = cells.filter(|(height, empty)| **height > **empty + 1);
        content.map(|(height, _)| *height).max().unwrap_or(0)
    }
}

/// The surface of a container's content in metres, sampled more finely than the cells of its grid.
///
/// Each sample is the greatest height within its square of `pitch_m` edge; row-major. Where nothing
/// was seen it is a bound: nothing there is known to hold an item up.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Surface {
    nx: usize,
    ny: usize,
    pitch_m: f64,
    heights_m: Vec<f32>,
    /// Heights that hold an item up; `None` where all do.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    support_m: Option<Vec<f32>>,
}

impl Surface {
    /// The inside surface of an empty container, sampled [`Resolution::samples_per_cell`] times per
    /// cell; 0 of a box.
    ///
    /// [`Resolution::samples_per_cell`]: crate::kernel::grid::Resolution::samples_per_cell
    pub fn empty(grid: &Grid) -> Self {
        let mut surface = Self::flat(grid);
        if !grid.container().is_box() {
            let inside_m = grid.inside_m(surface.pitch_m, [surface.nx, surface.ny]);
            surface.heights_m = inside_m.collect();
        }
        surface
    }

    /// A surface at the height of the floor, with the samples of [`Self::empty`].
    pub fn flat(grid: &Grid) -> Self {
        let samples = grid.resolution().samples_per_cell();
        let (nx, ny) = (grid.nx() * samples, grid.ny() * samples);
        Self {
            nx,
            ny,
            pitch_m: grid.resolution().surface_pitch_m(),
            heights_m: vec![0.0; nx * ny],
            support_m: None,
        }
    }

    /// A surface of `nx` x `ny` samples, `pitch_m` apart, from its heights in metres, row-major.
    ///
    /// # Errors
    /// [`HeightmapError`] where the count differs or a height is negative or not finite.
    pub fn from_metres(
        nx: usize,
        ny: usize,
        pitch_m: f64,
        heights_m: Vec<f32>,
    ) -> Result<Self, HeightmapError> {
        check_heights(nx, ny, &heights_m, f32::MAX, f64::INFINITY)?;
        Ok(Self {
            nx,
            ny,
            pitch_m,
            heights_m,
            support_m: None,
        })
    }

    /// The same surface, of which some heights are bounds: at each sample what holds an item up, in
    /// metres; 0, the floor, where nothing else does.
    ///
    /// # Errors
    /// [`HeightmapError`] where the count differs, or a height is negative or above that of its sample.
    pub fn with_support(self, support_m: Vec<f32>) -> Result<Self, HeightmapError> {
        check_heights(self.nx, self.ny, &support_m, f32::MAX, f64::INFINITY)?;
        let mut pairs = support_m.iter().zip(&self.heights_m).enumerate();
        if let Some((index, (held_m, height_m))) = pairs.find(|(_, (held, height))| held > height) {
            let (height, limit) = (f64::from(*held_m), f64::from(*height_m));
            return Err(HeightmapError::height(index, self.ny, height, limit));
        }
        let is_all = support_m == self.heights_m;
        Ok(Self {
            support_m: (!is_all).then_some(support_m),
            ..self
        })
    }

    /// Samples along x.
    pub fn nx(&self) -> usize {
        self.nx
    }

    /// Samples along y.
    pub fn ny(&self) -> usize {
        self.ny
    }

    /// The distance between two samples, in metres.
    pub fn pitch_m(&self) -> f64 {
        self.pitch_m
    }

    /// The heights in metres, row-major.
    pub fn heights_m(&self) -> &[f32] {
        &self.heights_m
    }

    /// The heights at which content was seen or is known, and so holds an item up, in metres,
    /// row-major; 0, the floor, where a height is only a bound.
    pub fn support_m(&self) -> &[f32] {
        self.support_m.as_deref().unwrap_or(&self.heights_m)
    }

    /// The surface of what was seen or is known alone.
    #[must_use]
    pub fn supporting(&self) -> Self {
        Self {
            heights_m: self.support_m().to_vec(),
            support_m: None,
            ..*self
        }
    }

    /// Whether some heights are bounds.
    pub fn has_bounds(&self) -> bool {
        self.support_m.is_some()
    }

    pub(crate) fn has_size_of(&self, other: &Self) -> bool {
        (self.nx, self.ny) == (other.nx, other.ny)
    }

    /// Gives what holds an item up at a sample, and the greatest possible height, in metres.
    pub(crate) fn at(&self, sample: usize) -> (f32, f32) {
        let of = |heights_m: &[f32]| heights_m.get(sample).copied().unwrap_or(0.0);
        (of(self.support_m()), of(&self.heights_m))
    }

    /// The greatest height of a sample and the eight around it, in metres.
    pub(crate) fn highest_around(&self, sample: usize) -> f32 {
        let around = |at: usize| at.saturating_sub(1)..at + 2;
        self.highest_in(around(sample / self.ny), around(sample % self.ny))
    }

    /// The greatest height of some rows and columns of samples, in metres.
    pub(crate) fn highest_in(&self, xs: Range<usize>, ys: Range<usize>) -> f32 {
        let rows = self.heights_m.chunks_exact(self.ny.max(1));
        let rows = rows.skip(xs.start).take(xs.len());
        let samples = rows.flat_map(|row| row.iter().skip(ys.start).take(ys.len()));
        samples.copied().fold(0.0, f32::max)
    }

    /// The same surface with other heights, and what of them holds an item up.
    pub(crate) fn with_heights(self, heights_m: Vec<f32>, support_m: Vec<f32>) -> Self {
        let is_all = heights_m == support_m;
        Self {
            heights_m,
            support_m: (!is_all).then_some(support_m),
            ..self
        }
    }

    /// How many samples lie along a cell's edge, where that is what the grid's resolution asks for.
    pub(crate) fn samples_per_cell(&self, grid: &Grid) -> Result<usize, HeightmapError> {
        let samples = grid.resolution().samples_per_cell();
        let expected = (grid.nx() * samples, grid.ny() * samples);
        sampled("surface", expected, (self.nx, self.ny))?;
        Ok(samples)
    }

    /// Raises a sample to at least `height_m`; nothing happens outside the surface.
    pub fn raise(&mut self, x: usize, y: usize, height_m: f32) {
        if y < self.ny
            && let Some(sample) = self.heights_m.get_mut(x * self.ny + y)
        {
            *sample = sample.max(height_m);
            let held = self.support_m.as_mut();
            if let Some(held_m) = held.and_then(|held| held.get_mut(x * self.ny + y)) {
                *held_m = held_m.max(height_m);
            }
        }
    }
}

/// Checks the count, and that no height is below 0 or above the greatest; `limit` names that.
fn check_heights<T: Copy + PartialOrd + Default + Into<f64>>(
    nx: usize,
    ny: usize,
    heights: &[T],
    greatest: T,
    limit: f64,
) -> Result<(), HeightmapError> {
    let found = heights.len();
    if found != nx * ny {
        let needed = nx * ny;
        return Err(HeightmapError(format!(
            "a heightmap of {nx} x {ny} cells needs {needed} heights, but {found} were given"
        )));
    }
    let range = T::default()..=greatest;
    // As a rule all are possible, which a loop without an early exit finds out many times faster.
    let inside = |inside, height| inside & range.contains(height);
    if heights.iter().fold(true, inside) {
        return Ok(());
    }
    let mut heights = heights.iter().enumerate();
    match heights.find(|(_, height)| !range.contains(height)) {
        None => Ok(()),
        Some((index, height)) => Err(HeightmapError::height(index, ny, (*height).into(), limit)),
    }
}

/// Checks that a map covers the grid as its resolution asks, by values along x and y.
pub(crate) fn sampled(
    map: &'static str,
    (nx, ny): (usize, usize),
    found: (usize, usize),
) -> Result<(), HeightmapError> {
    match found {
        found if found == (nx, ny) => Ok(()),
        (x, y) => Err(HeightmapError(format!(
            "the {map} has {x} x {y} values where the grid needs {nx} x {ny}"
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_walls_of_a_tote_are_no_content() {
        let tote = crate::kernel::grid::ContainerSize {
            draft_rad: 0.1,
            ..crate::kernel::grid::ContainerSize::REFERENCE
        };
        let grid = Grid::new(tote, crate::kernel::grid::Resolution::reference()).unwrap();
        let mut heightmap = Heightmap::empty(&grid);
        assert_eq!(heightmap.max(), grid.rim());
        assert_eq!(heightmap.highest_content(&grid), 0);
        heightmap.raise(16, 16, 20);
        assert_eq!(heightmap.highest_content(&grid), 20);
    }

    #[test]
    fn heightmaps_of_wrong_size_or_value_are_refused() {
        for (heights, expected) in [
            (vec![0; 3], "2 x 2 cells needs 4 heights, but 3 were"),
            (vec![0, 0, 0, -1], "height -1 of cell (1, 1)"),
        ] {
            let refused = Heightmap::from_units(2, 2, heights).unwrap_err();
            assert!(refused.to_string().contains(expected), "{refused}");
        }
        assert!(Surface::from_metres(1, 1, 0.01, vec![f32::NAN]).is_err());
    }
}
