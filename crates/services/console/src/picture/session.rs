//! The packing session and its buffer as pages show them.

use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1::{self, ItemState};
use serde::Serialize;

use super::decision::ReasonPart;
use super::known::KnownShapes;
use super::words;
use crate::shapes::ShapeId;

/// Containers that were closed and are shown.
const MOST_CLOSED: usize = 16;

/// Items of the buffer that are shown.
const MOST_SHOWN: usize = 64;

#[derive(Debug, Default, Serialize)]
struct CountsPart {
    waiting: usize,
    decided: usize,
    packed: usize,
    gone: usize,
    withdrawn: usize,
    set_aside: usize,
    forgotten: u64,
}

#[derive(Debug, Serialize)]
struct ContainerPart<'a> {
    container: &'a str,
    sequence: u64,
    is_open: bool,
    is_coming: bool,
}

#[derive(Debug, Serialize)]
struct ClosedPart<'a> {
    container: &'a str,
    sequence: u64,
    reason: String,
    text: &'a str,
    items: u32,
}

/// A session.
#[derive(Debug, Serialize)]
pub(super) struct SessionPart<'a> {
    session_id: &'a str,
    is_automatic: bool,
    step: u64,
    end: Option<String>,
    failure: &'a str,
    counts: CountsPart,
    reasons: Vec<ReasonPart>,
    set_aside: Vec<ReasonPart>,
    containers: Vec<ContainerPart<'a>>,
    closed: Vec<ClosedPart<'a>>,
    pending: Option<&'a str>,
}

/// Whether there is a session at all.
pub(super) fn is_begun(session: &v1::Session) -> bool {
    !session.session_id.is_empty()
}

/// The name of a container in a session: that of the cell where it has one only.
pub(super) fn address<'a>(cell: &'a Cell, container: &'a str) -> &'a str {
    match container {
        "" => cell.as_str(),
        name => name,
    }
}

/// So many items are in a state.
pub(super) fn count(session: &v1::Session, state: ItemState) -> usize {
    let items = session.items.iter();
    items.filter(|item| item.state() == state).count()
}

/// The name of the object that an item of a session is; empty where the session does not have it.
pub(super) fn object<'a>(session: &'a v1::Session, item_id: &str) -> &'a str {
    let mut items = session.items.iter();
    let item = items.find(|item| item.item_id == item_id);
    item.map_or("", |item| item.object.as_str())
}

/// A session of a cell; `None` where there is none.
pub(super) fn session_part<'a>(
    cell: &'a Cell,
    session: &'a v1::Session,
) -> Option<SessionPart<'a>> {
    if !is_begun(session) {
        return None;
    }
    let reasons = |reasons: &[v1::ItemReason]| -> Vec<ReasonPart> {
        let reasons = reasons.iter();
        let parts = reasons.map(|reason| ReasonPart::new(reason, object(session, &reason.item_id)));
        parts.collect()
    };
    let containers = session.containers.iter().map(|container| ContainerPart {
        container: address(cell, &container.container),
        sequence: container.sequence,
        is_open: container.is_open,
        is_coming: !container.renewal_id.is_empty(),
    });
    let surplus = session.closed.len().saturating_sub(MOST_CLOSED);
    let closed = session
        .closed
        .iter()
        .skip(surplus)
        .map(|closed| ClosedPart {
            container: address(cell, &closed.container),
            sequence: closed.sequence,
            reason: words::of_closing(closed.reason()),
            text: &closed.text,
            items: closed.items,
        });
    let pending = session.pending.as_ref();
    Some(SessionPart {
        session_id: &session.session_id,
        is_automatic: session.is_automatic,
        step: session.step,
        end: words::of_end(session.end()),
        failure: &session.failure,
        counts: counts(session),
        reasons: reasons(&session.reasons),
        set_aside: reasons(&session.set_aside),
        containers: containers.collect(),
        closed: closed.collect(),
        pending: pending.map(|decision| decision.decision_id.as_str()),
    })
}

