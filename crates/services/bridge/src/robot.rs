//! The interface behind which a cell is: its robot, its container and its sensor.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::{Isometry3, Point3};
use ppnpack_catalogue::mesh::Bounds;
use ppnpack_packing::grid::ContainerSize;
use ppnpack_packing::motion::Cycle;
use ppnpack_service::Shutdown;
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
    pub(crate) fn is_same(&self, other: &Self) -> bool {
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

/// What a robot found out about a placement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// How it ended.
    pub ending: Ending,
    /// What went wrong, for people; empty where the item was placed.
    pub failure: String,
    /// Where the item's own frame is now, where that is known.
    pub container_from_item: Option<Isometry3<f64>>,
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
    pub container_from_item: Isometry3<f64>,
    /// Whether its centre of mass is inside the container.
    pub is_inside: bool,
}

/// What the sensor of a cell sees.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Points in the sensor's frame, in metres.
    pub points_m: Vec<Point3<f32>>,
    /// Where the sensor is.
    pub container_from_sensor: Isometry3<f64>,
}

/// A robot was told to stop before it touched anything in the cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CutOff;

/// Why a robot did not do something, for people.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct RobotError(pub String);

/// The robot, container and sensor of one cell.
///
/// Calls come from one thread at a time.
pub trait Robot: Send {
    /// Whether the cell is simulated. What a simulated cell did and did not write down has not happened; what another
    /// did is not known.
    fn is_simulated(&self) -> bool;

    /// The container's inner size.
    fn container(&self) -> ContainerSize;

    /// The objects that can be placed, by name, each with the box around it in its own frame; `None` where that does not
    /// depend on the object.
    fn objects(&self) -> Option<BTreeMap<String, Bounds>>;

    /// Told before anything else is asked, and whenever people changed it: what lies in the container, as far as is known.
    /// Gives what does.
    fn take_over(&mut self, bodies: Vec<Body>) -> Vec<Body>;

    /// Places an item, by the placement's motion where it has one, and comes back when that has ended. Where `cut_off` is
    /// requested before anything in the cell was touched, it gives up. Where that comes later, a robot that can stop sooner than
    /// at the end does, and its finding says what became of the item. What goes wrong is a finding.
    ///
    /// # Errors
    /// [`CutOff`] where it gave up.
    fn place(&mut self, placement: &Placement, cut_off: &Shutdown) -> Result<Finding, CutOff>;

    /// Takes the container away and brings an empty one.
    ///
    /// # Errors
    /// [`RobotError`] where that did not happen.
    fn renew(&mut self) -> Result<(), RobotError>;

    /// What lies in the container, as far as it is known.
    fn bodies(&self) -> Vec<Body>;

    /// Looks at the container.
    ///
    /// # Errors
    /// [`RobotError`] where the sensor gives nothing.
    fn capture(&mut self) -> Result<View, RobotError>;
}
