//! The value of every possible placement of a candidate, in two bytes each.

use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::item::{Item, ItemView};
use ppnpack_packing::kernel::placement::Placement;

/// The step in which values are kept, in units of the objective.
///
/// Kept is the difference to the candidate's least valid value, so nearby values are exact to half
/// a step and those more than 1023 above the least are cut off there.
pub const VALUE_STEP: f64 = 1.0 / 64.0;

/// Stands for a placement that does not fit or is not valid.
const INVALID: u16 = u16::MAX;

/// The greatest difference that is kept, in steps.
const GREATEST: u16 = INVALID - 1;

/// The values of a candidate's possible placements.
#[derive(Debug, Clone, PartialEq)]
pub struct Values {
    best: f64,
    yaws: Vec<YawValues>,
}

/// The values of the possible placements at one yaw.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct YawValues {
    nx: usize,
    ny: usize,
    /// Differences to the candidate's least value in steps, row-major.
    steps: Vec<u16>,
}

/// Counts the placements of a view along x and y; both 0 where it is larger than the container.
pub(crate) fn offsets(grid: &Grid, view: &ItemView) -> (usize, usize) {
    let along = |cells: usize, footprint: usize| (cells + 1).saturating_sub(footprint);
    match (along(grid.nx(), view.nx()), along(grid.ny(), view.ny())) {
        (0, _) | (_, 0) => (0, 0),
        both => both,
    }
}

impl Values {
    /// Makes values of which none is valid.
    pub(crate) fn none_valid(grid: &Grid, item: &Item) -> Self {
        let yaws = item.views().iter().map(|view| {
            let (nx, ny) = offsets(grid, view);
            YawValues {
                nx,
                ny,
                steps: vec![INVALID; nx * ny],
            }
        });
        Self {
            best: f64::INFINITY,
            yaws: yaws.collect(),
        }
    }

    /// Enters the value of a valid placement; the least must be entered first.
    pub(crate) fn enter(&mut self, placement: &Placement, value: f64) {
        self.best = self.best.min(value);
        let steps = ((value - self.best) / VALUE_STEP).round();
        let entry = self.yaws.get_mut(placement.yaw).and_then(|yaw| {
            let index = placement.x * yaw.ny + placement.y;
            yaw.steps.get_mut(index)
        });
        if let Some(entry) = entry {
            *entry = steps.min(f64::from(GREATEST)) as u16;
        }
    }

    /// Takes kept values over. `steps` gives the entries of all yaws, in order.
    pub(crate) fn from_steps(
        grid: &Grid,
        item: &Item,
        best: f64,
        steps: &mut impl Iterator<Item = u16>,
    ) -> Self {
        let mut values = Self::none_valid(grid, item);
        values.best = best;
        let entries = values.yaws.iter_mut().flat_map(|yaw| &mut yaw.steps);
        for (entry, step) in entries.zip(steps) {
            *entry = step;
        }
        values
    }

    /// Gives the entries of all yaws, in order.
    pub(crate) fn steps(&self) -> impl Iterator<Item = u16> {
        self.yaws.iter().flat_map(|yaw| yaw.steps.iter().copied())
    }

    /// Gives the candidate's least valid value; infinite where none is valid.
    pub fn best(&self) -> f64 {
        self.best
    }

    /// Gives one entry per yaw.
    pub fn yaws(&self) -> &[YawValues] {
        &self.yaws
    }

    /// Gives the value of a placement, to half a [`VALUE_STEP`]; infinite where it does not fit, is
    /// not valid or not possible.
    pub fn get(&self, yaw: usize, x: usize, y: usize) -> f32 {
        let yaw = self.yaws.get(yaw).filter(|yaw| y < yaw.ny);
        let step = yaw.and_then(|yaw| yaw.steps.get(x * yaw.ny + y));
        let above = step.map_or(f32::INFINITY, |step| difference(*step));
        (self.best + f64::from(above)) as f32
    }
}

impl YawValues {
    /// Counts the placements along x and y; 0 where the footprint is larger than the container.
    pub fn size(&self) -> (usize, usize) {
        (self.nx, self.ny)
    }

    /// Gives the excess of each value over the candidate's least: `nx * ny` differences, row-major
    /// (`x * ny + y`).
    pub fn all_above_best(&self) -> impl Iterator<Item = f32> {
        self.steps.iter().map(|step| difference(*step))
    }
}

fn difference(step: u16) -> f32 {
    if step == INVALID {
        f32::INFINITY
    } else {
        f32::from(step) * VALUE_STEP as f32
    }
}

#[cfg(test)]
mod tests {
    use ppnpack_packing::kernel::item::ViewSurfaces;

    use super::*;

    fn item(nx: usize, ny: usize) -> Item {
        let cells = nx * ny;
        let view = ViewSurfaces::of_cells(nx, ny, vec![2; cells], vec![0; cells]);
        Item::new("block", vec![view], 0.0).unwrap()
    }

    fn at(x: usize, y: usize) -> Placement {
        Placement { yaw: 0, x, y }
    }

    #[test]
    fn values_are_kept_to_half_a_step() {
        let mut values = Values::none_valid(&Grid::reference(), &item(3, 2));
        values.enter(&at(4, 5), 100.3);
        values.enter(&at(4, 6), 117.77);
        values.enter(&at(29, 30), 1e6);
        assert_eq!(values.yaws()[0].size(), (30, 31));
        let half = VALUE_STEP as f32 / 2.0 + 1e-5;
        assert!((values.get(0, 4, 5) - 100.3).abs() < half);
        assert!((values.get(0, 4, 6) - 117.77).abs() < half);
        assert!(values.get(0, 29, 30) > 1100.0 && values.get(0, 29, 30).is_finite());
        for (x, y) in [(0, 0), (30, 0), (4, 31), (1000, 1000)] {
            assert_eq!(values.get(0, x, y), f32::INFINITY, "({x}, {y})");
        }
        assert_eq!(values.get(1, 0, 0), f32::INFINITY);
    }

    #[test]
    fn steps_come_back() {
        let (grid, item) = (Grid::reference(), item(3, 2));
        let mut values = Values::none_valid(&grid, &item);
        values.enter(&at(1, 1), -3.0);
        values.enter(&at(2, 1), 3.5);
        let again = Values::from_steps(&grid, &item, -3.0, &mut values.steps());
        assert_eq!(again, values);
    }

    #[test]
    fn items_larger_than_the_container_have_no_values() {
        let values = Values::none_valid(&Grid::reference(), &item(33, 2));
        assert_eq!(values.yaws()[0].size(), (0, 0));
        assert_eq!(values.yaws()[0].all_above_best().count(), 0);
    }
}
