//! A record as a step that can be planned again.

use std::sync::Arc;

use ppnpack_packing::kernel::item::Item;
use ppnpack_packing::ranking::candidate::Lying;
use ppnpack_packing::ranking::step::Candidate;
use ppnpack_packing::scene::content::{Burden, Content, LyingBody, LyingSolid};
use ppnpack_packing::scene::leaving::{Leaving, Stop};
use ppnpack_packing::scene::model::Model;
use ppnpack_protocol::session::message;
use ppnpack_wire::shape_store::ShapeStore;
use ppnpack_wire::{WireError, convert, v1};

use crate::step::plan::{AttemptPlan, ContainerStep, StepPlan};

/// Why a record is no step.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Unreadable {
    /// An item or a solid that it names is not there.
    #[error("the recording lacks the {what} {id} that the step names")]
    Lacks {
        /// `item` or `solid`.
        what: &'static str,
        /// The first digits of its id.
        id: String,
    },
    /// A field is not possible.
    #[error(transparent)]
    Field(#[from] WireError),
    /// The numbers of a container's stops are not as many as its cells.
    #[error("container '{0}' has another number of stops than of cells")]
    Stops(String),
}

/// Reads the step of a record, to be planned however long it takes.
pub(crate) fn step(
    record: &v1::PlanningRecord,
    shapes: &ShapeStore,
) -> Result<StepPlan, Unreadable> {
    let candidates = record.candidates.iter();
    let candidates = candidates.map(|held| candidate(held, shapes));
    let candidates = candidates.collect::<Result<_, _>>()?;
    let containers = record.containers.iter();
    let containers = containers.map(|at| container(at, shapes));
    Ok(StepPlan {
        items: record.items.clone(),
        containers: containers.collect::<Result<_, _>>()?,
        candidates,
        attempts: record.attempts.iter().map(attempt).collect(),
        number: record.step,
        alternatives: index(record.alternatives),
        deadline: None,
        takes_untried: false,
    })
}

fn candidate(held: &v1::RecordedCandidate, shapes: &ShapeStore) -> Result<Candidate, Unreadable> {
    let frame = |field, pose: &Option<v1::Pose>| {
        let pose = pose.as_ref();
        let pose = pose.map(|pose| convert::pose::read_required(field, Some(pose)));
        pose.transpose()
    };
    let solid = Some(&held.solid).filter(|solid| !solid.is_empty());
    let model = solid.map(|id| solid_of(id, shapes)).transpose()?;
    Ok(Candidate {
        pose: index(held.pose),
        model,
        mass_kg: held.mass_kg,
        lying: Lying {
            heightmap_from_item: frame("heightmap_from_item", &held.heightmap_from_item)?,
            waits_at: frame("waits_at", &held.waits_at)?,
        },
        rules: message::read_rules(held.rules.as_ref())?,
        stop: stop(&held.stop),
        ..Candidate::new(
            usize::try_from(held.arrival).unwrap_or(usize::MAX),
            item_of(&held.item, shapes)?,
        )
    })
}

fn container(at: &v1::RecordedContainer, shapes: &ShapeStore) -> Result<ContainerStep, Unreadable> {
    let (grid, mut scene) = convert::scene::read_required("scene", at.scene.as_ref())?;
    if let Some(content) = &at.content {
        scene = scene.with_content(content_of(content, shapes)?);
    }
    if !at.stops.is_empty() {
        let stops: Vec<Stop> = at.stops.iter().map(stop).collect();
        let leaving = Leaving::from_stops(&grid, &stops);
        let leaving = leaving.ok_or_else(|| Unreadable::Stops(at.container.clone()))?;
        scene = scene.with_leaving(leaving);
    }
    Ok(ContainerStep {
        name: at.container.clone(),
        grid,
        scene,
    })
}

fn content_of(content: &v1::RecordedContent, shapes: &ShapeStore) -> Result<Content, Unreadable> {
    let bodies = content.bodies.iter().map(|recorded| {
        let solid = body(recorded, shapes)?;
        // Which of them were seen makes no difference, but whether some were.
        Ok(match content.has_seen {
            _ if recorded.is_assumed => LyingBody::Assumed(solid),
            true => LyingBody::Seen(solid),
            false => LyingBody::Known(solid),
        })
    });
    let bodies = bodies.collect::<Result<Vec<_>, Unreadable>>()?;
    let unknown = content.is_partial.then_some(LyingBody::Unknown);
    Ok(bodies.into_iter().chain(unknown).collect())
}

fn body(recorded: &v1::RecordedBody, shapes: &ShapeStore) -> Result<LyingSolid, Unreadable> {
    let pose = recorded.container_from_item.as_ref();
    Ok(LyingSolid {
        model: solid_of(&recorded.solid, shapes)?,
        container_from_item: convert::pose::read_required("container_from_item", pose)?,
        burden: Burden {
            name: recorded.name.as_str().into(),
            mass_kg: recorded.mass_kg,
            carries_kg: recorded.carries_kg,
        },
    })
}

fn item_of(id: &[u8], shapes: &ShapeStore) -> Result<Arc<Item>, Unreadable> {
    let found = shapes.item(id).cloned();
    found.ok_or_else(|| lacks("item", id))
}

fn solid_of(id: &[u8], shapes: &ShapeStore) -> Result<Arc<Model>, Unreadable> {
    let found = shapes.solid(id).cloned();
    found.ok_or_else(|| lacks("solid", id))
}

fn lacks(what: &'static str, id: &[u8]) -> Unreadable {
    let digits = id.iter().take(8).map(|byte| format!("{byte:02x}"));
    let id = digits.collect();
    Unreadable::Lacks { what, id }
}

fn attempt(recorded: &v1::RecordedAttempt) -> AttemptPlan {
    let containers = recorded.containers.iter();
    let admitted = containers.map(|at| at.candidates.iter().map(|at| index(*at)).collect());
    admitted.collect()
}

fn stop(number: &u32) -> Stop {
    Stop::new((*number != 0).then_some(*number))
}

fn index(number: u32) -> usize {
    usize::try_from(number).unwrap_or(usize::MAX)
}
