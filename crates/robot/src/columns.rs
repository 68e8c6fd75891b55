//! The container's content as solid columns, and the distance to them.
//!
//! The heightmap is kept as a pyramid of maxima: a node of a level covers two by two of the level
//! below and is as high as the highest of them. The distance to all columns is found by branch and
//! bound: a node that is further away than the nearest column found so far is left out with
//! everything below it.

use nalgebra::Point3;
use ppnpack_packing::kernel::grid::{Grid, Units};
use ppnpack_packing::kernel::heightmap::Heightmap;
use ppnpack_packing::kernel::item::ItemView;
use ppnpack_packing::kernel::placement::RestingPlacement;

use crate::shapes::{AxisBox, Capsule, UprightCylinder};

/// Columns reach down to here, in metres: nothing comes from below the floor.
const BOTTOM_M: f64 = -1.0;

/// Solid columns from below the floor to the heights of a heightmap.
#[derive(Debug, Clone, Default)]
pub(crate) struct Columns {
    cell_m: f64,
    unit_m: f64,
    /// The finest level first.
    levels: Vec<Level>,
}

#[derive(Debug, Clone, Default)]
struct Level {
    nx: usize,
    ny: usize,
    heights: Vec<Units>,
}

impl Level {
    fn get(&self, x: usize, y: usize) -> Option<Units> {
        let is_inside = x < self.nx && y < self.ny;
        self.heights
            .get(x * self.ny + y)
            .copied()
            .filter(|_| is_inside)
    }

    /// Raises a node; says whether it was lower.
    fn raise(&mut self, x: usize, y: usize, height: Units) -> bool {
        match self.heights.get_mut(x * self.ny + y) {
            Some(held) if y < self.ny && *held < height => {
                *held = height;
                true
            }
            _ => false,
        }
    }

    /// Gives the highest of the nodes that a node one level up covers.
    fn pooled(&self, x: usize, y: usize) -> Units {
        let children = [(0, 0), (0, 1), (1, 0), (1, 1)];
        let heights = children.map(|(dx, dy)| self.get(2 * x + dx, 2 * y + dy));
        heights.into_iter().flatten().max().unwrap_or(0)
    }
}

impl Columns {
    /// Takes over a heightmap; quick where it is the same as before.
    pub(crate) fn update(&mut self, grid: &Grid, heightmap: &Heightmap) {
        let resolution = grid.resolution();
        let (nx, ny) = (heightmap.nx(), heightmap.ny());
        let is_same = self.levels.first().is_some_and(|level| {
            (level.nx, level.ny) == (nx, ny)
                && level.heights == heightmap.heights()
                && self.cell_m == resolution.cell_m()
                && self.unit_m == resolution.height_unit_m()
        });
        if is_same {
            return;
        }
        self.cell_m = resolution.cell_m();
        self.unit_m = resolution.height_unit_m();
        self.levels.clear();
        let heights = heightmap.heights().to_vec();
        let mut level = Level { nx, ny, heights };
        while level.nx > 1 || level.ny > 1 {
            let (nx, ny) = (level.nx.div_ceil(2), level.ny.div_ceil(2));
            let nodes = (0..nx).flat_map(|x| (0..ny).map(move |y| (x, y)));
            let heights = nodes.map(|(x, y)| level.pooled(x, y)).collect();
            let above = Level { nx, ny, heights };
            self.levels.push(std::mem::replace(&mut level, above));
        }
        self.levels.push(level);
    }

    /// Becomes the same as others, with an item at rest on top.
    pub(crate) fn set_with_item(
        &mut self,
        others: &Self,
        view: &ItemView,
        resting: &RestingPlacement,
    ) {
        self.clone_from(others);
        for (x, y, _, top) in covered(view, resting) {
            for (depth, level) in self.levels.iter_mut().enumerate() {
                if !level.raise(x >> depth, y >> depth, top) {
                    break;
                }
            }
        }
    }

    /// Says whether an item's placement lies within the container and does not reach into the
    /// columns.
    pub(crate) fn is_free_for(&self, view: &ItemView, resting: &RestingPlacement) -> bool {
        self.levels.first().is_some_and(|finest| {
            covered(view, resting).all(|(x, y, bottom, _)| {
                let height = finest.get(x, y);
                height.is_some_and(|height| height <= bottom)
            })
        })
    }

    /// Gives the greatest height, in metres.
    pub(crate) fn highest_m(&self) -> f64 {
        let top = self.levels.last().and_then(|level| level.get(0, 0));
        f64::from(top.unwrap_or(0)) * self.unit_m
    }

    /// Bounds a capsule's distance to all columns from below, in metres, tight to some micrometres;
    /// `limit_m` where it is more.
    pub(crate) fn distance_m(&self, capsule: &Capsule, limit_m: f64) -> f64 {
        let around = capsule.axis_box();
        let mut nearest_m = limit_m;
        self.search(self.levels.len(), 0, 0, &mut nearest_m, &|node| {
            let bound_m = around.distance_to_box_m(node) - capsule.radius_m;
            let is_far = bound_m >= limit_m;
            if is_far {
                bound_m
            } else {
                capsule.distance_m(node)
            }
        });
        nearest_m
    }

    /// Measures an upright cylinder's distance to all columns, in metres; `limit_m` where it is
    /// more, 0 where they overlap.
    pub(crate) fn distance_to_cylinder_m(&self, cylinder: &UprightCylinder, limit_m: f64) -> f64 {
        let mut nearest_m = limit_m;
        self.search(self.levels.len(), 0, 0, &mut nearest_m, &|node| {
            node.distance_to_cylinder_m(cylinder)
        });
        nearest_m
    }

