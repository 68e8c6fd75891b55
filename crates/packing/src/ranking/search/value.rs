//! The values of placements.

use crate::kernel::distance::DistanceLevels;
use crate::kernel::grid::Units;
use crate::kernel::item::ItemView;
use crate::kernel::lanes::{PaddedMap, columns_after, contact, distance_sum};
use crate::kernel::objective::{Heuristic, Objective};
use crate::kernel::placement::{Placement, RestingPlacement};
use crate::kernel::random;

/// Inputs of the values of placements.
#[derive(Clone, Copy)]
pub(crate) struct Valuation<'a> {
    pub(crate) objective: &'a Objective,
    pub(crate) container: &'a PaddedMap,
    /// Distance levels, for objectives that know the distance to content.
    pub(crate) distance: Option<&'a DistanceLevels>,
}

impl Valuation<'_> {
    /// `F(b, p)` of an item's view at a resting placement, given the view's
    /// [`Objective::constant`]; `seed` is the item's own, for [`Heuristic::Random`].
    #[inline(always)]
    pub(crate) fn value(
        &self,
        view: &ItemView,
        constant: f64,
        at: RestingPlacement,
        seed: u64,
    ) -> f64 {
        let Self {
            objective,
            container,
            distance,
        } = *self;
        let Placement { x, y, .. } = at.placement;
        let height: Units = at.resting_height;
        let base = container.index(x, y);
        match objective.heuristic {
            Heuristic::Sdfm => {
                let Some(distance) = distance else {
                    return f64::INFINITY;
                };
                let sum = distance_sum(&distance.levels, base, view, height);
                objective.sdfm(height, sum as f64 / view.voxel_count() as f64, constant)
            }
            Heuristic::Dbl => objective.dbl(height, x, y, constant),
            Heuristic::Hm => {
                let columns = columns_after(container, base, view, height);
                objective.hm(columns, x, y, constant)
            }
            Heuristic::Mta => objective.mta(contact(container, (x, y), view, height), constant),
            Heuristic::FirstFit => ordinal(container, at.placement) as f64,
            Heuristic::Random => {
                let of_placement = ordinal(container, at.placement) as u64;
                random::unit(random::mix(seed, of_placement))
            }
        }
    }
}

/// The place of a placement in the order of yaw, x, y.
#[inline(always)]
fn ordinal(container: &PaddedMap, Placement { yaw, x, y }: Placement) -> usize {
    let (nx, ny) = container.size();
    (yaw * nx + x) * ny + y
}
