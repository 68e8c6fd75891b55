//! Reasons why the arm cannot make a motion.

use std::fmt;
use std::sync::Arc;

use crate::gripper::GripperPart;
use crate::joints::Joint;
use crate::pick::NoPickPoint;

/// Something that moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Body {
    /// A link: link `n` is turned by joint `n`.
    Link(usize),
    /// A part of the gripper.
    Gripper(GripperPart),
    /// The item below the cup.
    HeldItem,
}

/// Something that is hit.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Obstacle {
    /// The container's content, or the item just placed.
    Content,
    /// A wall of the container.
    Wall,
    /// The table.
    Table,
    /// A configured box, by name.
    Box(Arc<str>),
    /// A part of the arm itself, the gripper, or what it holds.
    Itself(Body),
}

/// Reason why a motion is not possible.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Refusal {
    /// The item cannot be held.
    #[error("the item cannot be picked: {0}")]
    Pick(#[from] NoPickPoint),
    /// The item does not have the placement's yaw, or the placement is not on the grid.
    #[error("the placement is not one of the item's")]
    Placement,
    /// No joint angles put the cup there.
    #[error("the arm does not reach a height of {height_m:.3} m there")]
    OutOfReach {
        /// The height of the cup's lip, in metres.
        height_m: f64,
    },
    /// A joint would leave its range.
    #[error("{joint:?} would leave its range")]
    JointLimit {
        /// The joint.
        joint: Joint,
    },
    /// The wrist would be stretched: J4 and J6 turn about one axis.
    #[error("the wrist would be stretched")]
    WristSingularity,
    /// The joints would have to turn too far for a short way of the cup.
    #[error("{joint:?} would turn by {step_rad:.2} rad within a step")]
    Discontinuous {
        /// The joint that turns most.
        joint: Joint,
        /// Its turn, in radians.
        step_rad: f64,
    },
    /// The joints would lead the cup too far from its straight line.
    #[error("the cup could leave its straight line by {deviation_m:.4} m")]
    NotStraight {
        /// A bound of the distance, in metres.
        deviation_m: f64,
    },
    /// Something would be hit or come too close.
    #[error("{body} would come too close to {obstacle}")]
    Collision {
        /// The thing that moves.
        body: Body,
        /// The thing that is hit.
        obstacle: Obstacle,
    },
    /// The item and the gripper are heavier than the arm's payload.
    #[error("the item weighs {mass_kg:.2} kg, more than the arm carries")]
    TooHeavy {
        /// The item's mass, in kilograms.
        mass_kg: f64,
    },
}

impl Refusal {
    /// Gives the reason without figures, so that refusals for the same reason can be counted.
    pub fn cause(&self) -> String {
        match self {
            Self::OutOfReach { .. } => "the arm does not reach the place".to_owned(),
            Self::Discontinuous { joint, .. } => format!("{joint:?} would turn too far at once"),
            Self::NotStraight { .. } => "the cup could leave its straight line".to_owned(),
            Self::TooHeavy { .. } => "the item weighs more than the arm carries".to_owned(),
            other => other.to_string(),
        }
    }

    /// Ranks how far a motion came before it was refused: of several attempts, the one that came
    /// furthest tells most.
    pub(crate) fn progress(&self) -> u8 {
        match self {
            Self::Pick(_) | Self::Placement | Self::TooHeavy { .. } => 0,
            Self::OutOfReach { .. } => 1,
            Self::JointLimit { .. } => 2,
            Self::Discontinuous { .. } | Self::WristSingularity | Self::NotStraight { .. } => 3,
            Self::Collision { .. } => 4,
        }
    }
}

impl fmt::Display for Body {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Link(0) => "the base",
            Self::Link(link) => return write!(formatter, "link {link}"),
            Self::Gripper(GripperPart::Cup) => "the cup",
            Self::Gripper(GripperPart::Stem) => "the gripper's stem",
            Self::Gripper(GripperPart::Body) => "the gripper's body",
            Self::HeldItem => "the held item",
        })
    }
}

impl fmt::Display for Obstacle {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Content => formatter.write_str("the container's content"),
            Self::Wall => formatter.write_str("a wall of the container"),
            Self::Table => formatter.write_str("the table"),
            Self::Box(name) => write!(formatter, "the {name}"),
            Self::Itself(body) => body.fmt(formatter),
        }
    }
}
