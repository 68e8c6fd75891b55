//! `ppnpack_msgs`: what a cell says, and what can be asked of it. `ros/ppnpack_msgs` has the same for ROS.

use super::geometry_msgs::Pose;
use super::messages;
use super::std_msgs::Header;

messages! {
    /// An item that arrives.
    Announcement = "ppnpack_msgs/msg/Announcement" {
        /// Names this very item: 1 to 64 characters of A-Z a-z 0-9 _ . : -, each used once in a session.
        item_id: String,
        /// The object that it is, of the planner's catalogue.
        object: String,
        /// No other item may be placed above any part of it.
        is_fragile: bool,
        /// It must stand on the container's floor.
        is_bottom_only: bool,
        /// It must not fall over.
        is_upright: bool,
    }

    /// Something that was placed in the container.
    Body = "ppnpack_msgs/msg/Body" {
        /// Which item.
        item_id: String,
        /// The object that it is.
        object: String,
        /// Where the item's own frame is, in the frame of the header.
        pose: Pose,
        /// Whether it lies within the container.
        is_inside: bool,
        /// Whether the pose was found, as by a camera; else it is assumed.
        is_found: bool,
    }

    /// The state of a cell, or of one of its containers.
    CellState = "ppnpack_msgs/msg/CellState" {
        /// When it came, in the container's frame.
        header: Header,
        /// Counts the changes of the container's content.
        state_number: u64,
        /// The placement that is being executed; empty where none is.
        executing_placement_id: String,
        /// What lies in the container.
        bodies: Vec<Body>,
        /// Whether the cell is simulated.
        is_simulated: bool,
        /// Whether nothing is begun, and why.
        is_held: bool,
        /// Why nothing is begun, for people.
        hold_reason: String,
    }

    /// What the planner decided: which item goes where.
    Decision = "ppnpack_msgs/msg/Decision" {
        /// When it came, in the container's frame.
        header: Header,
        /// Names the decision, and the placement that carries it out.
        decision_id: String,
        /// Names the session.
        session_id: String,
        /// The number of the step in its session, from 0.
        step: u64,
        /// Which item.
        item_id: String,
        /// The object that it is.
        object: String,
        /// The container that it goes into; empty in a cell with one.
        container: String,
        /// Which of the item's resting poses.
        resting_pose: u32,
        /// Where the item's own frame shall be.
        pose: Pose,
        /// The value of the placement; lower is better.
        value: f64,
        /// The items that could be chosen, in their order.
        buffer: Vec<String>,
        /// The state of the cell that it was planned on.
        state_number: u64,
        /// When it was decided, by the clock of the bridge, in nanoseconds.
        decided_at_ns: u64,
        /// Why it was not made in the way that was configured, where it was not.
        degraded: Vec<String>,
    }

    /// An item of a session.
    Item = "ppnpack_msgs/msg/Item" {
        /// Which item.
        item_id: String,
        /// The object that it is.
        object: String,
        /// One of the constants.
        state: u8,
        /// With PACKED: the container that it lies in, empty in a cell with one, and where its own frame is there.
        container: String,
        /// Where its own frame is.
        pose: Pose,
    }

    /// How a placement ended.
    Outcome = "ppnpack_msgs/msg/Outcome" {
        /// When it came, in the container's frame.
        header: Header,
        /// Which placement.
        placement_id: String,
        /// Which item.
        item_id: String,
        /// One of the constants.
        kind: u8,
        /// What went wrong, for people; empty where the item was placed.
        failure: String,
        /// Where the item's own frame is now, where has_pose says that this is known.
        has_pose: bool,
        /// Where its own frame is.
        pose: Pose,
        /// Whether that was found, as by a camera; else it is assumed.
        is_found: bool,
        /// Whether the item's centre of mass is inside the container.
        is_inside: bool,
        /// Horizontal distance of the item's centre of mass from where it was planned, in metres.
        slide_m: f64,
        /// How far the item tilted, in radians.
        tilt_rad: f64,
        /// The state of the cell afterwards.
        state_number: u64,
    }

    /// A packing session, as the planner has it on disk.
    Session = "ppnpack_msgs/msg/Session" {
        /// When it came, and the frame of its coordinates.
        header: Header,
        /// Empty before the first session of a cell.
        session_id: String,
        /// The items in the order in which they were announced.
        items: Vec<Item>,
        /// The decision that awaits its outcome; empty where none does.
        pending_decision_id: String,
        /// How many decisions were made.
        step: u64,
        /// Whether the planner has its decisions carried out itself.
        is_automatic: bool,
        /// How many of the waiting items may be chosen from.
        buffer: u32,
        /// Why the automatic mode came to its end, if it did; with FAILED what happened.
        end: u8,
        /// What happened, for people.
        failure: String,
    }
}

impl Item {
    /// Not packed yet.
    pub const WAITING: u8 = 1;
    /// Its decision awaits the outcome.
    pub const DECIDED: u8 = 2;
    /// In the container.
    pub const PACKED: u8 = 3;
    /// Lost, or in an unknown place.
    pub const GONE: u8 = 4;
    /// Withdrawn before it was decided on.
    pub const WITHDRAWN: u8 = 5;
    /// Left for the next container.
    pub const SET_ASIDE: u8 = 6;
}

impl Outcome {
    /// The item was released in the container.
    pub const PLACED: u8 = 1;
    /// Nothing in the container was changed and the item is where it was.
    pub const NOT_PLACED: u8 = 2;
    /// The item left the cell.
    pub const LOST: u8 = 3;
    /// It is not known how it ended.
    pub const UNKNOWN: u8 = 4;
}

impl Session {
    /// It is under way.
    pub const UNDER_WAY: u8 = 0;
    /// Every item that was announced is packed or gone.
    pub const ALL_PACKED: u8 = 1;
    /// Nothing in the buffer has a valid placement.
    pub const NOTHING_FITS: u8 = 2;
    /// Somebody has to look.
    pub const FAILED: u8 = 3;
    /// Every item is packed or gone, but for those that are set aside.
    pub const OTHERS_SET_ASIDE: u8 = 4;
}
