//! The benchmark's settings: how boxes may be turned, and whether they have to be stable.

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

use super::surface::Sides;

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
pub(super) enum Setting {
    /// Boxes have to be stable, and are turned about the vertical alone.
    #[value(name = "1")]
    #[serde(rename = "1")]
    Stable,
    /// Boxes lie anyhow, and stay where they are placed.
    #[value(name = "2")]
    #[serde(rename = "2")]
    Free,
}

impl Setting {
    pub(super) fn asks_for_stability(self) -> bool {
        self == Self::Stable
    }

    /// The poses of a box: which of its sides stands. Each may be turned about the vertical.
    pub(super) fn poses(self, Sides { x, y, z }: Sides) -> impl Iterator<Item = Sides> {
        let poses = [(x, y, z), (x, z, y), (y, z, x)];
        let count = match self {
            Self::Stable => 1,
            Self::Free => poses.len(),
        };
        let poses = poses.into_iter().take(count);
        poses.map(|(x, y, z)| Sides { x, y, z })
    }

    /// The ways in which a box may lie, each once, in the order in which the engine ranks equals.
    pub(super) fn orientations(self, sides: Sides) -> Vec<Sides> {
        let mut all = Vec::with_capacity(6);
        for sides in self.poses(sides).flat_map(|pose| [pose, pose.turned()]) {
            if !all.contains(&sides) {
                all.push(sides);
            }
        }
        all
    }
}