    /// Searches the nodes of a level, counted from above 1, below which a node `(x, y)` lies.
    fn search(
        &self,
        above: usize,
        x: usize,
        y: usize,
        nearest_m: &mut f64,
        distance_m: &impl Fn(&AxisBox) -> f64,
    ) {
        let Some(depth) = above.checked_sub(1) else {
            return;
        };
        let Some(height) = self.levels.get(depth).and_then(|level| level.get(x, y)) else {
            return;
        };
        let edge_m = self.cell_m * (1_u64 << depth) as f64;
        let corner =
            |x: usize, y: usize, z_m| Point3::new(x as f64 * edge_m, y as f64 * edge_m, z_m);
        let node = AxisBox {
            lowest: corner(x, y, BOTTOM_M),
            highest: corner(x + 1, y + 1, f64::from(height) * self.unit_m),
        };
        let found_m = distance_m(&node);
        if found_m >= *nearest_m {
            return;
        }
        if depth == 0 {
            *nearest_m = found_m;
            return;
        }
        for (dx, dy) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            self.search(depth, 2 * x + dx, 2 * y + dy, nearest_m, distance_m);
        }
    }
}

/// Gives the cells that a placed item covers, each with the item's lower and upper end there.
fn covered<'a>(
    view: &'a ItemView,
    resting: &RestingPlacement,
) -> impl Iterator<Item = (usize, usize, Units, Units)> + use<'a> {
    let RestingPlacement {
        placement,
        resting_height,
    } = *resting;
    view.cells().map(move |(x, y, bottom, top)| {
        let above = |height: Units| resting_height.saturating_add(height);
        (placement.x + x, placement.y + y, above(bottom), above(top))
    })
}

#[cfg(test)]
mod tests {
    use nalgebra::Point2;
    use ppnpack_packing::kernel::grid::{ABSENT, ContainerSize, Resolution, Yaws};
    use ppnpack_packing::kernel::item::{Item, ViewSurfaces};
    use ppnpack_packing::kernel::placement::Placement;
    use proptest::prelude::*;

    use super::*;

    /// A grid of 7 x 5 cells of 2 cm.
    fn grid() -> Grid {
        let size = ContainerSize::cuboid(0.14, 0.10, 0.2);
        let resolution = Resolution::new(0.02, 0.002, Yaws::half_turn(1).unwrap());
        Grid::new(size, resolution.unwrap()).unwrap()
    }

    fn column(x: usize, y: usize, height: Units) -> AxisBox {
        let at = |index: usize| index as f64 * 0.02;
        AxisBox {
            lowest: Point3::new(at(x), at(y), BOTTOM_M),
            highest: Point3::new(at(x + 1), at(y + 1), f64::from(height) * 0.002),
        }
    }

    fn point() -> impl Strategy<Value = Point3<f64>> {
        (-0.1..0.25, -0.1..0.2, 0.0..0.3).prop_map(|(x, y, z)| Point3::new(x, y, z))
    }

    proptest! {
        #[test]
        fn the_pyramid_finds_the_nearest_of_all_columns(
            heights in prop::collection::vec(0_i16..100, 35),
            from in point(),
            to in point(),
            radius_m in 0.001..0.05,
            (x, y, resting_height) in (0_usize..6, 0_usize..4, 0_i16..80),
        ) {
            let grid = grid();
            let heightmap = Heightmap::from_units(7, 5, heights.clone()).unwrap();
            let mut columns = Columns::default();
            columns.update(&grid, &heightmap);
            let view = ViewSurfaces::of_cells(2, 2, vec![20, 0, 5, 7], vec![0, ABSENT, 1, 2]);
            let item = Item::new("item", vec![view], 0.0).unwrap();
            let view = &item.views()[0];
            let placement = Placement { yaw: 0, x, y };
            let resting = RestingPlacement { placement, resting_height };
            let mut with_item = Columns::default();
            with_item.set_with_item(&columns, view, &resting);

            let mut raised = heights.clone();
            for (index, top) in [(x * 5 + y, 20), ((x + 1) * 5 + y, 5), ((x + 1) * 5 + y + 1, 7)] {
                raised[index] = raised[index].max(resting_height + top);
            }
            let capsule = Capsule { from, to, radius_m };
            let cylinder = UprightCylinder {
                axis_m: Point2::new(from.x, from.y),
                radius_m,
                lowest_m: from.z,
                highest_m: from.z + 0.1,
            };
            for (columns, heights) in [(&columns, &heights), (&with_item, &raised)] {
                let boxes = heights.iter().enumerate().map(|(at, height)| column(at / 5, at % 5, *height));
                let boxes: Vec<_> = boxes.collect();
                let nearest = boxes.iter().map(|solid| capsule.distance_m(solid));
                let nearest = nearest.fold(0.1, f64::min);
                let found = columns.distance_m(&capsule, 0.1);
                prop_assert!((found - nearest).abs() < 1e-4, "{found} {nearest}");
                let nearest = boxes.iter().map(|solid| solid.distance_to_cylinder_m(&cylinder));
                let nearest = nearest.fold(0.1, f64::min);
                prop_assert_eq!(columns.distance_to_cylinder_m(&cylinder, 0.1), nearest);
            }
            let free = [(0, 0, 0), (1, 0, 1), (1, 1, 2)];
            let free = free.iter().all(|(dx, dy, bottom)| {
                heights[(x + dx) * 5 + y + dy] <= resting_height + bottom
            });
            prop_assert_eq!(columns.is_free_for(view, &resting), free);
        }
    }
}
