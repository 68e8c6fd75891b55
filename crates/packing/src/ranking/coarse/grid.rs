//! A coarser grid over the same container.

use serde::{Deserialize, Serialize};

use crate::kernel::grid::{Grid, GridError, Resolution};
use crate::kernel::item::ItemView;
use crate::kernel::placement::Placement;

/// How many times coarser a grid is: 1 and more.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Coarsening {
    /// Fine cells along a side of a coarse one.
    pub cells: usize,
    /// Every how many-th yaw the coarse grid has.
    pub yaws: usize,
}

impl Coarsening {
    /// The coarsening that brings a grid nearest to cells of `cell_m` and, at most, `yaws` yaws.
    pub fn towards(grid: &Grid, cell_m: f64, yaws: usize) -> Self {
        let resolution = grid.resolution();
        let cells = (cell_m / resolution.cell_m()).round().max(1.0);
        Self {
            cells: cells as usize,
            yaws: resolution.yaws().count().div_ceil(yaws.max(1)),
        }
    }

    /// Whether the coarse grid is the fine one.
    pub fn is_none(self) -> bool {
        self == Self { cells: 1, yaws: 1 }
    }
}

/// Why a grid cannot be made coarser, for people.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct CoarseGridError(String);

/// A grid and a coarser one over the same container.
///
/// The regions of a view's coarse placements partition the fine placements of all views whose yaw
/// is nearest: a fine placement belongs to the coarse one with the nearest footprint centre.
#[derive(Debug, Clone)]
pub struct CoarseGrid {
    fine: Grid,
    coarse: Grid,
    pub(super) coarsening: Coarsening,
    /// Per coarse yaw: the fine yaws nearest to it.
    fine_yaws: Vec<Vec<usize>>,
}

impl CoarseGrid {
    /// The grid that is this much coarser.
    ///
    /// # Errors
    /// [`CoarseGridError`] where a factor is 0 or a coarse cell larger than the container.
    pub fn new(fine: &Grid, coarsening: Coarsening) -> Result<Self, CoarseGridError> {
        let Coarsening { cells, yaws } = coarsening;
        if cells == 0 || yaws == 0 {
            let zero = "a grid cannot be made 0 times coarser".to_owned();
            return Err(CoarseGridError(zero));
        }
        let resolution = fine.resolution();
        let every = resolution.yaws().every(yaws);
        let cell_m = resolution.cell_m() * cells as f64;
        let none = |error: GridError| {
            let what = format!("{cells} x {cells} cells of the grid make no coarse cell");
            CoarseGridError(format!("{what}: {error}"))
        };
        let coarse = Resolution::new(cell_m, resolution.height_unit_m(), every)
            .and_then(|resolution| Grid::new(fine.container(), resolution))
            .map_err(none)?;
        let mut fine_yaws = vec![Vec::new(); coarse.resolution().yaws().count()];
        for (yaw, angle) in resolution.yaws().radians().iter().enumerate() {
            let nearest = nearest(*angle, coarse.resolution().yaws().radians());
            if let Some(yaws) = fine_yaws.get_mut(nearest) {
                yaws.push(yaw);
            }
        }
        Ok(Self {
            fine: fine.clone(),
            coarse,
            coarsening,
            fine_yaws,
        })
    }

    /// The coarse grid.
    pub fn coarse(&self) -> &Grid {
        &self.coarse
    }

