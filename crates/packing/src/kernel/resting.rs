//! Resting heights of all placements of an item, kept from step to step.

use std::time::Instant;

use pulp::{Arch, Simd, WithSimd};

use crate::kernel::clock::Clock;
use crate::kernel::grid::{Grid, Units};
use crate::kernel::heightmap::Heightmap;
use crate::kernel::item::{Item, ItemView, ShapeId};
use crate::kernel::lanes::{LANES, PaddedMap, resting_heights};

/// Shapes kept beyond those of the current buffer: the ones it held just before.
const SPARE_SHAPES: usize = 4;

/// The resting height of every placement of one view; row-major, rows padded to whole blocks.
#[derive(Debug, Clone)]
pub struct RestingMap {
    nx: usize,
    ny: usize,
    stride: usize,
    heights: Vec<Units>,
    /// The version of the container that the heights belong to.
    version: u64,
}

impl RestingMap {
    fn sized_for(grid: &Grid) -> Self {
        let heights = Vec::with_capacity(grid.nx() * grid.ny().next_multiple_of(LANES));
        Self {
            nx: 0,
            ny: 0,
            stride: 0,
            heights,
            version: 0,
        }
    }

    fn reset(&mut self, container: &PaddedMap, view: &ItemView) {
        (self.nx, self.ny) = view.corners(container.size());
        self.stride = self.ny.next_multiple_of(LANES);
        self.heights.clear();
        self.heights.resize(self.nx * self.stride, 0);
    }

    /// How many placements there are; 0 where the view is larger than the container.
    pub(crate) fn count(&self) -> u64 {
        (self.nx * self.ny) as u64
    }

    /// Per x: the resting heights along y, in units.
    #[inline(always)]
    pub fn rows(&self) -> impl Iterator<Item = &[Units]> {
        let rows = self.heights.chunks_exact(self.stride.max(1));
        rows.map(|row| row.get(..self.ny).unwrap_or(&[]))
    }
}

/// The cells in which two versions of a container differ lie within this rectangle.
#[derive(Debug, Clone, Copy)]
struct Change {
    x: (usize, usize),
    y: (usize, usize),
}

#[derive(Debug, Clone)]
struct ShapeMaps {
    shape: ShapeId,
    last_used: u64,
    views: Vec<RestingMap>,
}

/// Computes the resting heights of the buffer's items, anew only where a change affects them.
///
/// A placed item changes a small part of the container: only placements whose footprint meets the
/// changed rectangle are computed again. Exact, as heights depend on cells below alone.
#[derive(Debug, Clone)]
pub struct RestingHeights {
    grid: Grid,
    arch: Arch,
    pub(crate) container: PaddedMap,
    version: u64,
    change: Option<Change>,
    uses: u64,
    capacity: usize,
    shapes: Vec<ShapeMaps>,
}

impl RestingHeights {
    /// For containers of this grid.
    pub fn new(grid: &Grid) -> Self {
        Self {
            grid: grid.clone(),
            arch: Arch::new(),
            container: PaddedMap::new(grid.nx(), grid.ny()),
            version: 0,
            change: None,
            uses: 0,
            capacity: SPARE_SHAPES,
            shapes: Vec::new(),
        }
    }

