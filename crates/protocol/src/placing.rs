//! Placements that a robot is asked for, and its findings about them.

use std::sync::Arc;

use nalgebra::Isometry3;
use ppnpack_packing::checks::motion::Cycle;
use serde::{Deserialize, Serialize};

/// A placement that a robot is asked for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Placement {
    /// The name of the placement, its idempotency key.
    pub placement_id: String,
    /// The item.
    pub item_id: String,
    /// The kind of the item.
    pub object: String,
    /// The planned pose of the item's own frame.
    pub container_from_item: Isometry3<f64>,
    /// The state of the cell that this was planned on.
    pub state_number: u64,
    /// The motion that was checked for it, where the cell has an arm. The journal keeps that of the
    /// last placement apart from the records.
    #[serde(skip)]
    pub cycle: Option<Arc<Cycle>>,
}

impl Placement {
    /// Says whether the same is asked for. A motion that either has no more does not count.
    pub fn is_same(&self, other: &Self) -> bool {
        let both = self.cycle.as_ref().zip(other.cycle.as_ref());
        let without = |placement: &Self| Self {
            cycle: None,
            ..placement.clone()
        };
        both.is_none_or(|(own, others)| own == others) && without(self) == without(other)
    }
}

/// The end of a placement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Ending {
    /// The item was released in the container.
    Placed,
    /// Nothing in the container was changed, and the item is where it was.
    NotPlaced,
    /// The item left the cell.
    Lost,
    /// Nobody knows.
    Unknown,
}

/// The pose of an item's own frame, and the way in which it is known.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum KnownPose {
    /// Nobody has looked: it is as planned.
    Assumed(Isometry3<f64>),
    /// It was seen, measured or simulated after the item was released.
    Found(Isometry3<f64>),
}

impl KnownPose {
    /// Makes a pose that was found, or else is assumed.
    pub fn new(container_from_item: Isometry3<f64>, is_found: bool) -> Self {
        match is_found {
            true => Self::Found(container_from_item),
            false => Self::Assumed(container_from_item),
        }
    }

    /// Gives the pose, as far as it is known.
    pub fn isometry(&self) -> &Isometry3<f64> {
        let (Self::Assumed(pose) | Self::Found(pose)) = self;
        pose
    }

    /// Says whether it was found.
    pub fn is_found(&self) -> bool {
        matches!(self, Self::Found(_))
    }
}

/// The finding of a robot about a placement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// The end.
    pub ending: Ending,
    /// The failure, for people; empty where the item was placed.
    pub failure: String,
    /// The pose of the item's own frame, where it is known.
    pub container_from_item: Option<KnownPose>,
    /// Whether the item's centre of mass is inside the container.
    pub is_inside: bool,
    /// Horizontal distance of the item's centre of mass from where it was planned, in metres.
    pub slide_m: f64,
    /// The tilt of the item, in radians.
    pub tilt_rad: f64,
}

impl Finding {
    /// Makes the finding of an item that is not in the container, and why.
    pub fn failed(ending: Ending, failure: impl Into<String>) -> Self {
        Self {
            ending,
            failure: failure.into(),
            container_from_item: None,
            is_inside: false,
            slide_m: 0.0,
            tilt_rad: 0.0,
        }
    }
}

/// Something that was placed in the container.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Body {
    /// The item.
    pub item_id: String,
    /// The kind of the item.
    pub object: String,
    /// The pose of the item's own frame.
    pub container_from_item: KnownPose,
    /// Whether its centre of mass is inside the container.
    pub is_inside: bool,
}
