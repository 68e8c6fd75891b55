//! `action_msgs`: what all actions have in common.

use super::builtin_interfaces::Time;
use super::unique_identifier_msgs::Uuid;
use super::{messages, services};

messages! {
    /// A goal, and when it was accepted.
    GoalInfo = "action_msgs/msg/GoalInfo" {
        /// Its id.
        goal_id: Uuid,
        /// When it was accepted.
        stamp: Time,
    }

    /// How far a goal is.
    GoalStatus = "action_msgs/msg/GoalStatus" {
        /// Which one.
        goal_info: GoalInfo,
        /// How far it is, as [`crate::action::Status`] numbers it.
        status: i8,
    }

    /// How far goals are.
    GoalStatusArray = "action_msgs/msg/GoalStatusArray" {
        /// One for each goal that is known.
        status_list: Vec<GoalStatus>,
    }

    /// Which goals are to be cancelled: that of the id, and all that were accepted up to the time; where both are zero, all.
    CancelGoalRequest = "action_msgs/srv/CancelGoal_Request" {
        /// Which.
        goal_info: GoalInfo,
    }

    /// Which goals are being cancelled.
    CancelGoalResponse = "action_msgs/srv/CancelGoal_Response" {
        /// One of the constants.
        return_code: i8,
        /// Which.
        goals_canceling: Vec<GoalInfo>,
    }
}

impl CancelGoalResponse {
    /// At least one goal is being cancelled.
    pub const ERROR_NONE: i8 = 0;
    /// None of the goals can be cancelled.
    pub const ERROR_REJECTED: i8 = 1;
    /// No goal has the id.
    pub const ERROR_UNKNOWN_GOAL_ID: i8 = 2;
    /// The goal has ended.
    pub const ERROR_GOAL_TERMINATED: i8 = 3;
}

services! {
    /// Cancels goals.
    CancelGoal = "action_msgs/srv/CancelGoal" (CancelGoalRequest => CancelGoalResponse)
}
