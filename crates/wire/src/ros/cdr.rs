//! Plain CDR: how ROS 2 puts messages into bytes.
//!
//! A payload is an encapsulation header of four bytes, two that name the encoding and two of
//! options, and the message. A number of N bytes begins at a multiple of N from the end of the
//! header. A text is its length as a 32-bit number, the terminating zero included, and its bytes; a
//! sequence is the number of its elements and these. Source: OMG DDS-XTypes 1.3, sections 7.4.1
//! (encoding version 1) and 7.6.3.1.2 (encapsulation); the numbers of the encodings there and in
//! DDSI-RTPS 2.5, section 10.5, which differ for the second version.

use crate::error::WireError;
use crate::limits::checked;

const MAX_TEXT_BYTES: usize = 256;

/// Reads a message from the front.
#[derive(Debug)]
pub(super) struct Reader<'a> {
    /// The rest of the payload after the encapsulation header.
    body: &'a [u8],
    at: usize,
    is_big_endian: bool,
}

impl<'a> Reader<'a> {
    /// Reads the encapsulation header.
    pub(super) fn new(payload: &'a [u8]) -> Result<Self, WireError> {
        let refused = |reason: String| Err(WireError::invalid("encapsulation", reason));
        let Some((header, body)) = payload.split_first_chunk::<4>() else {
            let bytes = payload.len();
            return refused(format!("4 bytes are needed where {bytes} are left"));
        };
        let [high, low, _, _] = *header;
        let number = u16::from_be_bytes([high, low]);
        let other = match number {
            0 | 1 => {
                return Ok(Self {
                    body,
                    at: 0,
                    is_big_endian: number == 0,
                });
            }
            2 | 3 => "PL_CDR",
            4 => "XML",
            6 | 7 | 0x10 | 0x11 => "PLAIN_CDR2",
            8 | 9 | 0x14 | 0x15 => "DELIMITED_CDR2",
            0x0a | 0x0b | 0x12 | 0x13 => "PL_CDR2",
            _ => {
                let unknown = "is no encoding that is known, where PLAIN_CDR is needed";
                return refused(format!("0x{number:04x} {unknown}"));
            }
        };
        refused(format!("{other} is not read, only PLAIN_CDR is"))
    }

    fn take(&mut self, field: &'static str, count: usize) -> Result<&'a [u8], WireError> {
        let left = self.body.get(self.at..).unwrap_or(&[]);
        let needed = format_args!("{count} bytes are needed");
        let found = format_args!("{} are left", left.len());
        checked(field, needed, count <= left.len(), found)?;
        self.at += count;
        Ok(left.get(..count).unwrap_or(left))
    }

    pub(super) fn uint8(&mut self, field: &'static str) -> Result<u8, WireError> {
        Ok(self.take(field, 1)?.first().copied().unwrap_or_default())
    }

    pub(super) fn boolean(&mut self, field: &'static str) -> Result<bool, WireError> {
        let value = self.uint8(field)?;
        checked(field, value, value <= 1, "0 or 1 is needed").map(|value| value == 1)
    }

    pub(super) fn uint32(&mut self, field: &'static str) -> Result<u32, WireError> {
        self.at = self.at.next_multiple_of(4);
        let bytes = self.take(field, 4)?.first_chunk().copied();
        let bytes = bytes.unwrap_or_default();
        Ok(match self.is_big_endian {
            true => u32::from_be_bytes(bytes),
            false => u32::from_le_bytes(bytes),
        })
    }

    pub(super) fn int32(&mut self, field: &'static str) -> Result<i32, WireError> {
        self.uint32(field).map(u32::cast_signed)
    }

    /// Reads a length, which counts bytes or elements.
    fn length(&mut self, field: &'static str) -> Result<usize, WireError> {
        let length = self.uint32(field)?;
        Ok(usize::try_from(length).unwrap_or(usize::MAX))
    }

    /// Gives a sequence of bytes, where it lies.
    pub(super) fn bytes(&mut self, field: &'static str) -> Result<&'a [u8], WireError> {
        let length = self.length(field)?;
        self.take(field, length)
    }

    /// Reads the number of a sequence's elements: at most `limit`, and no more than the rest has
    /// room for.
    pub(super) fn elements(
        &mut self,
        field: &'static str,
        least_bytes: usize,
        limit: usize,
    ) -> Result<usize, WireError> {
        let count = self.length(field)?;
        let left = self.body.len().saturating_sub(self.at);
        let found = format_args!("{count} elements");
        let possible = format_args!("at most {limit} are possible");
        checked(field, found, count <= limit, possible)?;
        let needed = format_args!("{count} elements are needed");
        let has_room = count <= left / least_bytes.max(1);
        let found = format_args!("{left} bytes are left");
        checked(field, needed, has_room, found)?;
        Ok(count)
    }

    /// Reads a text. An empty one may lack its terminating zero: some write it so.
    pub(super) fn text(&mut self, field: &'static str) -> Result<&'a str, WireError> {
        let refused = |reason: &str| WireError::invalid(field, reason);
        let text = match self.bytes(field)?.split_last() {
            None => &[],
            Some((0, text)) => text,
            Some(_) => return Err(refused("the text has no terminating zero")),
        };
        let found = format_args!("{} bytes", text.len());
        let possible = format_args!("{MAX_TEXT_BYTES} are possible");
        checked(field, found, text.len() <= MAX_TEXT_BYTES, possible)?;
        str::from_utf8(text).map_err(|_| refused("the text is not UTF-8"))
    }
}