    /// The fine placements of a coarse one, by yaw, x, y; given an item's views on both grids.
    pub fn region<'a>(
        &'a self,
        fine: &'a [ItemView],
        coarse: &'a [ItemView],
        at: Placement,
    ) -> impl Iterator<Item = Placement> + 'a {
        let yaws = self.fine_yaws.get(at.yaw).map_or(&[][..], Vec::as_slice);
        let coarse = coarse.get(at.yaw);
        let views = yaws.iter().filter_map(move |yaw| {
            let (fine, coarse) = (fine.get(*yaw)?, coarse?);
            Some((*yaw, fine, coarse))
        });
        views.flat_map(move |(yaw, fine, coarse)| {
            let sides = |along: fn(&Grid) -> usize| (along(&self.fine), along(&self.coarse));
            let xs = self.span(sides(Grid::nx), (fine.nx(), coarse.nx()), at.x);
            let ys = self.span(sides(Grid::ny), (fine.ny(), coarse.ny()), at.y);
            xs.flat_map(move |x| ys.clone().map(move |y| Placement { yaw, x, y }))
        })
    }

    /// The fine corners along one side that belong to a coarse corner. Cells of the container and
    /// of the footprint are given as (fine, coarse).
    fn span(
        &self,
        container: (usize, usize),
        footprint: (usize, usize),
        corner: usize,
    ) -> std::ops::Range<usize> {
        let fine_corners = (container.0 + 1).saturating_sub(footprint.0);
        let coarse_corners = (container.1 + 1).saturating_sub(footprint.1);
        // In half cells, so that centres are whole numbers: the fine corner x belongs to the coarse
        // corner X with X - 1/2 <= (x + nx / 2) / cells - NX / 2 < X + 1/2, and those beyond the
        // first and last to these.
        let cells = self.coarsening.cells;
        let first = |corner: usize| {
            let twice = (2 * corner + footprint.1) * cells;
            twice.saturating_sub(cells + footprint.0).div_ceil(2)
        };
        let start = if corner == 0 { 0 } else { first(corner) };
        let end = if corner + 1 >= coarse_corners {
            fine_corners
        } else {
            first(corner + 1)
        };
        start.min(fine_corners)..end.min(fine_corners)
    }
}

/// The index of the nearest of some angles, the first of equally near ones.
fn nearest(angle_rad: f64, angles_rad: &[f64]) -> usize {
    let distance = |other: f64| {
        let turn = (angle_rad - other).rem_euclid(std::f64::consts::TAU);
        turn.min(std::f64::consts::TAU - turn)
    };
    let distances = angles_rad.iter().map(|other| distance(*other)).enumerate();
    let nearest = distances.min_by(|(_, a), (_, b)| a.total_cmp(b));
    nearest.map_or(0, |(index, _)| index)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_4;

    use super::*;
    use crate::kernel::grid::{ContainerSize, Yaws};

    fn grid(cell_m: f64, yaws: Yaws) -> Grid {
        let resolution = Resolution::new(cell_m, 0.002, yaws).unwrap();
        Grid::new(ContainerSize::REFERENCE, resolution).unwrap()
    }

    #[test]
    fn yaws_go_to_the_nearest_coarse_one() {
        let half = grid(0.0025, Yaws::half_turn(16).unwrap());
        let grids = CoarseGrid::new(&half, Coarsening { cells: 4, yaws: 4 }).unwrap();
        assert_eq!((grids.coarse().nx(), grids.coarse().ny()), (32, 32));
        assert_eq!(
            grids.coarse().resolution().yaws(),
            Grid::reference().resolution().yaws()
        );
        assert_eq!(grids.fine_yaws[0], [0, 1, 2]);
        assert_eq!(grids.fine_yaws[3], [11, 12, 13, 14, 15]);
        let turns = (0..8).map(|yaw| f64::from(yaw) * FRAC_PI_4).collect();
        let full = grid(0.01, Yaws::from_radians(turns).unwrap());
        let grids = CoarseGrid::new(&full, Coarsening { cells: 1, yaws: 4 }).unwrap();
        assert_eq!(grids.fine_yaws[0], [0, 1, 2, 6, 7]);
    }

    #[test]
    fn coarsening_goes_towards_a_cell_and_a_number_of_yaws() {
        let fine = grid(0.0025, Yaws::half_turn(16).unwrap());
        let expected = Coarsening { cells: 4, yaws: 4 };
        assert_eq!(Coarsening::towards(&fine, 0.01, 4), expected);
        assert!(Coarsening::towards(&Grid::reference(), 0.01, 4).is_none());
        assert!(Coarsening::towards(&Grid::reference(), 0.001, 10).is_none());
    }

    #[test]
    fn impossible_coarsenings_are_refused() {
        let fine = Grid::reference();
        let coarsened = |cells, yaws| CoarseGrid::new(&fine, Coarsening { cells, yaws });
        let refused = |cells, yaws| coarsened(cells, yaws).unwrap_err().to_string();
        assert!(refused(0, 1).contains("0 times coarser"));
        assert!(refused(33, 1).contains("33 x 33 cells of the grid make no"));
    }
}
