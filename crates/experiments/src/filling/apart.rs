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
    /// Friction coefficients are multiplied by a factor between this and its inverse, drawn once a sequence for the
    /// items and once for the walls.
    pub(crate) friction: f64,
    /// How well the poses of what lies in the container are known.
    pub(crate) pose_error: PoseError,
    /// The mass of each item is multiplied by a factor between this and its inverse.
    pub(crate) mass: f64,
    /// The most that the restitution is, drawn once a sequence.
    pub(crate) restitution: f64,
}

/// Which cells are packed in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Physics {
    /// As the planner thinks it is
    Own,
    /// With other friction, and poses of its content that are not quite known
    Apart,
    /// With other masses and with items that bounce, too
    FarApart,
}

impl Physics {
    pub(crate) fn apart(self) -> Apart {
        match self {
            Self::Own => Apart::default(),
            Self::Apart => Apart::of_the_published_table(),
            Self::FarApart => Apart {
                mass: 1.4,
                restitution: 0.2,
                ..Apart::of_the_published_table()
            },
        }
    }

    /// The cell, in a few words.
    pub(crate) fn cell(self) -> &'static str {
        match self {
            Self::Own => "the cell is the twin's",
            Self::Apart => "the cell is another one",
            Self::FarApart => "the cell is quite another one",
        }
    }
}

impl Default for Apart {
    fn default() -> Self {
        Self {
            friction: 1.0,
            pose_error: PoseError::default(),
            mass: 1.0,
            restitution: 0.0,
        }
    }
}

impl Apart {
    /// Friction of 0.71 to 1.4 times that of the twin, poses known up to 2 mm and 1 degree (standard deviations per axis).
    pub(crate) fn of_the_published_table() -> Self {
        Self {
            friction: 1.4,
            pose_error: PoseError {
                position_m: 0.002,
                rotation_rad: 1.0_f64.to_radians(),
            },
            ..Self::default()
        }
    }

    /// The real cell.
    pub(crate) fn cell(&self, mut known: CellSettings) -> CellSettings {
        let mut random = ChaCha8Rng::seed_from_u64(known.seed);
        let mut uniform = || random.random::<f64>();
        known.contact.item_friction *= factor_within(self.friction, uniform());
        known.contact.wall_friction *= factor_within(self.friction, uniform());
        known.contact.restitution = known.contact.restitution.max(self.restitution * uniform());
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
        let apart = Apart::of_the_published_table();
        let drawn: Vec<f64> = (0..50).map(|seed| friction(apart, seed) / usual).collect();
        assert!(drawn.iter().all(|factor| (0.71..=1.4).contains(factor)));
        assert!(
            drawn.iter().any(|factor| *factor < 0.85) && drawn.iter().any(|factor| *factor > 1.2)
        );
    }

    #[test]
    fn what_is_far_apart_bounces_and_slides_as_what_is_apart() {
        let contact = |physics: Physics, seed| {
            let known = CellSettings {
                seed,
                ..CellSettings::robot()
            };
            physics.apart().cell(known).contact
        };
        for seed in 0..20 {
            let (apart, far) = (
                contact(Physics::Apart, seed),
                contact(Physics::FarApart, seed),
            );
            assert_eq!(apart.item_friction, far.item_friction);
            assert_eq!(apart.restitution, 0.0);
            assert!((0.0..0.2).contains(&far.restitution) && far.restitution > 0.0);
        }
    }
}
