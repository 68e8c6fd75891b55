//! One view looked at everywhere: resting height, fit, stability and value of every placement.

use crate::checks::stability::PublishedStability;
use crate::kernel::distance::DistanceLevels;
use crate::kernel::grid::{Grid, Units};
use crate::kernel::heightmap::Heightmap;
use crate::kernel::item::ItemView;
use crate::kernel::lanes::{BlockOffsets, PaddedMap, TOGETHER, resting_heights_at};
use crate::kernel::objective::{Heuristic, Objective, SettingError, Weights};
use crate::kernel::placement::{Placement, RestingPlacement};
use crate::ranking::search::value::Valuation;

/// A placement with what the engine says of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surveyed {
    /// Cell of the footprint's corner along x.
    pub x: usize,
    /// Cell of the footprint's corner along y.
    pub y: usize,
    /// Resting height, in units.
    pub resting_height: Units,
    /// Whether the item stays at or below the rim.
    pub fits: bool,
    /// Whether the published stability test accepts it.
    pub is_stable: bool,
    /// The objective with its balance term.
    pub value: f64,
}

/// Looks at every placement of a view, by x, then y; none where its footprint is too large.
pub fn survey(
    grid: &Grid,
    heightmap: &Heightmap,
    view: &ItemView,
    heuristic: Heuristic,
    weights: &Weights,
) -> Result<Vec<Surveyed>, SettingError> {
    weights.validate()?;
    let objective = Objective::new(grid, heuristic, weights, true);
    let constant = objective.constant(view);
    let mut container = PaddedMap::new(grid.nx(), grid.ny());
    for x in 0..grid.nx() {
        container.row_mut(x).copy_from_slice(heightmap.row(x));
    }
    let mut distance = DistanceLevels::new(grid);
    distance.update(heightmap);
    let mut stability = PublishedStability::default();
    let valuation = Valuation {
        objective: &objective,
        container: &container,
        distance: Some(&distance),
    };
    let mut blocks = BlockOffsets::default();
    blocks.update(&container, view);
    let (placed_x, placed_y) = view.corners((grid.nx(), grid.ny()));
    let mut surveyed = Vec::new();
    for x in 0..placed_x {
        for y in 0..placed_y {
            let base = container.index(x, y);
            let [resting_height, ..] =
                resting_heights_at(&container, [base; TOGETHER], view, &blocks);
            let resting = RestingPlacement {
                placement: Placement { yaw: 0, x, y },
                resting_height,
            };
            surveyed.push(Surveyed {
                x,
                y,
                resting_height,
                fits: view.fits_at(grid, resting_height),
                is_stable: stability.is_stable(grid, heightmap, view, &resting),
                value: valuation.value(view, constant, resting, 0),
            });
        }
    }
    Ok(surveyed)
}
