//! Clouds of ROS 2 in plain CDR, as a driver publishes them: for tests, benchmarks and fuzzing.
//!
//! They are written by another implementation of CDR than the one that reads them.

use byteorder::{BigEndian, LittleEndian};
use ppnpack_wire::ros::PointCloud2;

/// Gives the payload of a message.
pub(crate) fn payload(message: &PointCloud2<'_>, is_big_endian: bool) -> Vec<u8> {
    let fields = message.fields.iter();
    let fields: Vec<_> = fields
        .map(|field| (field.name, field.offset, field.datatype, field.count))
        .collect();
    let stamp = (message.stamp.sec, message.stamp.nanosec);
    // In the order of ROS. A message within it is its fields.
    let parts = (
        (stamp, message.frame_id),
        (message.height, message.width),
        fields,
        message.is_bigendian,
        (message.point_step, message.row_step),
        message.data,
        message.is_dense,
    );
    let (number, body) = match is_big_endian {
        true => (0, cdr_encoding::to_vec::<_, BigEndian>(&parts)),
        false => (1, cdr_encoding::to_vec::<_, LittleEndian>(&parts)),
    };
    [&[0, number, 0, 0], body.unwrap_or_default().as_slice()].concat()
}
