//! Items and requests of the planner's tests.

use nalgebra::Vector3;
use ppnpack_packing::kernel::item::{Item, ViewSurfaces};
use ppnpack_wire::{convert, v1};

/// A box with a square floor of so many cells a side, 4 cm high, of which no more is known.
pub(crate) fn square(name: &str, cells: usize, mesh_volume_m3: f64) -> v1::Item {
    let middle_m = cells as f64 * 0.01 / 2.0;
    let columns = cells * cells;
    let view = ViewSurfaces {
        origin_from_corner_m: Vector3::new(middle_m, middle_m, 0.0),
        ..ViewSurfaces::of_cells(cells, cells, vec![20; columns], vec![0; columns])
    };
    convert::item::write(&Item::new(name, vec![view; 4], mesh_volume_m3).unwrap())
}

/// A block of 6 x 6 cells.
pub(crate) fn block() -> v1::Item {
    square("block", 6, 0.0001)
}

pub(crate) fn announce(items: impl IntoIterator<Item = v1::Announcement>) -> v1::AnnounceRequest {
    v1::AnnounceRequest {
        items: items.into_iter().collect(),
        ..v1::AnnounceRequest::default()
    }
}

/// An item of which the shape is told.
pub(crate) fn announcement(item_id: &str, item: v1::Item) -> v1::Announcement {
    v1::Announcement {
        item_id: item_id.to_owned(),
        shape: Some(v1::announcement::Shape::Item(item)),
        ..v1::Announcement::default()
    }
}

/// A block with what it belongs to.
pub(crate) fn line(item_id: &str, order_line: v1::OrderLine) -> v1::Announcement {
    v1::Announcement {
        order_line: Some(order_line),
        ..announcement(item_id, block())
    }
}

pub(crate) fn of_order(order: &str) -> v1::OrderLine {
    v1::OrderLine {
        order: order.to_owned(),
        ..v1::OrderLine::default()
    }
}

pub(crate) fn of_mass(mass_kg: f64) -> v1::OrderLine {
    v1::OrderLine {
        mass_kg,
        ..v1::OrderLine::default()
    }
}

pub(crate) fn close(container: &str, sequence: u64) -> v1::CloseRequest {
    v1::CloseRequest {
        container: container.to_owned(),
        sequence,
        text: "the truck leaves".to_owned(),
        ..v1::CloseRequest::default()
    }
}

pub(crate) fn open(container: &str, sequence: u64) -> v1::OpenRequest {
    v1::OpenRequest {
        start: Some(v1::ContainerStart {
            container: container.to_owned(),
            least_state_number: 50,
            ..v1::ContainerStart::default()
        }),
        sequence,
        ..v1::OpenRequest::default()
    }
}

/// Reports a decision's item as placed, and found as planned, in a state of the cell.
pub(crate) fn placed(decision: &v1::Decision, state_number: u64) -> v1::ReportRequest {
    placed_and(decision, state_number, true)
}

/// Reports a decision's item as placed as planned; found so, or only assumed to be.
pub(crate) fn placed_and(
    decision: &v1::Decision,
    state_number: u64,
    is_found: bool,
) -> v1::ReportRequest {
    ended_as(
        v1::OutcomeKind::Placed,
        decision,
        v1::Outcome {
            container_from_item: decision.container_from_item,
            is_inside: true,
            state_number,
            is_found,
            ..v1::Outcome::default()
        },
    )
}

pub(crate) fn not_placed(decision: &v1::Decision, state_number: u64) -> v1::ReportRequest {
    let outcome = v1::Outcome {
        state_number,
        ..v1::Outcome::default()
    };
    ended_as(v1::OutcomeKind::NotPlaced, decision, outcome)
}

pub(crate) fn ended_as(
    kind: v1::OutcomeKind,
    decision: &v1::Decision,
    outcome: v1::Outcome,
) -> v1::ReportRequest {
    v1::ReportRequest {
        decision_id: decision.decision_id.clone(),
        outcome: Some(v1::Outcome {
            placement_id: decision.decision_id.clone(),
            item_id: decision.item_id.clone(),
            kind: kind.into(),
            ..outcome
        }),
        ..v1::ReportRequest::default()
    }
}

pub(crate) fn states(session: &v1::Session) -> Vec<v1::ItemState> {
    let states = session.items.iter().map(v1::SessionItem::state);
    states.collect()
}

/// The items that reasons are given for.
pub(crate) fn ids(reasons: &[v1::ItemReason]) -> Vec<&str> {
    let ids = reasons.iter().map(|reason| reason.item_id.as_str());
    ids.collect()
}

pub(crate) fn state_reply(state: v1::CellState) -> v1::CellStateReply {
    v1::CellStateReply {
        state: Some(state),
        ..v1::CellStateReply::default()
    }
}

/// The outcome of a placement that a bridge carried out as it was asked to.
pub(crate) fn carried_out(request: &v1::PlaceRequest) -> v1::Outcome {
    v1::Outcome {
        placement_id: request.placement_id.clone(),
        item_id: request.item_id.clone(),
        kind: v1::OutcomeKind::Placed.into(),
        container_from_item: request.container_from_item,
        state_number: request.state_number + 1,
        ..v1::Outcome::default()
    }
}

pub(crate) fn ended(request: &v1::PlaceRequest, outcome: v1::Outcome) -> v1::PlaceReply {
    v1::PlaceReply {
        execution: Some(v1::Execution {
            placement_id: request.placement_id.clone(),
            phase: v1::ExecutionPhase::Ended.into(),
            outcome: Some(outcome),
        }),
        ..v1::PlaceReply::default()
    }
}
