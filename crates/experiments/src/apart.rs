//! A cell whose physics are not quite those that the planner thinks it has.

use clap::ValueEnum;
use ppnpack_numbers::factor_within;
use ppnpack_physics::packing_cell::PoseError;
use ppnpack_physics::settings::CellSettings;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

/// How far the cell is from what is known of it. The default is not at all.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Apart {
    /// Friction coefficients are multiplied by a factor between this and its inverse, drawn once a
    /// sequence for the items and once for the walls.
    pub(crate) friction: f64,
    /// Accuracy of the known poses of the content.
    pub(crate) pose_error: PoseError,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Physics {
    /// The planner's own
    Own,
    /// With other friction, and poses of its content that are not quite known
    Apart,
}

impl Physics {
    pub(crate) fn apart(self) -> Apart {
        match self {
            Self::Own => Apart::default(),
            Self::Apart => Apart::of_the_published_table(),
        }
    }
}

impl Default for Apart {
    fn default() -> Self {
        Self {
            friction: 1.0,
            pose_error: PoseError::default(),
        }
    }
}

impl Apart {
    /// Friction 0.71 to 1.4 times the twin's, poses known up to 2 mm and 1 degree (deviations per
    /// axis).
    fn of_the_published_table() -> Self {
        Self {
            friction: 1.4,
            pose_error: PoseError {
                position_m: 0.002,
                rotation_rad: 1.0_f64.to_radians(),
            },
        }
    }

    pub(crate) fn cell(&self, mut known: CellSettings) -> CellSettings {
        let mut random = ChaCha8Rng::seed_from_u64(known.seed);
        let mut factor = || factor_within(self.friction, random.random());
        known.contact.item_friction *= factor();
        known.contact.wall_friction *= factor();
        known
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_stays_within_its_range_and_is_another_for_each_sequence() {
        let friction = |apart: Apart, seed| {
            let known = CellSettings {
                seed,
                ..CellSettings::robot()
            };
            apart.cell(known).contact.item_friction
        };
        let usual = CellSettings::robot().contact.item_friction;
        assert_eq!(friction(Apart::default(), 3), usual);
        let apart = Physics::Apart.apart();
        let drawn: Vec<f64> = (0..50).map(|seed| friction(apart, seed) / usual).collect();
        assert!(drawn.iter().all(|factor| (0.71..=1.4).contains(factor)));
        assert!(drawn.iter().any(|it| *it < 0.85) && drawn.iter().any(|it| *it > 1.2));
    }
}
