//! The packing session and its buffer as pages show them.

use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1::{self, ItemState, SessionEnd};
use serde_json::{Value, json};

use super::decision::reason_part;
use super::known::KnownShapes;
use super::words;
use crate::shapes::ShapeId;

const MOST_CLOSED: usize = 16;

const MOST_SHOWN: usize = 64;

/// Whether there is a session at all.
pub(super) fn is_begun(session: &v1::Session) -> bool {
    !session.session_id.is_empty()
}

/// Names a container of a session: as its cell where that has one only.
pub(super) fn address<'a>(cell: &'a Cell, container: &'a str) -> &'a str {
    match container {
        "" => cell.as_str(),
        name => name,
    }
}

pub(super) fn count(session: &v1::Session, state: ItemState) -> usize {
    let items = session.items.iter();
    items.filter(|item| item.state() == state).count()
}

/// Names the object that an item of a session is; empty where the session does not have it.
pub(super) fn object<'a>(session: &'a v1::Session, item_id: &str) -> &'a str {
    let mut items = session.items.iter();
    let item = items.find(|item| item.item_id == item_id);
    item.map_or("", |item| item.object.as_str())
}

/// Shows a session of a cell; `None` where there is none.
pub(super) fn session_part(cell: &Cell, session: &v1::Session) -> Option<Value> {
    if !is_begun(session) {
        return None;
    }
    let reasons = |reasons: &[v1::ItemReason]| -> Vec<Value> {
        let reasons = reasons.iter();
        let parts = reasons.map(|reason| reason_part(reason, object(session, &reason.item_id)));
        parts.collect()
    };
    let containers = session.containers.iter().map(|container| {
        json!({
            "container": address(cell, &container.container),
            "sequence": container.sequence,
            "is_open": container.is_open,
            "is_coming": !container.renewal_id.is_empty(),
        })
    });
    let surplus = session.closed.len().saturating_sub(MOST_CLOSED);
    let closed = session.closed.iter().skip(surplus).map(|closed| {
        json!({
            "container": address(cell, &closed.container),
            "sequence": closed.sequence,
            "reason": words::short(closed.reason().as_str_name(), "CLOSING_REASON_"),
            "text": closed.text,
            "items": closed.items,
        })
    });
    let end = session.end();
    let has_ended = end != SessionEnd::Unspecified;
    let pending = session.pending.as_ref();
    Some(json!({
        "session_id": session.session_id,
        "is_automatic": session.is_automatic,
        "step": session.step,
        "end": has_ended.then(|| words::short(end.as_str_name(), "SESSION_END_")),
        "failure": session.failure,
        "counts": {
            "waiting": count(session, ItemState::Waiting),
            "decided": count(session, ItemState::Decided),
            "packed": count(session, ItemState::Packed),
            "gone": count(session, ItemState::Gone),
            "withdrawn": count(session, ItemState::Withdrawn),
            "set_aside": count(session, ItemState::SetAside),
            "forgotten": session.forgotten_items,
        },
        "reasons": reasons(&session.reasons),
        "set_aside": reasons(&session.set_aside),
        "containers": containers.collect::<Vec<_>>(),
        "closed": closed.collect::<Vec<_>>(),
        "pending": pending.map(|decision| &decision.decision_id),
    }))
}

/// Shows the buffer of a session: the items that wait, and those that are set aside.
pub(super) fn buffer_part(session: &v1::Session, shapes: &KnownShapes) -> Value {
    let limit = usize::try_from(session.buffer).unwrap_or(usize::MAX);
    let of = |is_wanted: fn(ItemState) -> bool| {
        let items = session.items.iter();
        items.filter(move |item| is_wanted(item.state()))
    };
    let waiting = of(|state| matches!(state, ItemState::Waiting | ItemState::Decided));
    let waiting = waiting
        .enumerate()
        .map(|(index, item)| (item, index < limit));
    let aside = of(|state| state == ItemState::SetAside).map(|item| (item, false));
    let mut items: Vec<(&v1::SessionItem, bool)> = waiting.chain(aside).collect();
    let more = items.len().saturating_sub(MOST_SHOWN);
    items.truncate(MOST_SHOWN);
    let parts = items.into_iter().map(|(item, is_choosable)| {
        let shape = shapes.of_waiting(&session.session_id, item);
        buffer_item(item, is_choosable, shape)
    });
    json!({
        "limit": session.buffer,
        "more": more,
        "items": parts.collect::<Vec<_>>(),
    })
}

fn buffer_item(item: &v1::SessionItem, is_choosable: bool, shape: Option<ShapeId>) -> Value {
    let line = item.order_line.as_deref();
    let rules = item.rules.as_ref();
    json!({
        "item_id": item.item_id,
        "object": item.object,
        "state": words::short(item.state().as_str_name(), "ITEM_STATE_"),
        "is_choosable": is_choosable,
        "shape": shape.map(|shape| shape.to_string()),
        "order": line.map_or("", |line| line.order.as_str()),
        "is_fragile": rules.is_some_and(|rules| rules.is_fragile),
        "is_bottom_only": rules.is_some_and(|rules| rules.is_bottom_only),
        "is_upright": rules.is_some_and(|rules| rules.is_upright),
        "carries_kg": rules.and_then(|rules| rules.carries_kg),
    })
}

#[cfg(test)]
mod tests {
    use super::super::tests::{cell, item, session};
    use super::*;

    fn mug(item_id: &str, state: ItemState) -> v1::SessionItem {
        item(item_id, "mug", state)
    }

    #[test]
    fn a_session_is_counted_and_its_only_container_has_the_cells_name() {
        let items = vec![mug("a", ItemState::Packed), mug("b", ItemState::SetAside)];
        let session = v1::Session {
            set_aside: vec![v1::ItemReason {
                item_id: "b".to_owned(),
                reason: v1::Reason::TooLarge.into(),
                text: "too large".to_owned(),
            }],
            ..session(items)
        };
        let part = session_part(&cell("c1"), &session).unwrap();
        assert_eq!(part["counts"]["packed"], json!(1));
        assert_eq!(part["counts"]["set_aside"], json!(1));
        assert_eq!(part["end"], json!(null));
        assert_eq!(part["containers"][0]["container"], json!("c1"));
        let reason =
            json!({"item_id": "b", "object": "mug", "reason": "too_large", "text": "too large"});
        assert_eq!(part["set_aside"][0], reason);
    }

    #[test]
    fn the_buffer_has_what_waits_first_and_says_what_is_not_listed() {
        let mut items = vec![
            mug("aside", ItemState::SetAside),
            mug("packed", ItemState::Packed),
        ];
        items.extend((0..70).map(|index| mug(&format!("i-{index}"), ItemState::Waiting)));
        let session = v1::Session {
            buffer: 5,
            ..session(items)
        };
        let part = buffer_part(&session, &KnownShapes::default());
        assert_eq!((&part["limit"], &part["more"]), (&json!(5), &json!(7)));
        let items = part["items"].as_array().unwrap();
        assert_eq!(items.len(), MOST_SHOWN);
        let choosable = items
            .iter()
            .filter(|item| item["is_choosable"] == json!(true));
        assert_eq!(choosable.count(), 5);
        assert_eq!(items[0]["item_id"], json!("i-0"));
    }
}
