//! `sensor_msgs`.

use super::messages;
use super::std_msgs::Header;
use crate::cdr::Bytes;

messages! {
    /// A field of a point.
    PointField = "sensor_msgs/msg/PointField" {
        /// Such as "x".
        name: String,
        /// Bytes from the beginning of the point.
        offset: u32,
        /// What the bytes are.
        datatype: u8,
        /// How many elements it has.
        count: u32,
    }

    /// A point cloud.
    PointCloud2 = "sensor_msgs/msg/PointCloud2" {
        /// When it was captured, and in which frame.
        header: Header,
        /// Rows of points; 1 where there are none.
        height: u32,
        /// Points in a row.
        width: u32,
        /// The fields of a point.
        fields: Vec<PointField>,
        /// Whether the points are big-endian.
        is_bigendian: bool,
        /// Bytes from one point to the next.
        point_step: u32,
        /// Bytes from one row to the next.
        row_step: u32,
        /// The points.
        data: Bytes,
        /// Whether every point is one.
        is_dense: bool,
    }

    /// An image as a file.
    CompressedImage = "sensor_msgs/msg/CompressedImage" {
        /// When it was taken, and in which frame.
        header: Header,
        /// What the file is.
        format: String,
        /// The file.
        data: Bytes,
    }
}

impl PointField {
    /// The type of numbers of 32 bits.
    pub const FLOAT32: u8 = 7;
}
