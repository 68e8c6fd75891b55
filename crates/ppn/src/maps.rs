//! The network's inputs: heightmaps in physical units on padded canvases.

use ppnpack_packing::kernel::grid::{ABSENT, Grid, Units};
use ppnpack_packing::kernel::item::{Item, ItemView};
use ppnpack_packing::kernel::resting::RestingMap;

use crate::network::{CONTAINER_CHANNELS, RESTING_CHANNELS, VIEW_CHANNELS};
use crate::symmetry::{Cells, Symmetry};

/// Scale of the network's heights: decimetres, of the order of 1 for household objects.
const DECIMETRES_PER_METRE: f64 = 10.0;
/// Maximum of the resting height above the item's lowest, in decimetres: further up it does not
/// matter.
const GREATEST_ABOVE_LOWEST: f32 = 0.5;

/// The layout of a grid's maps for the network.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Layout {
    /// The container's cells, as the symmetry shows them.
    pub(crate) container: Cells,
    /// The container's cells, each side padded to a multiple of the network's stride.
    pub(crate) padded: Cells,
    original: Cells,
    unit_dm: f32,
    symmetry: Symmetry,
}

impl Layout {
    pub(crate) fn new(grid: &Grid, stride: usize, symmetry: Symmetry) -> Self {
        let (nx, ny) = (grid.nx(), grid.ny());
        let original = Cells { nx, ny };
        let container = symmetry.size(original);
        Self {
            container,
            padded: Cells {
                nx: container.nx.next_multiple_of(stride),
                ny: container.ny.next_multiple_of(stride),
            },
            original,
            unit_dm: (grid.resolution().height_unit_m() * DECIMETRES_PER_METRE) as f32,
            symmetry,
        }
    }

    /// Counts the cells of a padded map.
    pub(crate) fn cells(&self) -> usize {
        self.padded.nx * self.padded.ny
    }

    fn metric(&self, height: Units) -> f32 {
        f32::from(height) * self.unit_dm
    }

    /// Writes the container's channels, `[CONTAINER_CHANNELS, X, Y]`, over zeros.
    pub(crate) fn write_container(&self, heights: &[Units], out: &mut [f32]) {
        debug_assert_eq!(out.len(), CONTAINER_CHANNELS as usize * self.cells());
        let (metric, inside) = out.split_at_mut(self.cells());
        for (index, height) in heights.iter().enumerate() {
            let cell = (index / self.original.ny, index % self.original.ny);
            let (x, y) = self.symmetry.cell(cell, self.original);
            let at = x * self.padded.ny + y;
            if let (Some(metric), Some(inside)) = (metric.get_mut(at), inside.get_mut(at)) {
                *metric = self.metric(*height);
                *inside = 1.0;
            }
        }
    }

    /// Gives the channels of views, `[views, VIEW_CHANNELS, side, side]`, and the side of the
    /// canvas that holds all that the network has a place for; those of others are zeros.
    ///
    /// The side is a multiple of twice the stride: the footprint's centre is between the same cells
    /// at any resolution.
    pub(crate) fn write_views(&self, views: &[&ItemView], stride: usize) -> (Vec<f32>, usize) {
        let admitted = views.iter().filter(|view| self.admits(view));
        let longest = admitted.map(|view| view.nx().max(view.ny())).max();
        let side = longest.unwrap_or(1).next_multiple_of(2 * stride);
        let size = VIEW_CHANNELS as usize * side * side;
        let mut out = vec![0.0; views.len() * size];
        for (view, out) in views.iter().zip(out.chunks_exact_mut(size)) {
            if self.admits(view) {
                self.write_view(view, side, out);
            }
        }
        (out, side)
    }

    /// Writes a view's channels, `[VIEW_CHANNELS, side, side]`, over zeros; the footprint's centre
    /// is at `side / 2`.
    fn write_view(&self, view: &ItemView, side: usize, out: &mut [f32]) {
        debug_assert_eq!(out.len(), VIEW_CHANNELS as usize * side * side);
        let footprint = footprint(view);
        let image = self.symmetry.size(footprint);
        let (Some(left), Some(above)) = (
            (side / 2).checked_sub(image.nx / 2),
            (side / 2).checked_sub(image.ny / 2),
        ) else {
            return;
        };
        let (top_map, rest) = out.split_at_mut(side * side);
        let (bottom_map, material) = rest.split_at_mut(side * side);
        for (index, (top, bottom)) in view.top().iter().zip(view.bottom()).enumerate() {
            if *bottom == ABSENT {
                continue;
            }
            let cell = (index / footprint.ny, index % footprint.ny);
            let (x, y) = self.symmetry.cell(cell, footprint);
            let at = (left + x) * side + above + y;
            for (map, value) in [
                (&mut *top_map, self.metric(*top)),
                (&mut *bottom_map, self.metric(*bottom)),
                (&mut *material, 1.0),
            ] {
                if let Some(entry) = map.get_mut(at) {
                    *entry = value;
                }
            }
        }
    }

