//! Messages as bytes: plain CDR, after the four bytes that say so.
//!
//! What is written is little-endian; what is read may be of either order, as the first bytes say.
//! Source: OMG DDS-XTypes 1.3, sections 7.4.1 and 7.6.3.1.2.

use byteorder::{BigEndian, LittleEndian};

use super::messages::{Message, Trigger};
use crate::error::RosError;

/// Plain CDR, little-endian, without options.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// Gives the bytes of a message.
///
/// # Errors
/// [`RosError::Message`] where a sequence or a text is longer than CDR can say.
pub(crate) fn encode<M: Message>(message: &M) -> Result<Vec<u8>, RosError> {
    let body = cdr_encoding::to_vec::<M, LittleEndian>(message);
    // Alignment counts from the end of the encapsulation.
    let body = body.map_err(RosError::message::<M>)?;
    Ok([&ENCAPSULATION[..], &body].concat())
}

/// Reads the message that bytes are. What follows it is not looked at: some pad.
///
/// # Errors
/// [`RosError::Message`] where they are no such message.
pub(crate) fn decode<M: Message>(payload: &[u8]) -> Result<M, RosError> {
    let Some((&[0, order @ (0 | 1), _, _], body)) = payload.split_first_chunk::<4>() else {
        return Err(RosError::message::<M>("plain CDR is needed"));
    };
    // Some leave the one byte of an empty message out.
    let body: &[u8] = match body {
        [] if M::NAME == Trigger::NAME => &[0],
        body => body,
    };
    let read = match order {
        0 => cdr_encoding::from_bytes::<M, BigEndian>(body),
        _ => cdr_encoding::from_bytes::<M, LittleEndian>(body),
    };
    read.map(|(message, _)| message)
        .map_err(RosError::message::<M>)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::messages::{Announce, Announcement, Begin, CellState, Hold};
    use super::*;

    fn hold(reason: &str) -> Hold {
        Hold {
            reason: reason.to_owned(),
            is_aborting: true,
        }
    }

    #[test]
    fn bytes_are_those_that_the_format_prescribes() {
        let hello = [&[0, 1, 0, 0, 6, 0, 0, 0][..], b"hello\0\x01"];
        assert_eq!(encode(&hold("hello")).unwrap(), hello.concat());
        assert_eq!(encode(&Trigger::default()).unwrap(), [0, 1, 0, 0, 0]);
        assert!(decode::<Trigger>(&[0, 1, 0, 0]).is_ok());
        // A number begins at a multiple of its size from the end of the first four bytes.
        let begin = Begin {
            is_automatic: true,
            least_state_number: 3,
            ..Begin::default()
        };
        let parts: [&[u8]; 4] = [
            &[0, 1, 0, 0, 1, 0, 0, 0],
            &[0, 1, 0, 0, 3, 0, 0, 0],
            &[0; 4],
            &[0],
        ];
        assert_eq!(encode(&begin).unwrap(), parts.concat());
    }

    #[test]
    fn both_orders_of_bytes_are_read() {
        let big = [&[0, 0, 0, 0, 0, 0, 0, 3][..], b"hi\0\x01"].concat();
        assert_eq!(decode::<Hold>(&big).unwrap(), hold("hi"));
        let refused: [(&[u8], &str); 5] = [
            (&[], "nothing"),
            (&[0, 1, 0, 0], "no message"),
            (&[0, 3, 0, 0, 1, 0, 0, 0, 0, 0], "another encoding"),
            (
                &[0, 1, 0, 0, 255, 255, 255, 255, 0],
                "a length without its text",
            ),
            (&[0, 1, 0, 0, 2, 0, 0, 0, 0xff, 0, 0], "no UTF-8"),
        ];
        for (payload, what) in refused {
            assert!(decode::<Hold>(payload).is_err(), "{what}");
        }
    }

    proptest! {
        #[test]
        fn messages_are_read_as_they_were_written_and_refused_where_they_are_cut(
            items in proptest::collection::vec((".{0,8}", any::<bool>()), 1..4),
            cut in any::<prop::sample::Index>(),
        ) {
            let items = items.into_iter().map(|(item_id, is_fragile)| Announcement {
                item_id,
                is_fragile,
                ..Announcement::default()
            });
            let message = Announce { items: items.collect() };
            let payload = encode(&message).unwrap();
            prop_assert_eq!(decode::<Announce>(&payload).unwrap(), message);
            prop_assert!(decode::<Announce>(&payload[..cut.index(payload.len())]).is_err());
        }

        #[test]
        fn whatever_comes_is_read_or_refused(payload in proptest::collection::vec(any::<u8>(), 0..200)) {
            decode::<CellState>(&payload).ok();
        }
    }
}
