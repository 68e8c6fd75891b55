//! Points that hang together, seen from above.

use nalgebra::{Point2, Point3};
use ppnpack_catalogue::mesh::Bounds;

/// Edge of a cell of the grid that points are joined on, in metres.
const CELL_M: f64 = 0.004;

/// Maximum number of cells along a side; larger regions have larger cells.
const MAX_CELLS: f64 = 1024.0;

/// A grid over the support, row-major. Points beyond it belong to the cells at its end.
pub(crate) struct Cells {
    pub(crate) origin: Point2<f64>,
    pub(crate) edge_m: f64,
    pub(crate) nx: usize,
    pub(crate) ny: usize,
}

impl Cells {
    /// Makes a grid over a box.
    pub(crate) fn over(bounds: &Bounds) -> Self {
        let extents = bounds.extents_m();
        let edge_m = CELL_M.max(extents.x.max(extents.y) / MAX_CELLS);
        let count = |extent: f64| (extent / edge_m).floor() as usize + 1;
        Self {
            origin: bounds.lowest.xy(),
            edge_m,
            nx: count(extents.x),
            ny: count(extents.y),
        }
    }

    /// Says of each cell whether it holds points.
    pub(crate) fn covered(&self, points: &[Point3<f64>]) -> Vec<bool> {
        let mut is_covered = vec![false; self.nx * self.ny];
        for point in points {
            if let Some(cell) = is_covered.get_mut(self.at(point)) {
                *cell = true;
            }
        }
        is_covered
    }

    /// Gives the cell of a point, none of whose coordinates is less than the origin's.
    pub(crate) fn at(&self, point: &Point3<f64>) -> usize {
        let offset = (point.xy() - self.origin) / self.edge_m;
        let (x, y) = (offset.x as usize, offset.y as usize);
        x.min(self.nx - 1) * self.ny + y.min(self.ny - 1)
    }

    /// Gives the cells within a distance in cells.
    fn around(&self, cell: usize, reach: usize) -> impl Iterator<Item = usize> + '_ {
        let (x, y) = (cell / self.ny, cell % self.ny);
        let xs = x.saturating_sub(reach)..(x + reach + 1).min(self.nx);
        xs.flat_map(move |x| {
            (y.saturating_sub(reach)..(y + reach + 1).min(self.ny)).map(move |y| x * self.ny + y)
        })
    }
}

/// Stands for a cell of no group.
const NO_GROUP: u32 = u32::MAX;

/// Groups points: seen from above, no gap within a group is wider than `join_m`.
pub(crate) fn joined(points: Vec<Point3<f64>>, join_m: f64) -> Vec<Vec<Point3<f64>>> {
    let Some(bounds) = Bounds::of(&points) else {
        return Vec::new();
    };
    let cells = Cells::over(&bounds);
    let is_covered = cells.covered(&points);
    let reach = (join_m / cells.edge_m).floor().clamp(1.0, 16.0) as usize;
    let (group_of, count) = labels(&cells, &is_covered, reach);
    let mut groups = vec![Vec::new(); count];
    for point in points {
        let group = group_of.get(cells.at(&point)).map(|group| *group as usize);
        if let Some(group) = group.and_then(|group| groups.get_mut(group)) {
            group.push(point);
        }
    }
    groups
}

/// Gives the group of each covered cell, and the number of groups.
fn labels(cells: &Cells, is_covered: &[bool], reach: usize) -> (Vec<u32>, usize) {
    let mut group_of = vec![NO_GROUP; is_covered.len()];
    let mut next_group = 0;
    let mut take = |cell: usize, group: u32| match (is_covered.get(cell), group_of.get_mut(cell)) {
        (Some(true), Some(own)) if *own == NO_GROUP => {
            *own = group;
            true
        }
        _ => false,
    };
    let mut queue = Vec::new();
    for start in 0..is_covered.len() {
        queue.extend(take(start, next_group).then_some(start));
        let is_new = !queue.is_empty();
        while let Some(cell) = queue.pop() {
            queue.extend(
                cells
                    .around(cell, reach)
                    .filter(|other| take(*other, next_group)),
            );
        }
        next_group += u32::from(is_new);
    }
    (group_of, next_group as usize)
}
