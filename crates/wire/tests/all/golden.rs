//! Every message has the encoding that was recorded. `PPNPACK_RECORD=1` records it anew.

use std::collections::BTreeSet;
use std::fmt::Write;

use prost::Message;

use crate::support::filled::{filled, pool};

const FILE: &str = "encodings.txt";

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        write!(text, "{byte:02x}").unwrap();
        text
    })
}

/// How many ways there are to fill a message.
fn alternatives(message: &prost_reflect::MessageDescriptor) -> usize {
    let most = message.oneofs().map(|oneof| oneof.fields().len()).max();
    most.unwrap_or(1)
}

#[test]
fn the_list_of_messages_is_complete() {
    let pool = pool();
    let messages: Vec<_> = pool.all_messages().collect();
    let expected: BTreeSet<&str> = messages.iter().map(|message| message.full_name()).collect();
    let known = crate::support::known();
    let known: BTreeSet<&str> = known.iter().map(|known| known.name.as_str()).collect();
    let other: Vec<_> = expected.symmetric_difference(&known).collect();
    assert!(
        other.is_empty(),
        "add to or take from tests/all/support/mod.rs: {other:?}"
    );
}

#[test]
fn every_message_is_encoded_as_it_was_recorded() {
    let pool = pool();
    let mut text = String::new();
    for known in crate::support::known() {
        let message = pool.get_message_by_name(&known.name).unwrap();
        for alternative in 0..alternatives(&message) {
            let bytes = filled(&message, alternative).encode_to_vec();
            let recoded = (known.recode)(&bytes).unwrap();
            assert_eq!(hex(&recoded), hex(&bytes), "{}", known.name);
            writeln!(text, "{} {alternative} {}", message.name(), hex(&bytes)).unwrap();
        }
    }
    if crate::support::record(FILE, &text) {
        return;
    }
    let recorded = crate::support::recorded(FILE);
    let mut recorded = recorded.lines();
    for line in text.lines() {
        let name = line.split(' ').next().unwrap();
        assert_eq!(
            recorded.next(),
            Some(line),
            "{name} is encoded differently; where only fields were added, record it with PPNPACK_RECORD=1"
        );
    }
    assert_eq!(recorded.next(), None, "a message is gone");
}
