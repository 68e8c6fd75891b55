//! `std_msgs`.

use super::builtin_interfaces::Time;
use super::messages;

messages! {
    /// When a message's content was so, and in which frame its coordinates are.
    Header = "std_msgs/msg/Header" {
        /// When.
        stamp: Time,
        /// The frame.
        frame_id: String,
    }

    /// A colour and how opaque it is, each from 0 to 1.
    ColorRgba = "std_msgs/msg/ColorRGBA" {
        /// Red.
        r: f32,
        /// Green.
        g: f32,
        /// Blue.
        b: f32,
        /// How opaque.
        a: f32,
    }

    /// `std_msgs/msg/String`: a text.
    Text = "std_msgs/msg/String" {
        /// The text.
        data: String,
    }
}
