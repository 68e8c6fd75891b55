//! What a robot is asked to place, and what it finds out about that.

use std::sync::Arc;

use nalgebra::Isometry3;
use ppnpack_packing::motion::Cycle;
use serde::{Deserialize, Serialize};

/// A placement that a robot is asked for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Placement {
    /// Names the placement.
    pub placement_id: String,
    /// The item.
    pub item_id: String,
    /// What the item is.
    pub object: String,
    /// Where the item's own frame shall be.
    pub container_from_item: Isometry3<f64>,
    /// The state of the cell that this was planned on.
    pub state_number: u64,
    /// The motion that was checked for it, where the cell has an arm. The journal keeps that of the last placement
    /// apart from the records.
    #[serde(skip)]
    pub cycle: Option<Arc<Cycle>>,
}

impl Placement {
    /// Whether the same is asked for. Where one has no motion any more, it does not count.
    pub fn is_same(&self, other: &Self) -> bool {
        let both = self.cycle.as_ref().zip(other.cycle.as_ref());
        let without = |placement: &Self| Self {
            cycle: None,
            ..placement.clone()
        };
        both.is_none_or(|(own, others)| own == others) && without(self) == without(other)
    }
}

/// How a placement ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Ending {
    /// The item was released in the container.
    Placed,
    /// Nothing in the container was changed, and the item is where it was.
    NotPlaced,
    /// The item left the cell.
    Lost,
    /// It is not known.
    Unknown,
}

/// Where an item's own frame is, and how that is known.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum KnownPose {
    /// Nobody has looked: it was to be there.
    Assumed(Isometry3<f64>),
    /// It was seen, measured or simulated after the item was released.
    Found(Isometry3<f64>),
}

impl KnownPose {
    /// A pose that was found, or else is assumed.
    pub fn new(container_from_item: Isometry3<f64>, is_found: bool) -> Self {
        match is_found {
            true => Self::Found(container_from_item),
            false => Self::Assumed(container_from_item),
        }
    }

    /// Where the frame is, as far as is known.
    pub fn isometry(&self) -> &Isometry3<f64> {
        let (Self::Assumed(pose) | Self::Found(pose)) = self;
        pose
    }

    /// Whether it was found.
    pub fn is_found(&self) -> bool {
        matches!(self, Self::Found(_))
    }
}

/// What a robot found out about a placement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// How it ended.
    pub ending: Ending,
    /// What went wrong, for people; empty where the item was placed.
    pub failure: String,
    /// Where the item's own frame is now, where that is known.
    pub container_from_item: Option<KnownPose>,
    /// Whether the item's centre of mass is inside the container.
    pub is_inside: bool,
    /// Horizontal distance of the item's centre of mass from where it was planned, in metres.
    pub slide_m: f64,
    /// How far the item tilted, in radians.
    pub tilt_rad: f64,
}

impl Finding {
    /// An item that is not in the container, and why.
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
    /// What the item is.
    pub object: String,
    /// Where the item's own frame is.
    pub container_from_item: KnownPose,
    /// Whether its centre of mass is inside the container.
    pub is_inside: bool,
}