fn counts(session: &v1::Session) -> CountsPart {
    let mut counts = CountsPart {
        forgotten: session.forgotten_items,
        ..CountsPart::default()
    };
    for item in &session.items {
        let count = match item.state() {
            ItemState::Waiting => &mut counts.waiting,
            ItemState::Decided => &mut counts.decided,
            ItemState::Packed => &mut counts.packed,
            ItemState::Gone => &mut counts.gone,
            ItemState::Withdrawn => &mut counts.withdrawn,
            ItemState::SetAside => &mut counts.set_aside,
            ItemState::Unspecified => continue,
        };
        *count += 1;
    }
    counts
}

#[derive(Debug, Serialize)]
struct BufferItemPart<'a> {
    item_id: &'a str,
    object: &'a str,
    state: String,
    is_choosable: bool,
    shape: Option<ShapeId>,
    order: &'a str,
    urgency: u32,
    is_fragile: bool,
    is_bottom_only: bool,
    is_upright: bool,
    carries_kg: Option<f64>,
}

/// The items that wait, and those that are set aside.
#[derive(Debug, Serialize)]
pub(super) struct BufferPart<'a> {
    limit: u32,
    more: usize,
    items: Vec<BufferItemPart<'a>>,
}

/// The buffer of a session.
pub(super) fn buffer_part<'a>(session: &'a v1::Session, shapes: &KnownShapes) -> BufferPart<'a> {
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
    BufferPart {
        limit: session.buffer,
        more,
        items: parts.collect(),
    }
}

fn buffer_item(
    item: &v1::SessionItem,
    is_choosable: bool,
    shape: Option<ShapeId>,
) -> BufferItemPart<'_> {
    let line = item.order_line.as_deref();
    let rules = item.rules.as_ref();
    BufferItemPart {
        item_id: &item.item_id,
        object: &item.object,
        state: words::of_state(item.state()),
        is_choosable,
        shape,
        order: line.map_or("", |line| line.order.as_str()),
        urgency: line.map_or(0, |line| line.urgency),
        is_fragile: rules.is_some_and(|rules| rules.is_fragile),
        is_bottom_only: rules.is_some_and(|rules| rules.is_bottom_only),
        is_upright: rules.is_some_and(|rules| rules.is_upright),
        carries_kg: rules.and_then(|rules| rules.carries_kg),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn item(item_id: &str, state: ItemState) -> v1::SessionItem {
        v1::SessionItem {
            item_id: item_id.to_owned(),
            object: "mug".to_owned(),
            state: state.into(),
            ..v1::SessionItem::default()
        }
    }

    #[test]
    fn before_the_first_session_there_is_none() {
        let cell = Cell::new("c1").unwrap();
        assert!(session_part(&cell, &v1::Session::default()).is_none());
    }

    #[test]
    fn a_session_is_counted_and_its_only_container_has_the_cells_name() {
        let cell = Cell::new("c1").unwrap();
        let session = v1::Session {
            session_id: "s".to_owned(),
            items: vec![item("a", ItemState::Packed), item("b", ItemState::SetAside)],
            containers: vec![v1::SessionContainer {
                is_open: true,
                ..v1::SessionContainer::default()
            }],
            set_aside: vec![v1::ItemReason {
                item_id: "b".to_owned(),
                reason: v1::Reason::TooLarge.into(),
                text: "too large".to_owned(),
            }],
            ..v1::Session::default()
        };
        let part = serde_json::to_value(session_part(&cell, &session).unwrap()).unwrap();
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
            item("aside", ItemState::SetAside),
            item("packed", ItemState::Packed),
        ];
        items.extend((0..70).map(|index| item(&format!("i-{index}"), ItemState::Waiting)));
        let session = v1::Session {
            session_id: "s".to_owned(),
            buffer: 5,
            items,
            ..v1::Session::default()
        };
        let shapes = KnownShapes::default();
        let part = serde_json::to_value(buffer_part(&session, &shapes)).unwrap();
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
