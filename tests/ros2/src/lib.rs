//! The types of `ros/ppnpack_msgs` as hiroz makes them of its interface files, and processes of ppnpack to talk to.

pub mod process;

#[allow(missing_docs, clippy::all, unexpected_cfgs)]
mod generated {
    include!(concat!(env!("OUT_DIR"), "/generated.rs"));
}

// The generated code looks for it at the root of its crate.
use hiroz_msgs::size_estimation;

use hiroz::action::ZAction;
use hiroz::entity::{TypeHash, TypeInfo};

pub use generated::ros::ppnpack_msgs;

/// The action `Pack`. Of `CancelGoal` hiroz 0.2.1 has another hash than ROS (<https://github.com/ZettaScaleLabs/hiroz/pull/354>): it is given
/// that of ROS, which others of its users have measured.
pub struct Pack;

/// The hash of `action_msgs/srv/CancelGoal`.
const CANCEL_GOAL: &str = "RIHS01_573d8b0a534451d7bc2ac8c5ffde8ac14b8593b7001175d0cd6516dcbeb8689a";

impl ZAction for Pack {
    type Goal = ppnpack_msgs::PackGoal;
    type Result = ppnpack_msgs::PackResult;
    type Feedback = ppnpack_msgs::PackFeedback;

    fn name() -> &'static str {
        ppnpack_msgs::action::Pack::name()
    }

    fn send_goal_type_info() -> TypeInfo {
        ppnpack_msgs::action::Pack::send_goal_type_info()
    }

    fn get_result_type_info() -> TypeInfo {
        ppnpack_msgs::action::Pack::get_result_type_info()
    }

    fn cancel_goal_type_info() -> TypeInfo {
        let hash = TypeHash::from_rihs_string(CANCEL_GOAL).unwrap_or_else(TypeHash::zero);
        TypeInfo::new("action_msgs::srv::dds_::CancelGoal_", hash)
    }

    fn feedback_type_info() -> TypeInfo {
        ppnpack_msgs::action::Pack::feedback_type_info()
    }

    fn status_type_info() -> TypeInfo {
        ppnpack_msgs::action::Pack::status_type_info()
    }
}
