//! The container as it is seen and known: its heightmap, its surface, what lies in it.
//!
//! Nothing here plans. A picture becomes a [`Scene`]; what is hidden or blocked is entered in it.

pub mod blocked;
pub mod content;
pub mod expected;
pub mod hidden;
pub mod leaving;
pub mod model;

use crate::kernel::grid::Grid;
use crate::kernel::heightmap::{Heightmap, HeightmapError, Surface, sampled};
use content::Content;
use leaving::Leaving;

/// Scene that a placement is planned on: the container's heightmap, its fine surface where the
/// sensor gives one, and its content where known.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    heightmap: Heightmap,
    surface: Option<Surface>,
    content: Option<Content>,
    leaving: Option<Leaving>,
}

impl Scene {
    /// A scene from its heightmap, and its fine surface where known, neither from the other.
    ///
    /// # Errors
    /// [`HeightmapError`] where one of them does not cover the grid as its resolution asks.
    pub fn new(
        grid: &Grid,
        heightmap: Heightmap,
        surface: Option<Surface>,
    ) -> Result<Self, HeightmapError> {
        let expected = (grid.nx(), grid.ny());
        sampled("heightmap", expected, (heightmap.nx(), heightmap.ny()))?;
        if let Some(surface) = &surface {
            surface.samples_per_cell(grid)?;
        }
        Ok(Self {
            surface,
            ..Self::from_heightmap(heightmap)
        })
    }

    /// A scene known by its heightmap alone.
    pub fn from_heightmap(heightmap: Heightmap) -> Self {
        Self {
            heightmap,
            surface: None,
            content: None,
            leaving: None,
        }
    }

    /// The same scene, of which it is known what lies in the container.
    #[must_use]
    pub fn with_content(mut self, content: Content) -> Self {
        self.content = Some(content);
        self
    }

    /// The same scene, of which it is known at which stops what lies in it leaves.
    #[must_use]
    pub fn with_leaving(mut self, leaving: Leaving) -> Self {
        self.leaving = Some(leaving);
        self
    }

    #[must_use]
    pub(crate) fn with_heightmap(mut self, heightmap: Heightmap) -> Self {
        self.heightmap = heightmap;
        self
    }

    #[must_use]
    pub(crate) fn with_surface(mut self, surface: Surface) -> Self {
        self.surface = Some(surface);
        self
    }

    /// A scene from its fine surface: each cell takes its greatest sample, rounded up to a unit,
    /// and the inside surface at least.
    ///
    /// # Errors
    /// [`HeightmapError`] where the surface is not sampled as the grid's resolution asks.
    pub fn from_surface(grid: &Grid, surface: Surface) -> Result<Self, HeightmapError> {
        let samples = surface.samples_per_cell(grid)?;
        let mut heightmap = Heightmap::empty(grid);
        for (x, row) in surface.heights_m().chunks_exact(surface.ny()).enumerate() {
            for (y, cell) in row.chunks_exact(samples).enumerate() {
                let height_m = cell.iter().copied().fold(0.0_f32, f32::max);
                let height = grid.resolution().units_above(f64::from(height_m));
                heightmap.raise(x / samples, y, height);
            }
        }
        Ok(Self::from_heightmap(heightmap).with_surface(surface))
    }

    /// A scene as a camera with one pixel per cell sees it: each cell takes the sample at its
    /// middle, rounded. What stands between the middles is missed: an item may touch it.
    ///
    /// # Errors
    /// [`HeightmapError`] where the surface is not sampled as the grid's resolution asks.
    pub fn from_surface_at_middles(grid: &Grid, surface: Surface) -> Result<Self, HeightmapError> {
        let samples = surface.samples_per_cell(grid)?;
        let mut heightmap = Heightmap::empty(grid);
        let rows = surface.heights_m().chunks_exact(surface.ny());
        for (x, row) in rows.skip(samples / 2).step_by(samples).enumerate() {
            for (y, height_m) in row.iter().skip(samples / 2).step_by(samples).enumerate() {
                heightmap.raise(x, y, grid.resolution().units_nearest(f64::from(*height_m)));
            }
        }
        Ok(Self::from_heightmap(heightmap).with_surface(surface))
    }

    /// The container's heightmap.
    pub fn heightmap(&self) -> &Heightmap {
        &self.heightmap
    }

    /// The fine surface, where it is known.
    pub fn surface(&self) -> Option<&Surface> {
        self.surface.as_ref()
    }

    /// Gives the content of the container, where that is known.
    pub fn content(&self) -> Option<&Content> {
        self.content.as_ref()
    }

    /// At which stops what lies in the container leaves, where that matters.
    pub fn leaving(&self) -> Option<&Leaving> {
        self.leaving.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::grid::Units;

    #[test]
    fn a_scene_takes_the_greatest_sample_of_each_cell() {
        let grid = Grid::reference();
        let mut surface = Surface::empty(&grid);
        surface.raise(4 * 3 + 2, 4 * 5 + 3, 0.0101);
        let scene = Scene::from_surface(&grid, surface).unwrap();
        assert_eq!(scene.heightmap().get(3, 5), Some(6));
        assert_eq!(scene.heightmap().heights().iter().sum::<Units>(), 6);
    }

    #[test]
    fn a_camera_sees_the_middle_of_each_cell() {
        let grid = Grid::reference();
        let mut surface = Surface::empty(&grid);
        surface.raise(4 * 3 + 2, 4 * 5 + 2, 0.0109);
        surface.raise(4 * 8, 4 * 5, 0.2);
        let scene = Scene::from_surface_at_middles(&grid, surface).unwrap();
        assert_eq!(scene.heightmap().get(3, 5), Some(5));
        assert_eq!(scene.heightmap().get(8, 5), Some(0));
    }

    #[test]
    fn a_scene_is_made_of_maps_that_cover_its_grid() {
        let grid = Grid::reference();
        let surface = |nx, ny| Surface::from_metres(nx, ny, 0.0025, vec![0.0; nx * ny]).unwrap();
        let heightmap = Heightmap::empty(&grid);
        assert!(Scene::new(&grid, heightmap.clone(), Some(surface(128, 128))).is_ok());
        let turned = Heightmap::from_units(64, 16, vec![0; 1024]).unwrap();
        for (heightmap, surface) in [(turned, None), (heightmap, Some(surface(64, 256)))] {
            let refused = Scene::new(&grid, heightmap, surface).unwrap_err();
            assert!(refused.to_string().contains("where the grid needs"));
        }
    }
}
