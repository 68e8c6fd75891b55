//! `service_msgs`: what tells of requests; it is a part of the hash of each service.

use super::builtin_interfaces::Time;
use super::messages;

messages! {
    /// A request or a response that went by.
    ServiceEventInfo = "service_msgs/msg/ServiceEventInfo" {
        /// Which of them.
        event_type: u8,
        /// When.
        stamp: Time,
        /// Who asks.
        client_gid: [u8; 16],
        /// Which of their requests.
        sequence_number: i64,
    }
}
