//! The conditions of a simulated cell, and what is usual under them.

use clap::ValueEnum;
use ppnpack_packing::method::Stability;
use ppnpack_packing::objective::Weights;
use ppnpack_packing::scene_value::SceneValue;
use ppnpack_packing::trial::TrialSettings;

/// How items are released and seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Conditions {
    /// Laid down from 1 cm, given 2 s to settle, every cell seen exactly
    Robot,
    /// The reference's: dropped from 12 cm, given the 0.375 s of the published code (the paper says 0.25 s), seen by a camera
    /// with one pixel per cell
    Reference,
}

/// What options are where nothing is said: best for a robot, the paper's for the reference.
pub(crate) struct Usual {
    pub(crate) cell_m: f64,
    pub(crate) yaws: usize,
    pub(crate) stability: Stability,
    pub(crate) trial: TrialSettings,
    /// The weights for items in so many poses.
    pub(crate) weights: fn(poses: usize) -> Weights,
    /// How much the value of what a placement leaves counts.
    pub(crate) scene_value: SceneValue,
    /// How many items may be set aside.
    pub(crate) set_aside: usize,
}

impl Conditions {
    pub(crate) fn usual(self) -> Usual {
        match self {
            Self::Robot => Usual {
                cell_m: 0.0025,
                yaws: 16,
                stability: Stability::None,
                trial: TrialSettings::default(),
                weights: Weights::for_poses,
                scene_value: SceneValue::built_in(),
                set_aside: 20,
            },
            Self::Reference => Usual {
                cell_m: 0.01,
                yaws: 4,
                stability: Stability::Published,
                trial: TrialSettings::off(),
                weights: |_| Weights::default(),
                scene_value: SceneValue::default(),
                set_aside: 0,
            },
        }
    }
}
