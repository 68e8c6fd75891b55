//! The services of `ppnpack_msgs`. `ros/ppnpack_msgs` has the same for ROS.

use super::ppnpack_msgs::{Announcement, Decision, Outcome};
use super::{messages, services};

messages! {
    /// Tells of items that arrive, in their order: 1 to 1,000.
    AnnounceRequest = "ppnpack_msgs/srv/Announce_Request" {
        /// The items.
        items: Vec<Announcement>,
    }

    /// What came of it.
    AnnounceResponse = "ppnpack_msgs/srv/Announce_Response" {
        /// Whether it was done.
        success: bool,
        /// Why not, for people.
        message: String,
    }

    /// Begins the packing of a container; what was known of those before is put away.
    BeginRequest = "ppnpack_msgs/srv/Begin_Request" {
        /// Names the session: 1 to 64 characters of A-Z a-z 0-9 _ . : -.
        session_id: String,
        /// Whether the planner has each decision carried out by the bridge, until nothing is left or nothing fits.
        is_automatic: bool,
        /// The least state of the cell that shows the container to be packed; 0: any.
        least_state_number: u64,
        /// Whether a decision of the session before that awaits its outcome is given up.
        gives_up_pending: bool,
    }

    /// What came of it.
    BeginResponse = "ppnpack_msgs/srv/Begin_Response" {
        /// Whether it was done.
        success: bool,
        /// Why not, for people.
        message: String,
    }

    /// Somebody had a hand in the container: it has to be seen again.
    ChangedRequest = "ppnpack_msgs/srv/Changed_Request" {
        /// The items that were taken out.
        removed_item_ids: Vec<String>,
    }

    /// What came of it.
    ChangedResponse = "ppnpack_msgs/srv/Changed_Response" {
        /// Whether it was done.
        success: bool,
        /// Why not, for people.
        message: String,
    }

    /// From now on nothing is begun, until the cell is resumed. This is no safety-rated stop.
    HoldRequest = "ppnpack_msgs/srv/Hold_Request" {
        /// Why, for people.
        reason: String,
        /// Whether what is under way is broken off, where the robot can.
        is_aborting: bool,
    }

    /// What came of it.
    HoldResponse = "ppnpack_msgs/srv/Hold_Response" {
        /// Whether it was done.
        success: bool,
        /// Why not, for people.
        message: String,
    }

    /// Which item of the buffer goes where. Report the outcome of the decision before the next one is asked for.
    PlanRequest = "ppnpack_msgs/srv/Plan_Request" {
        /// Nothing: no message is empty.
        structure_needs_at_least_one_member: u8,
    }

    /// What came of it.
    PlanResponse = "ppnpack_msgs/srv/Plan_Response" {
        /// Whether it was done.
        success: bool,
        /// Why not, for people.
        message: String,
        /// With success: one of the constants.
        result: u8,
        /// With DECIDED.
        decision: Decision,
    }

    /// How a decision was carried out, by a controller that drives the robot itself.
    ReportRequest = "ppnpack_msgs/srv/Report_Request" {
        /// Which decision.
        decision_id: String,
        /// How it ended.
        outcome: Outcome,
    }

    /// What came of it.
    ReportResponse = "ppnpack_msgs/srv/Report_Response" {
        /// Whether it was done.
        success: bool,
        /// Why not, for people.
        message: String,
    }

    /// An item will not come, or was taken away.
    WithdrawRequest = "ppnpack_msgs/srv/Withdraw_Request" {
        /// Which item.
        item_id: String,
    }

    /// What came of it.
    WithdrawResponse = "ppnpack_msgs/srv/Withdraw_Response" {
        /// Whether it was done.
        success: bool,
        /// Why not, for people.
        message: String,
    }
}

impl PlanResponse {
    /// There is a decision, which awaits its outcome.
    pub const DECIDED: u8 = 1;
    /// No item of the buffer has a valid placement; the message says why.
    pub const NOTHING_FITS: u8 = 2;
    /// No item is waiting.
    pub const NOTHING_WAITS: u8 = 3;
}

services! {
    /// Tells of items that arrive, in their order: 1 to 1,000.
    Announce = "ppnpack_msgs/srv/Announce" (AnnounceRequest => AnnounceResponse)

    /// Begins the packing of a container; what was known of those before is put away.
    Begin = "ppnpack_msgs/srv/Begin" (BeginRequest => BeginResponse)

    /// Somebody had a hand in the container: it has to be seen again.
    Changed = "ppnpack_msgs/srv/Changed" (ChangedRequest => ChangedResponse)

    /// From now on nothing is begun, until the cell is resumed. This is no safety-rated stop.
    Hold = "ppnpack_msgs/srv/Hold" (HoldRequest => HoldResponse)

    /// Which item of the buffer goes where. Report the outcome of the decision before the next one is asked for.
    Plan = "ppnpack_msgs/srv/Plan" (PlanRequest => PlanResponse)

    /// How a decision was carried out, by a controller that drives the robot itself.
    Report = "ppnpack_msgs/srv/Report" (ReportRequest => ReportResponse)

    /// An item will not come, or was taken away.
    Withdraw = "ppnpack_msgs/srv/Withdraw" (WithdrawRequest => WithdrawResponse)
}
