//! Services that need no types of their own.

use super::{messages, services};

messages! {
    /// Has something done.
    TriggerRequest = "std_srvs/srv/Trigger_Request" {
        /// Nothing: no message is empty.
        structure_needs_at_least_one_member: u8,
    }

    /// Whether it was done.
    TriggerResponse = "std_srvs/srv/Trigger_Response" {
        /// Whether it was done.
        success: bool,
        /// Why not.
        message: String,
    }

    /// Switches something.
    SetBoolRequest = "std_srvs/srv/SetBool_Request" {
        /// On or off.
        data: bool,
    }

    /// Whether it was switched.
    SetBoolResponse = "std_srvs/srv/SetBool_Response" {
        /// Whether it was done.
        success: bool,
        /// Why not.
        message: String,
    }
}

services! {
    /// Has something done.
    Trigger = "std_srvs/srv/Trigger" (TriggerRequest => TriggerResponse)

    /// Switches something.
    SetBool = "std_srvs/srv/SetBool" (SetBoolRequest => SetBoolResponse)
}
