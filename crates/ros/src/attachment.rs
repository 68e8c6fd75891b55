//! What goes with each message and request: who sent it, when, and which one it is.

use std::time::{SystemTime, UNIX_EPOCH};

use zenoh::bytes::ZBytes;

/// Names an endpoint.
pub(crate) type Gid = [u8; 16];

/// The bytes of an attachment: two numbers, the length of the name, the name.
const BYTES: usize = 8 + 8 + 1 + 16;

/// What goes with a message or a request. A response has that of its request, but for the time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Attachment {
    /// Counts what the endpoint sends.
    pub(crate) sequence: i64,
    /// When it was sent, in nanoseconds since 1970.
    pub(crate) sent_at_ns: i64,
    /// Who sent it.
    pub(crate) gid: Gid,
}

impl Attachment {
    /// Of something that is sent now.
    pub(crate) fn now(sequence: i64, gid: Gid) -> Self {
        Self {
            sequence,
            sent_at_ns: now_ns(),
            gid,
        }
    }

    /// As bytes.
    pub(crate) fn to_bytes(self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(BYTES);
        bytes.extend_from_slice(&self.sequence.to_le_bytes());
        bytes.extend_from_slice(&self.sent_at_ns.to_le_bytes());
        bytes.push(16);
        bytes.extend_from_slice(&self.gid);
        bytes
    }

    /// Reads one; `None` where it is none.
    pub(crate) fn read(bytes: &ZBytes) -> Option<Self> {
        if bytes.len() != BYTES {
            return None;
        }
        let bytes = bytes.to_bytes();
        let (sequence, rest) = bytes.split_first_chunk()?;
        let (sent_at_ns, rest) = rest.split_first_chunk()?;
        let (&[16], rest) = rest.split_first_chunk()? else {
            return None;
        };
        Some(Self {
            sequence: i64::from_le_bytes(*sequence),
            sent_at_ns: i64::from_le_bytes(*sent_at_ns),
            gid: *rest.first_chunk()?,
        })
    }
}

/// The time of day, in nanoseconds since 1970.
pub(crate) fn now_ns() -> i64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    now.map_or(0, |now| i64::try_from(now.as_nanos()).unwrap_or(i64::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_attachment_is_read_as_it_was_written() {
        let attachment = Attachment {
            sequence: 7,
            sent_at_ns: -2,
            gid: *b"0123456789abcdef",
        };
        let bytes = attachment.to_bytes();
        let expected: [&[u8]; 4] = [
            &[7, 0, 0, 0, 0, 0, 0, 0, 0xfe],
            &[0xff; 7],
            &[16],
            b"0123456789abcdef",
        ];
        assert_eq!(bytes, expected.concat());
        assert_eq!(
            Attachment::read(&ZBytes::from(bytes.clone())),
            Some(attachment)
        );
        for length in 0..bytes.len() {
            let cut = bytes[..length].to_vec();
            assert_eq!(Attachment::read(&ZBytes::from(cut)), None);
        }
    }
}
