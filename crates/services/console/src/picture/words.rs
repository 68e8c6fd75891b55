//! How things of the wire are called.

use std::time::Duration;

use ppnpack_wire::v1;

/// The name of an enum's value as it is shown: `REASON_NO_FIT` is `no_fit`.
fn short(name: &str, kind: &str) -> String {
    let own = name.strip_prefix(kind).unwrap_or(name);
    own.to_ascii_lowercase()
}

pub(crate) fn of_reason(reason: v1::Reason) -> String {
    short(reason.as_str_name(), "REASON_")
}

pub(crate) fn of_check(check: v1::Check) -> String {
    short(check.as_str_name(), "CHECK_")
}

pub(super) fn of_outcome(kind: v1::OutcomeKind) -> String {
    short(kind.as_str_name(), "OUTCOME_KIND_")
}

pub(super) fn of_closing(reason: v1::ClosingReason) -> String {
    short(reason.as_str_name(), "CLOSING_REASON_")
}

pub(super) fn of_inspection(kind: v1::InspectionKind) -> String {
    short(kind.as_str_name(), "INSPECTION_KIND_")
}

pub(super) fn of_state(state: v1::ItemState) -> String {
    short(state.as_str_name(), "ITEM_STATE_")
}

/// How an automatic mode ended; `None` while it has not.
pub(super) fn of_end(end: v1::SessionEnd) -> Option<String> {
    (end != v1::SessionEnd::Unspecified).then(|| short(end.as_str_name(), "SESSION_END_"))
}

/// So many items.
pub(super) fn items(count: usize) -> String {
    match count {
        1 => "1 item".to_owned(),
        count => format!("{count} items"),
    }
}

/// An item, by the name of its object where it has one.
pub(super) fn item<'a>(object: &'a str, item_id: &'a str) -> &'a str {
    if object.is_empty() { item_id } else { object }
}

/// The time between two moments, in milliseconds since 1970, in whole seconds.
pub(super) fn seconds(since_ms: u64, now_ms: u64) -> String {
    let passed = Duration::from_millis(now_ms.saturating_sub(since_ms));
    format!("{} s", passed.as_secs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_called_as_on_the_wire_without_their_kind() {
        assert_eq!(of_reason(v1::Reason::NoFit), "no_fit");
        assert_eq!(of_check(v1::Check::PhysicalStability), "physical_stability");
        assert_eq!(of_outcome(v1::OutcomeKind::NotPlaced), "not_placed");
        assert_eq!(of_end(v1::SessionEnd::Unspecified), None);
        let others = of_end(v1::SessionEnd::OthersSetAside);
        assert_eq!(others.as_deref(), Some("others_set_aside"));
    }
}
