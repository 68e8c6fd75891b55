//! Names and counts, in words.

use std::time::Duration;

/// Gives the name of an enum's value without its kind: `REASON_NO_FIT` of `REASON_` is `no_fit`.
pub(super) fn short(value: &str, kind: &str) -> String {
    let own = value.strip_prefix(kind).unwrap_or(value);
    own.to_ascii_lowercase()
}

pub(super) fn items(count: usize) -> String {
    match count {
        1 => "1 item".to_owned(),
        count => format!("{count} items"),
    }
}

/// Names an item, by its object where that has a name.
pub(super) fn item<'a>(object: &'a str, item_id: &'a str) -> &'a str {
    if object.is_empty() { item_id } else { object }
}

/// Says the time between two moments, in milliseconds since 1970, in whole seconds.
pub(super) fn seconds(since_ms: u64, now_ms: u64) -> String {
    let passed = Duration::from_millis(now_ms.saturating_sub(since_ms));
    format!("{} s", passed.as_secs())
}
