//! Placements, outcomes and holds, as messages.

use std::sync::Arc;

use ppnpack_wire::convert::{cycle, pose};
use ppnpack_wire::{WireError, header, limits, v1};

use crate::ledger::{Hold, Outcome};
use crate::placing::{Body, Ending, Finding, KnownPose, Placement};

/// Reads the placement of a request.
pub fn read_placement(message: &v1::PlaceRequest) -> Result<Placement, WireError> {
    let pose = message.container_from_item.as_ref();
    let cycle = message.cycle.as_deref().map(cycle::read);
    Ok(Placement {
        placement_id: header::id("placement_id", &message.placement_id)?.to_owned(),
        item_id: header::id("item_id", &message.item_id)?.to_owned(),
        object: limits::name("object", &message.object)?.to_owned(),
        container_from_item: pose::read_required("container_from_item", pose)?,
        state_number: message.state_number,
        cycle: cycle.transpose()?.map(Arc::new),
    })
}

/// Writes a placement for a robot.
pub fn write_placement(placement: &Placement) -> v1::PlaceRequest {
    let cycle = placement.cycle.as_deref().map(cycle::write);
    v1::PlaceRequest {
        placement_id: placement.placement_id.clone(),
        item_id: placement.item_id.clone(),
        object: placement.object.clone(),
        container_from_item: Some(pose::write(&placement.container_from_item)),
        state_number: placement.state_number,
        cycle: cycle.map(Box::new),
        ..v1::PlaceRequest::default()
    }
}

/// Reads what a robot found of a placement: of this one, with numbers that are some, and where it
/// was placed, as planned if nothing else is said.
///
/// # Errors
/// [`WireError`] names what cannot be.
pub fn read_finding(placement: &Placement, outcome: &v1::Outcome) -> Result<Finding, WireError> {
    for (field, told, own) in [
        (
            "placement_id",
            &outcome.placement_id,
            &placement.placement_id,
        ),
        ("item_id", &outcome.item_id, &placement.item_id),
    ] {
        if !told.is_empty() && told != own {
            let reason = format_args!("{told:?} where {own:?} was asked for");
            return Err(WireError::invalid(field, reason));
        }
    }
    for (field, value) in [("slide_m", outcome.slide_m), ("tilt_rad", outcome.tilt_rad)] {
        if !value.is_finite() {
            return Err(WireError::invalid(field, value));
        }
    }
    let ending = match outcome.kind() {
        v1::OutcomeKind::Placed => Ending::Placed,
        v1::OutcomeKind::NotPlaced => Ending::NotPlaced,
        v1::OutcomeKind::Lost => Ending::Lost,
        v1::OutcomeKind::Unknown => Ending::Unknown,
        v1::OutcomeKind::Unspecified => return Err(WireError::invalid("kind", "it is none")),
    };
    let told = outcome.container_from_item.as_ref();
    let told = told.map(|told| pose::read_required("container_from_item", Some(told)));
    let found = told
        .transpose()?
        .map(|told| KnownPose::new(told, outcome.is_found));
    let planned = KnownPose::Assumed(placement.container_from_item);
    Ok(Finding {
        ending,
        failure: header::text(&outcome.failure),
        container_from_item: found.or((ending == Ending::Placed).then_some(planned)),
        is_inside: outcome.is_inside,
        slide_m: outcome.slide_m,
        tilt_rad: outcome.tilt_rad,
    })
}

/// Writes the state of a placement.
pub fn execution(placement: &Placement, outcome: Option<&Outcome>) -> v1::Execution {
    let phase = match outcome {
        Some(_) => v1::ExecutionPhase::Ended,
        None => v1::ExecutionPhase::Accepted,
    };
    v1::Execution {
        placement_id: placement.placement_id.clone(),
        phase: phase.into(),
        outcome: outcome.map(|outcome| write_outcome(placement, outcome)),
    }
}

/// Writes the end of a placement.
pub fn write_outcome(placement: &Placement, outcome: &Outcome) -> v1::Outcome {
    let finding = &outcome.finding;
    let pose = finding.container_from_item.as_ref();
    let kind = match finding.ending {
        Ending::Placed => v1::OutcomeKind::Placed,
        Ending::NotPlaced => v1::OutcomeKind::NotPlaced,
        Ending::Lost => v1::OutcomeKind::Lost,
        Ending::Unknown => v1::OutcomeKind::Unknown,
    };
    v1::Outcome {
        placement_id: placement.placement_id.clone(),
        item_id: placement.item_id.clone(),
        kind: kind.into(),
        failure: header::text(&finding.failure),
        container_from_item: pose.map(KnownPose::isometry).map(pose::write),
        is_inside: finding.is_inside,
        slide_m: finding.slide_m,
        tilt_rad: finding.tilt_rad,
        state_number: outcome.state_number,
        is_found: pose.is_some_and(KnownPose::is_found),
    }
}

/// Reads an item's pose from a bridge or a controller; `None` where it gives none that is possible.
pub fn read_pose(container_from_item: Option<&v1::Pose>, is_found: bool) -> Option<KnownPose> {
    let pose = pose::read_required("container_from_item", container_from_item);
    Some(KnownPose::new(pose.ok()?, is_found))
}

/// Writes something that lies in the container.
pub fn write_body(body: &Body) -> v1::Body {
    v1::Body {
        item_id: body.item_id.clone(),
        object: body.object.clone(),
        container_from_item: Some(pose::write(body.container_from_item.isometry())),
        is_inside: body.is_inside,
        is_found: body.container_from_item.is_found(),
    }
}

/// Reads something that lies in the container.
///
/// # Errors
/// [`WireError`] names what cannot be.
pub fn read_body(message: &v1::Body) -> Result<Body, WireError> {
    let pose = message.container_from_item.as_ref();
    let pose = pose::read_required("container_from_item", pose)?;
    Ok(Body {
        item_id: header::id("item_id", &message.item_id)?.to_owned(),
        object: limits::name("object", &message.object)?.to_owned(),
        container_from_item: KnownPose::new(pose, message.is_found),
        is_inside: message.is_inside,
    })
}

/// Writes a hold.
pub fn write_hold(hold: &Hold) -> v1::Hold {
    v1::Hold {
        reason: hold.reason.clone(),
        id: hold.id.clone(),
        holder: hold.holder.clone(),
    }
}
