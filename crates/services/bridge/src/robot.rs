//! The interface to a cell: its robot, its container and its sensors.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Point3};
use ppnpack_catalogue::mesh::Bounds;
use ppnpack_packing::kernel::grid::ContainerSize;
pub use ppnpack_protocol::placing::{Body, Ending, Finding, KnownPose, Placement};
use ppnpack_service::Shutdown;

/// The view of a sensor of a cell.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// The sensor's name; empty where the cell has only one.
    pub sensor: String,
    /// Points in the sensor's frame, in metres.
    pub points_m: Vec<Point3<f32>>,
    /// The sensor's pose in the container's frame.
    pub container_from_sensor: Isometry3<f64>,
    /// Whether the points surely show the cell as it is now: a camera that runs by itself may have
    /// looked before.
    pub is_of_now: bool,
}

/// The end of a placement that was stopped before the robot touched anything in the cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CutOff;

/// The reason why a robot did not do something, for people.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct RobotError(pub String);

/// The robot, container and sensor of one cell.
///
/// Calls come from one thread at a time.
pub trait Robot: Send {
    /// Whether the cell is simulated. A work of which the end was not written down has not happened
    /// in a simulated cell; in another that is not known.
    fn is_simulated(&self) -> bool;

    /// The container's inner size.
    fn container(&self) -> ContainerSize;

    /// The objects that can be placed, by name, each with the box around it in its own frame;
    /// `None` where any object can be.
    fn objects(&self) -> Option<BTreeMap<String, Bounds>>;

    /// Takes over the bodies that lie in the container, as far as is known; gives those that do.
    /// Called before all else, and whenever people changed them.
    fn take_over(&mut self, bodies: Vec<Body>) -> Vec<Body>;

    /// Places an item, by the placement's motion if it has one, and returns when that has ended.
    ///
    /// It gives up if `cut_off` is requested before it touched anything in the cell. If that comes
    /// later, a robot that can stop before the end does so, and its finding says what became of the
    /// item. What goes wrong is a finding.
    ///
    /// # Errors
    /// [`CutOff`] where it gave up.
    fn place(&mut self, placement: &Placement, cut_off: &Shutdown) -> Result<Finding, CutOff>;

    /// Takes the container away and brings an empty one.
    ///
    /// # Errors
    /// [`RobotError`] where that did not happen.
    fn renew(&mut self) -> Result<(), RobotError>;

    /// The bodies in the container, as far as they are known.
    fn bodies(&self) -> Vec<Body>;

    /// Looks at the container with each of its sensors.
    ///
    /// # Errors
    /// [`RobotError`] where a sensor gives nothing.
    fn capture(&mut self) -> Result<Vec<View>, RobotError>;
}
