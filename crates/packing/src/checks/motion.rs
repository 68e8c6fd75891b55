//! Motion of an arm that carries out a placement: joint angles over time.

use nalgebra::Isometry3;
use serde::{Deserialize, Serialize};

/// Joints of an arm.
pub const JOINTS: usize = 6;

/// The most points of a leg.
pub const MAX_POINTS: usize = 2_000;

/// A cycle of an arm: pick, carry over, place, come back.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Cycle {
    /// The arm's name.
    pub arm: String,
    /// The time that it takes, gripping and letting go included, in seconds.
    pub cycle_s: f64,
    /// Pose of the item's own frame when it is picked.
    pub container_from_item_at_pick: Isometry3<f64>,
    /// The flange's turn about the vertical seen from the item's, in radians.
    pub grasp_yaw_rad: f64,
    /// How long the cup takes to hold the item, after [`LegKind::Descend`], in seconds.
    pub grip_s: f64,
    /// How long the cup takes to let go, after [`LegKind::Insert`], in seconds.
    pub release_s: f64,
    /// Legs, in order.
    pub legs: Vec<Leg>,
}

/// A part of a cycle, from rest to rest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Leg {
    /// Task of the leg.
    pub kind: LegKind,
    /// Joint angles, by increasing time.
    pub points: Vec<JointPoint>,
}

impl Leg {
    /// How long it takes, in seconds.
    pub fn duration_s(&self) -> f64 {
        self.points.last().map_or(0.0, |point| point.time_s)
    }

    /// Gives the joint angles at a time since the leg's start, J1 to J6 in radians, by linear
    /// interpolation. `None` for a leg without points.
    pub fn joints_rad(&self, time_s: f64) -> Option<[f64; JOINTS]> {
        let next = self.points.partition_point(|point| point.time_s <= time_s);
        let after = self.points.get(next).or(self.points.last())?;
        let before = self.points.get(next.saturating_sub(1)).unwrap_or(after);
        let span_s = after.time_s - before.time_s;
        let share = if span_s > 0.0 {
            ((time_s - before.time_s) / span_s).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let mut joints_rad = before.position_rad;
        for (joint, to) in joints_rad.iter_mut().zip(after.position_rad) {
            *joint += share * (to - *joint);
        }
        Some(joints_rad)
    }
}

/// Task of a leg of a cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum LegKind {
    /// Down to the item.
    Descend,
    /// Up with the item.
    Lift,
    /// Over to the container, at one height.
    Transfer,
    /// Down into the container.
    Insert,
    /// Up without the item.
    Retreat,
    /// Back to above the next item.
    Return,
}

/// Joint angles at a time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct JointPoint {
    /// Since the leg's start, in seconds.
    pub time_s: f64,
    /// J1 to J6, in radians.
    pub position_rad: [f64; JOINTS],
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joints_move_straight_from_point_to_point_and_stop_at_the_ends() {
        let point = |time_s, angle_rad| JointPoint {
            time_s,
            position_rad: [angle_rad; JOINTS],
        };
        let leg = Leg {
            kind: LegKind::Lift,
            points: vec![point(0.0, 1.0), point(0.5, 2.0), point(1.0, 0.0)],
        };
        let at = |time_s| leg.joints_rad(time_s).unwrap()[3];
        let found = [-1.0, 0.0, 0.25, 0.5, 0.75, 1.0, 9.0].map(at);
        assert_eq!(found, [1.0, 1.0, 1.5, 2.0, 1.0, 0.0, 0.0]);
        assert_eq!(leg.duration_s(), 1.0);
        let empty = Leg {
            kind: LegKind::Lift,
            points: Vec::new(),
        };
        assert_eq!(empty.joints_rad(0.0), None);
    }
}
