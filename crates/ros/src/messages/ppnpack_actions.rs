//! The action of `ppnpack_msgs`. `ros/ppnpack_msgs` has the same for ROS.

use super::messages;
use super::ppnpack_msgs::{Announcement, Item};
use crate::action::Action;

messages! {
    /// Packs items into the container as it is, in a session of their own: the planner decides, the bridge's robot places.
    /// Cancelled, it ends with the placement that is under way.
    PackGoal = "ppnpack_msgs/action/Pack_Goal" {
        /// Names the session: 1 to 64 characters of A-Z a-z 0-9 _ . : -; empty: the goal's id does.
        session_id: String,
        /// The items in the order of their arrival: 1 to 1,000.
        items: Vec<Announcement>,
    }

    /// How a packing ended.
    PackResult = "ppnpack_msgs/action/Pack_Result" {
        /// Why it ended, as in Session; UNDER_WAY where it was cancelled.
        end: u8,
        /// What became of the items, in the order in which they were announced.
        items: Vec<Item>,
        /// How many items are packed.
        packed: u32,
        /// What happened, for people, where not everything was packed.
        message: String,
    }

    /// How far a packing is.
    PackFeedback = "ppnpack_msgs/action/Pack_Feedback" {
        /// How many items are packed, and how many wait.
        packed: u32,
        /// How many items wait.
        waiting: u32,
        /// Those that were packed, or lost, since the last feedback.
        items: Vec<Item>,
    }
}

/// Packs items into a container, in a session of their own.
#[derive(Debug, Clone, Copy)]
pub struct Pack;

impl Action for Pack {
    type Goal = PackGoal;
    type Result = PackResult;
    type Feedback = PackFeedback;

    fn type_name() -> String {
        "ppnpack_msgs/action/Pack".to_owned()
    }
}