    /// Gives the cell that stands for a placement: where the footprint's centre lies.
    ///
    /// The index is by phase: the cells with even x and even y first, then those with odd y, then
    /// odd x, then both.
    pub(crate) fn cell_of(&self, corner: (usize, usize), view: &ItemView) -> usize {
        let footprint = footprint(view);
        let (x, y) = self.symmetry.corner(corner, footprint, self.original);
        let image = self.symmetry.size(footprint);
        self.index(x + image.nx / 2, y + image.ny / 2)
    }

    /// Gives the index of a cell of the padded map, by phase.
    fn index(&self, x: usize, y: usize) -> usize {
        let phase = 2 * (x % 2) + y % 2;
        (phase * self.padded.nx / 2 + x / 2) * (self.padded.ny / 2) + y / 2
    }

    /// Gives the cell of the padded map that has an index; the inverse of [`Self::index`].
    pub(crate) fn position_of(&self, index: usize) -> (usize, usize) {
        let (half_x, half_y) = (self.padded.nx / 2, self.padded.ny / 2);
        let (phase, at) = (index / (half_x * half_y), index % (half_x * half_y));
        let x = 2 * (at / half_y) + phase / 2;
        let y = 2 * (at % half_y) + phase % 2;
        (x, y)
    }

    /// Says per cell, indexed as by [`Self::cell_of`], whether it is one of the container's and no
    /// padding.
    pub(crate) fn inside(&self) -> Vec<bool> {
        let Cells { nx, ny } = self.container;
        let places = (0..self.cells()).map(|index| self.position_of(index));
        places.map(|(x, y)| x < nx && y < ny).collect()
    }

    /// Gives the placement that a cell stands for, where there is one; the inverse of
    /// [`Self::cell_of`] without a symmetry.
    pub(crate) fn corner_of(&self, cell: usize, view: &ItemView) -> Option<(usize, usize)> {
        let (x, y) = self.position_of(cell);
        let corner = (x.checked_sub(view.nx() / 2)?, y.checked_sub(view.ny() / 2)?);
        let is_inside =
            corner.0 + view.nx() <= self.original.nx && corner.1 + view.ny() <= self.original.ny;
        is_inside.then_some(corner)
    }

    /// Says whether the network has a place for a view at all.
    pub(crate) fn admits(&self, view: &ItemView) -> bool {
        view.nx() <= self.original.nx && view.ny() <= self.original.ny
    }

    /// Writes, for a view, the resting channels `[RESTING_CHANNELS, X, Y]` over zeros, and into
    /// `fits` (`[X, Y]`, over `false`) where it stays at or below the rim. `lowest` is the item's
    /// lowest resting height over all yaws.
    pub(crate) fn write_resting(
        &self,
        view: &ItemView,
        heights: &RestingMap,
        limit: Units,
        lowest: Units,
        out: &mut [f32],
        fits: &mut [bool],
    ) {
        debug_assert_eq!(out.len(), RESTING_CHANNELS as usize * self.cells());
        let (metric, above_lowest) = out.split_at_mut(self.cells());
        for (x, row) in heights.rows().enumerate() {
            // Neighbours are in two phases in turn; within one, they lie a fixed distance apart.
            let phases = [0, 1].map(|y| {
                let (first, next) = (self.cell_of((x, y), view), self.cell_of((x, y + 2), view));
                (first as isize, next as isize - first as isize)
            });
            let cells = (0..).flat_map(|pair| phases.map(|(first, step)| first + pair * step));
            for (height, at) in row.iter().zip(cells) {
                let at = at as usize;
                let (Some(metric), Some(above), Some(fits)) = (
                    metric.get_mut(at),
                    above_lowest.get_mut(at),
                    fits.get_mut(at),
                ) else {
                    continue;
                };
                *metric = self.metric(*height);
                let above_dm = self.metric(height - lowest);
                *above = above_dm.clamp(0.0, GREATEST_ABOVE_LOWEST) * 10.0;
                *fits = *height <= limit;
            }
        }
    }
}

fn footprint(view: &ItemView) -> Cells {
    Cells {
        nx: view.nx(),
        ny: view.ny(),
    }
}

/// Gives the greatest resting height at which a view stays at or below the rim; negative where it
/// is taller.
pub(crate) fn limit(grid: &Grid, view: &ItemView) -> Units {
    grid.rim() - view.height()
}

/// Gives the lowest resting height of an item that fits below the rim, over all yaws; 0 where none
/// does.
pub(crate) fn lowest<'a>(
    grid: &Grid,
    item: &Item,
    maps: impl Iterator<Item = &'a RestingMap>,
) -> Units {
    let fitting = maps.zip(item.views()).flat_map(|(map, view)| {
        let limit = limit(grid, view);
        let heights = map.rows().flatten().copied().min();
        heights.filter(|height| *height <= limit)
    });
    fitting.min().unwrap_or(0)
}
