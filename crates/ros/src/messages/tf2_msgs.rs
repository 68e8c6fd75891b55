//! `tf2_msgs`.

use super::geometry_msgs::TransformStamped;
use super::messages;

messages! {
    /// Where frames are.
    TfMessage = "tf2_msgs/msg/TFMessage" {
        /// One for each frame.
        transforms: Vec<TransformStamped>,
    }
}
