//! In which order items leave a container: what leaves earlier never lies below what leaves later.

use std::sync::Arc;

use crate::kernel::grid::Grid;
use crate::kernel::item::ItemView;
use crate::kernel::placement::RestingPlacement;
use crate::scene::blocked::BlockedRegion;

/// At which stop an item leaves its container: those of small numbers are earlier. What is said to
/// leave at none leaves after all others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Stop(u32);

impl Stop {
    /// After all stops.
    pub const LAST: Self = Self(u32::MAX);

    /// The stop of this number; that after all others where there is none.
    pub fn new(number: Option<u32>) -> Self {
        number.map_or(Self::LAST, Self)
    }

    /// Its number; `None` of that after all others.
    pub fn number(self) -> Option<u32> {
        (self != Self::LAST).then_some(self.0)
    }

    /// Names it, for people.
    pub(crate) fn said(self) -> String {
        match self {
            Self::LAST => "no stop".to_owned(),
            Self(number) => format!("stop {number}"),
        }
    }
}

impl Default for Stop {
    fn default() -> Self {
        Self::LAST
    }
}

/// Per cell of a container: the earliest stop of the items above it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Leaving {
    ny: usize,
    first: Arc<[Stop]>,
    pub(crate) earliest: Stop,
}

impl Leaving {
    /// Makes the stops of an empty container.
    pub fn empty(grid: &Grid) -> Self {
        Self {
            ny: grid.ny(),
            first: std::iter::repeat_n(Stop::LAST, grid.nx() * grid.ny()).collect(),
            earliest: Stop::LAST,
        }
    }

    /// Takes the stop of each cell, row-major; `None` where the count is not the grid's.
    pub fn from_stops(grid: &Grid, first: &[Stop]) -> Option<Self> {
        (first.len() == grid.nx() * grid.ny()).then(|| Self {
            ny: grid.ny(),
            first: first.into(),
            earliest: first.iter().copied().min().unwrap_or_default(),
        })
    }

    /// The stop of each cell, in the order of a heightmap's heights.
    pub fn stops(&self) -> &[Stop] {
        &self.first
    }

    /// An item lies where it was placed, and leaves at a stop.
    pub fn place(&mut self, view: &ItemView, at: &RestingPlacement, stop: Stop) {
        let cells: Vec<usize> = cells(view, at, self.ny).collect();
        self.note(cells, stop);
    }

    /// Something lies above a region of the floor, and leaves at a stop.
    pub fn cover(&mut self, grid: &Grid, region: &BlockedRegion, stop: Stop) {
        let ny = self.ny;
        let cells = region.cells_of(grid);
        self.note(cells.map(|(x, y)| x * ny + y).collect(), stop);
    }

    fn note(&mut self, cells: Vec<usize>, stop: Stop) {
        let mut first = self.first.to_vec();
        for cell in cells {
            if let Some(known) = first.get_mut(cell) {
                *known = stop.min(*known);
            }
        }
        self.first = first.into();
        self.earliest = self.earliest.min(stop);
    }

    /// The earliest stop of what lies below an item that is placed so.
    pub(crate) fn below(&self, view: &ItemView, at: &RestingPlacement) -> Stop {
        let stops = cells(view, at, self.ny).filter_map(|cell| self.first.get(cell));
        stops.min().copied().unwrap_or_default()
    }
}

fn cells(view: &ItemView, at: &RestingPlacement, ny: usize) -> impl Iterator<Item = usize> {
    let (first_x, first_y) = (at.placement.x, at.placement.y);
    let cells = view.cells();
    cells.map(move |(x, y, _, _)| (first_x + x) * ny + first_y + y)
}