    /// Takes over the container's content and the items of the buffer, whose maps are kept like
    /// those of the few used just before. Returns whether the content differs from the last.
    pub fn update<'a>(
        &mut self,
        heightmap: &Heightmap,
        buffer: impl Iterator<Item = &'a Item>,
    ) -> bool {
        self.keep(buffer);
        let mut change: Option<Change> = None;
        for x in 0..heightmap.nx() {
            let (row, heights) = (self.container.row_mut(x), heightmap.row(x));
            if row == heights {
                continue;
            }
            let mut differing = row
                .iter()
                .zip(heights)
                .enumerate()
                .filter(|(_, (a, b))| a != b);
            let Some((first, _)) = differing.next() else {
                continue;
            };
            let last = differing.next_back().map_or(first, |(y, _)| y);
            row.copy_from_slice(heights);
            let change = change.get_or_insert(Change {
                x: (x, x),
                y: (first, last),
            });
            change.x.1 = x;
            change.y = (change.y.0.min(first), change.y.1.max(last));
        }
        if change.is_some() {
            self.version += 1;
            self.change = change;
        }
        change.is_some()
    }

    fn keep<'a>(&mut self, buffer: impl Iterator<Item = &'a Item>) {
        self.uses += 1;
        self.capacity = SPARE_SHAPES;
        for item in buffer {
            self.capacity += 1;
            let mut shapes = self.shapes.iter_mut();
            if let Some(maps) = shapes.find(|maps| maps.shape == item.shape()) {
                maps.last_used = self.uses;
            }
        }
    }

    /// The resting heights of an item, one map per yaw.
    pub fn of(&mut self, item: &Item) -> impl Iterator<Item = &RestingMap> {
        self.prepare(item, None);
        self.views(item.shape()).iter()
    }

    /// The resting height of one placement of a view by its first cell; `None` outside.
    pub fn at(&self, view: &ItemView, x: usize, y: usize) -> Option<Units> {
        let (placed_x, placed_y) = view.corners(self.container.size());
        if x >= placed_x || y >= placed_y {
            return None;
        }
        let gap = |(dx, dy, bottom, _): (usize, usize, Units, Units)| {
            let height = self.container.row(x + dx).get(y + dy)?;
            Some(height - bottom)
        };
        Some(view.cells().filter_map(gap).fold(0, Units::max))
    }

    /// The maps of a prepared shape, one per yaw.
    pub(crate) fn views(&self, shape: ShapeId) -> &[RestingMap] {
        let mut shapes = self.shapes.iter();
        let maps = shapes.find(|maps| maps.shape == shape);
        maps.map_or(&[], |maps| &maps.views)
    }

    /// Gives the item's shape a slot: its own, a new one, or that of the shape longest unused.
    fn admit(&mut self, item: &Item) {
        if self.shapes.iter().any(|maps| maps.shape == item.shape()) {
            return;
        }
        if self.shapes.len() < self.capacity {
            self.shapes.push(ShapeMaps {
                shape: item.shape(),
                last_used: 0,
                views: Vec::new(),
            });
        }
        // There are more slots than items in the buffer, so the shape longest unused is not in it.
        if let Some(maps) = self.shapes.iter_mut().min_by_key(|maps| maps.last_used) {
            maps.shape = item.shape();
            maps.last_used = self.uses;
            maps.views
                .resize_with(item.views().len(), || RestingMap::sized_for(&self.grid));
            maps.views.iter_mut().for_each(|map| map.version = 0);
        }
    }

    pub(crate) fn held_bytes(&self) -> usize {
        let maps = self.shapes.iter().flat_map(|shape| &shape.views);
        maps.map(|map| map.heights.capacity() * size_of::<Units>())
            .sum()
    }

    /// Makes the maps of an item's views current. Those that are not when the time is over are of no
    /// use until they are made anew.
    pub(crate) fn prepare(&mut self, item: &Item, deadline: Option<Instant>) {
        self.admit(item);
        let Self {
            arch,
            container,
            version,
            change,
            ..
        } = self;
        let mut shapes = self.shapes.iter_mut();
        let Some(maps) = shapes.find(|maps| maps.shape == item.shape()) else {
            return;
        };
        let refresh = |(map, view): (&mut RestingMap, &ItemView)| {
            let change = change.filter(|_| map.version > 0 && map.version + 1 == *version);
            if map.version == *version && *version > 0 {
                return;
            }
            if change.is_none() {
                map.reset(container, view);
            }
            let is_filled = arch.dispatch(Fill {
                container,
                view,
                map,
                change,
                clock: Clock::new(deadline),
            });
            map.version = if is_filled { *version } else { 0 };
        };
        let (maps, views) = (&mut maps.views, item.views());
        maps.iter_mut().zip(views).for_each(refresh);
    }
}

/// Computes a view's resting heights, all or those that a change of the container may affect.
struct Fill<'a> {
    container: &'a PaddedMap,
    view: &'a ItemView,
    map: &'a mut RestingMap,
    change: Option<Change>,
    clock: Clock,
}

impl WithSimd for Fill<'_> {
    /// Whether there was time for all.
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> bool {
        let Self {
            container,
            view,
            map,
            change,
            mut clock,
        } = self;
        let affected = |change: (usize, usize), footprint: usize, placements: usize| {
            let first = (change.0 + 1).saturating_sub(footprint);
            first.min(placements)..(change.1 + 1).min(placements)
        };
        let (rows, columns) = match change {
            None => (0..map.nx, 0..map.ny),
            Some(change) => (
                affected(change.x, view.nx(), map.nx),
                affected(change.y, view.ny(), map.ny),
            ),
        };
        let blocks = columns.start / LANES..columns.end.div_ceil(LANES);
        let footprint = view.nx() * view.ny();
        for x in rows {
            if clock.is_over_before(blocks.len() * footprint) {
                return false;
            }
            let row = x * map.stride;
            for block in blocks.clone() {
                let start = block * LANES;
                let base = container.index(x, start);
                let heights = resting_heights(container, base, view);
                if let Some(out) = map.heights.get_mut(row + start..row + start + LANES) {
                    out.copy_from_slice(&heights);
                }
            }
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::item::ViewSurfaces;

    #[test]
    fn maps_hold_the_greatest_height_below_the_footprint() {
        let grid = Grid::reference();
        let view = ViewSurfaces::of_cells(2, 1, vec![5, 5], vec![0, 3]);
        let yaws = grid.resolution().yaws().count();
        let item = Item::new("step", vec![view; yaws], 0.0).unwrap();
        let mut heightmap = Heightmap::empty(&grid);
        heightmap.raise(7, 9, 10);
        let mut resting = RestingHeights::new(&grid);
        resting.update(&heightmap, std::iter::once(&item));
        let maps: Vec<_> = resting.of(&item).cloned().collect();
        assert_eq!(maps.len(), yaws);
        assert_eq!((maps[0].nx, maps[0].ny), (31, 32));
        let rows: Vec<_> = maps[0].rows().collect();
        assert_eq!((rows[7][9], rows[6][9], rows[8][9]), (10, 7, 0));
        let at = |x, y| resting.at(&item.views()[0], x, y);
        assert_eq!((at(7, 9), at(6, 9), at(8, 9)), (Some(10), Some(7), Some(0)));
        assert_eq!((at(31, 0), at(0, 32)), (None, None));
    }
}
