//! Clouds of ROS 2 in plain CDR, as a driver publishes them: for tests, benchmarks and fuzzing.

use ppnpack_wire::ros::PointCloud2;

/// The payload of a message.
pub(crate) fn payload(message: &PointCloud2<'_>, is_big_endian: bool) -> Vec<u8> {
    let mut writer = Writer::new(is_big_endian);
    writer.uint32(message.stamp.sec.cast_unsigned());
    writer.uint32(message.stamp.nanosec);
    writer.text(message.frame_id);
    writer.uint32(message.height);
    writer.uint32(message.width);
    writer.length(message.fields.len());
    for field in &message.fields {
        writer.text(field.name);
        writer.uint32(field.offset);
        writer.uint8(field.datatype);
        writer.uint32(field.count);
    }
    writer.uint8(message.is_bigendian.into());
    writer.uint32(message.point_step);
    writer.uint32(message.row_step);
    writer.bytes(message.data);
    writer.uint8(message.is_dense.into());
    writer.finish()
}

/// Writes a message.
#[derive(Debug)]
struct Writer {
    /// What follows the encapsulation header.
    body: Vec<u8>,
    is_big_endian: bool,
}

impl Writer {
    fn new(is_big_endian: bool) -> Self {
        Self {
            body: Vec::new(),
            is_big_endian,
        }
    }

    /// The payload: the encapsulation header and the message.
    fn finish(self) -> Vec<u8> {
        let header = [0, u8::from(!self.is_big_endian), 0, 0];
        [header.as_slice(), self.body.as_slice()].concat()
    }

    fn uint8(&mut self, value: u8) {
        self.body.push(value);
    }

    fn uint32(&mut self, value: u32) {
        let bytes = if self.is_big_endian {
            value.to_be_bytes()
        } else {
            value.to_le_bytes()
        };
        self.body.resize(self.body.len().next_multiple_of(4), 0);
        self.body.extend_from_slice(&bytes);
    }

    /// A length, which counts bytes or elements; a sequence has no more than it can hold.
    fn length(&mut self, length: usize) {
        self.uint32(u32::try_from(length).unwrap_or(u32::MAX));
    }

    fn bytes(&mut self, bytes: &[u8]) {
        self.length(bytes.len());
        self.body.extend_from_slice(bytes);
    }

    fn text(&mut self, text: &str) {
        self.length(text.len() + 1);
        self.body.extend_from_slice(text.as_bytes());
        self.body.push(0);
    }
}
