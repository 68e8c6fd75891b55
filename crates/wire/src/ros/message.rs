//! `sensor_msgs/PointCloud2`, taken apart where it lies.

use super::cdr::Reader;
use super::topic::check_size;
use crate::error::WireError;
use crate::limits::checked;

/// Maximum number of fields that are read. Many drivers have more than a cloud of the workspace,
/// which keeps the first.
const MAX_FIELDS: usize = 256;

/// Minimum size of a field: an empty name, the offset, the type and the count.
const LEAST_FIELD_BYTES: usize = 4 + 4 + 1 + 4;

/// The types of fields, as `sensor_msgs/PointField` numbers them.
pub mod datatype {
    /// An integer with a sign of 8 bits.
    pub const INT8: u8 = 1;
    /// An integer without a sign of 8 bits.
    pub const UINT8: u8 = 2;
    /// An integer with a sign of 16 bits.
    pub const INT16: u8 = 3;
    /// An integer without a sign of 16 bits.
    pub const UINT16: u8 = 4;
    /// An integer with a sign of 32 bits.
    pub const INT32: u8 = 5;
    /// An integer without a sign of 32 bits.
    pub const UINT32: u8 = 6;
    /// A number of 32 bits.
    pub const FLOAT32: u8 = 7;
    /// A number of 64 bits.
    pub const FLOAT64: u8 = 8;
    /// An integer with a sign of 64 bits; in newer releases.
    pub const INT64: u8 = 9;
    /// An integer without a sign of 64 bits; in newer releases.
    pub const UINT64: u8 = 10;
    /// A truth value of 8 bits; in newer releases.
    pub const BOOLEAN: u8 = 11;
}

/// `builtin_interfaces/Time`: since 1970.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Stamp {
    /// Whole seconds.
    pub sec: i32,
    /// The rest, in nanoseconds.
    pub nanosec: u32,
}

impl Stamp {
    /// Gives the nanoseconds since 1970.
    ///
    /// # Errors
    /// [`WireError::Invalid`] where the rest is a second or more.
    pub fn nanoseconds(self) -> Result<i64, WireError> {
        const SECOND_NS: u32 = 1_000_000_000;
        let field = "PointCloud2.header.stamp.nanosec";
        let needed = format_args!("less than {SECOND_NS} is needed");
        checked(field, self.nanosec, self.nanosec < SECOND_NS, needed)?;
        Ok(i64::from(self.sec) * i64::from(SECOND_NS) + i64::from(self.nanosec))
    }
}

/// `sensor_msgs/PointField`: a field of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PointField<'a> {
    /// Its name, such as "x".
    pub name: &'a str,
    /// Bytes from the beginning of the point.
    pub offset: u32,
    /// The type of its bytes; see [`datatype`].
    pub datatype: u8,
    /// The number of its elements. 0 means 1: some drivers write it so.
    pub count: u32,
}

/// `sensor_msgs/PointCloud2`. Names are those of ROS.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PointCloud2<'a> {
    /// The time of its capture.
    pub stamp: Stamp,
    /// The frame of the coordinates.
    pub frame_id: &'a str,
    /// Rows of points; 1 for clouds without rows.
    pub height: u32,
    /// Points in a row.
    pub width: u32,
    /// The fields of a point.
    pub fields: Vec<PointField<'a>>,
    /// Whether the points are big-endian, whatever the rest of the message is.
    pub is_bigendian: bool,
    /// Bytes from one point to the next.
    pub point_step: u32,
    /// Bytes from one row to the next.
    pub row_step: u32,
    /// The points.
    pub data: &'a [u8],
    /// Whether no point is a hole.
    pub is_dense: bool,
}

impl<'a> PointCloud2<'a> {
    /// Takes a payload in plain CDR apart. Whether its parts fit together,
    /// [`to_cloud`](super::to_cloud) checks.
    ///
    /// Bytes after the message are not read: publishers in shared memory send the rest of their
    /// buffer.
    ///
    /// # Errors
    /// [`WireError`] where it is larger than [`MAX_CLOUD_BYTES`](crate::MAX_CLOUD_BYTES), is
    /// encoded otherwise, or ends early, or where a length, a text or a truth value is impossible.
    pub fn read(payload: &'a [u8]) -> Result<Self, WireError> {
        check_size(payload.len())?;
        let mut reader = Reader::new(payload)?;
        // In the order of the message: the reader goes from field to field.
        Ok(Self {
            stamp: Stamp {
                sec: reader.int32("PointCloud2.header.stamp.sec")?,
                nanosec: reader.uint32("PointCloud2.header.stamp.nanosec")?,
            },
            frame_id: reader.text("PointCloud2.header.frame_id")?,
            height: reader.uint32("PointCloud2.height")?,
            width: reader.uint32("PointCloud2.width")?,
            fields: fields(&mut reader)?,
            is_bigendian: reader.boolean("PointCloud2.is_bigendian")?,
            point_step: reader.uint32("PointCloud2.point_step")?,
            row_step: reader.uint32("PointCloud2.row_step")?,
            data: reader.bytes("PointCloud2.data")?,
            is_dense: reader.boolean("PointCloud2.is_dense")?,
        })
    }
}

fn fields<'a>(reader: &mut Reader<'a>) -> Result<Vec<PointField<'a>>, WireError> {
    let count = reader.elements("PointCloud2.fields", LEAST_FIELD_BYTES, MAX_FIELDS)?;
    let field = |_| {
        Ok(PointField {
            name: reader.text("PointCloud2.fields.name")?,
            offset: reader.uint32("PointCloud2.fields.offset")?,
            datatype: reader.uint8("PointCloud2.fields.datatype")?,
            count: reader.uint32("PointCloud2.fields.count")?,
        })
    };
    (0..count).map(field).collect()
}
