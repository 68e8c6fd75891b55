//! Records of steps.

use ppnpack_packing::kernel::grid::Units;
use ppnpack_packing::kernel::placement::Placement;

use crate::values::Values;

/// Maximum difference of ties: equal values that were added up in another order.
pub const TIE_TOLERANCE: f64 = 1e-9;

/// A played sequence.
#[derive(Debug, Clone, PartialEq)]
pub struct SequenceRecord {
    /// Its number, from 0.
    pub sequence: u32,
    /// The steps in which an item was packed, in order.
    pub steps: Vec<StepRecord>,
}

/// A step of the expert.
#[derive(Debug, Clone, PartialEq)]
pub struct StepRecord {
    /// The sequence it belongs to.
    pub sequence: u32,
    /// Its number within the sequence, from 0.
    pub step: u32,
    /// The container's heightmap before the step: `nx * ny` heights in units, row-major (`x * ny +
    /// y`).
    pub heightmap: Vec<Units>,
    /// The buffer, in the order of arrival.
    pub candidates: Vec<CandidateRecord>,
}

/// The expert's labels of a candidate.
#[derive(Debug, Clone, PartialEq)]
pub struct CandidateRecord {
    /// Its index into the dataset's items.
    pub object: u32,
    /// The optimal valid placements, one entry per yaw.
    pub yaws: Vec<YawOptima>,
    /// The value of every possible placement, where the dataset has them.
    pub values: Option<Values>,
}

/// The optimal valid placements of a candidate at one yaw: those with the least value, all ties.
#[derive(Debug, Clone, PartialEq)]
pub struct YawOptima {
    /// The least value of a valid placement; infinite where none is valid.
    pub value: f64,
    /// The placements by x, then y; empty where none is valid.
    pub placements: Vec<Corner>,
}

impl YawOptima {
    /// No placement is valid.
    pub const NONE: Self = Self {
        value: f64::INFINITY,
        placements: Vec::new(),
    };
}

/// The cell of a footprint's corner with the lowest indices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Corner {
    /// Cell index along x.
    pub x: u16,
    /// Cell index along y.
    pub y: u16,
}

impl CandidateRecord {
    /// Gives the least value of a valid placement at any yaw; infinite where none is valid.
    pub fn best_value(&self) -> f64 {
        let values = self.yaws.iter().map(|optima| optima.value);
        values.fold(f64::INFINITY, f64::min)
    }

    /// Gives the optimal valid placements over all yaws, all ties, by yaw, x, y; nothing where none
    /// is valid.
    pub fn best(&self) -> impl Iterator<Item = Placement> {
        let limit = self.best_value() + TIE_TOLERANCE;
        let yaws = self.yaws.iter().enumerate();
        yaws.filter(move |(_, optima)| optima.value <= limit)
            .flat_map(|(yaw, optima)| {
                optima.placements.iter().map(move |corner| Placement {
                    yaw,
                    x: usize::from(corner.x),
                    y: usize::from(corner.y),
                })
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn optima(value: f64, corners: &[(u16, u16)]) -> YawOptima {
        let placements = corners.iter().map(|(x, y)| Corner { x: *x, y: *y });
        YawOptima {
            value,
            placements: placements.collect(),
        }
    }

    #[test]
    fn the_best_are_the_ties_over_all_yaws() {
        let mut record = CandidateRecord {
            object: 0,
            yaws: vec![
                optima(2.0, &[(0, 1), (5, 5)]),
                YawOptima::NONE,
                optima(3.0, &[(1, 1)]),
                optima(2.0 + 1e-12, &[(2, 0)]),
            ],
            values: None,
        };
        let best = [(0, 0, 1), (0, 5, 5), (3, 2, 0)];
        let best = best.map(|(yaw, x, y)| Placement { yaw, x, y });
        assert!(record.best().eq(best));
        record.yaws = vec![YawOptima::NONE; 4];
        assert_eq!(record.best().count(), 0, "none is valid");
        assert_eq!(record.best_value(), f64::INFINITY);
    }
}
