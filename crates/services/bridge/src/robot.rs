//! The interface behind which a cell is: its robot, its container and its sensor.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Point3};
use ppnpack_catalogue::mesh::Bounds;
use ppnpack_packing::grid::ContainerSize;
pub use ppnpack_protocol::placing::{Body, Ending, Finding, KnownPose, Placement};
use ppnpack_service::Shutdown;

/// What a sensor of a cell sees.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// The sensor's name; empty where the cell has only one.
    pub sensor: String,
    /// Points in the sensor's frame, in metres.
    pub points_m: Vec<Point3<f32>>,
    /// Where the sensor is.
    pub container_from_sensor: Isometry3<f64>,
    /// Whether it is known that they show the cell as it is now: cameras that run by themselves may have looked before.
    pub is_of_now: bool,
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

    /// Looks at the container with each of its sensors.
    ///
    /// # Errors
    /// [`RobotError`] where a sensor gives nothing.
    fn capture(&mut self) -> Result<Vec<View>, RobotError>;
}
