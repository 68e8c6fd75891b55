//! Clouds of ROS 2: `sensor_msgs/PointCloud2` as `rmw_zenoh` and the bridge of ROS 2 over DDS put
//! it on Zenoh.
//!
//! [`PointCloud2::read`] takes a payload apart without copying the points, [`to_cloud`] checks it
//! and gives the workspace's own message. [`topic`] reads the keys.
//!
//! The reader is written here: it leaves the points where they lie, which are megabytes, and takes
//! memory for what a message has, never for what it announces. The tests hold it against
//! `cdr-encoding`.

mod cdr;
mod fields;
mod message;
mod points;
pub mod topic;

use nalgebra::Isometry3;

use crate::convert::{cloud, pose};
use crate::error::WireError;
use crate::v1;

use fields::Fields;
pub use message::{PointCloud2, PointField, Stamp, datatype};
use points::Rows;

/// Makes a cloud of one of ROS 2; its points are copied once, when everything else is known to be
/// possible.
///
/// Rows lose their padding, and big-endian points become little-endian. Fields that a
/// [`v1::PackedField`] cannot name are left out: arrays, 64-bit integers, booleans, and those
/// beyond the maximum number. So are those of big-endian points that share other bytes with an
/// earlier field. `frame_id` is not read: `container_from_sensor` is the pose of the sensor. The
/// state of the cell is not known to ROS, so it is 0; `sequence` counts the clouds of the sensor,
/// from 1.
///
/// # Errors
/// [`WireError`] where the size of the data, a field, the stamp, the sequence or the pose is
/// impossible.
pub fn to_cloud(
    message: &PointCloud2<'_>,
    sequence: u64,
    container_from_sensor: &Isometry3<f64>,
) -> Result<v1::PointCloud, WireError> {
    let rows = Rows::of(message)?;
    let fields = Fields::of(message)?;
    let mut made = v1::PointCloud {
        sequence,
        captured_at_ns: message.stamp.nanoseconds()?,
        container_from_sensor: Some(pose::write(container_from_sensor)),
        point_stride: message.point_step,
        fields: fields.packed,
        ..v1::PointCloud::default()
    };
    cloud::read(&made)?;
    made.data = rows.copy();
    if message.is_bigendian {
        let stride = usize::try_from(message.point_step).unwrap_or(usize::MAX);
        points::swap(&mut made.data, stride, &fields.numbers);
    }
    Ok(made)
}
