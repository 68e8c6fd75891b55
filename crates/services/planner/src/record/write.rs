//! A step as a record.

use ppnpack_packing::ranking::step::Candidate;
use ppnpack_packing::scene::content::{Content, LyingSolid};
use ppnpack_packing::scene::leaving::{Leaving, Stop};
use ppnpack_protocol::session::message;
use ppnpack_wire::{convert, v1};

use super::shapes::Shapes;
use crate::step::plan::{AttemptPlan, ContainerStep, StepPlan};

/// Writes what a step was planned on.
pub(super) fn step(plan: &StepPlan, shapes: &mut Shapes) -> v1::PlanningRecord {
    let candidates = plan.candidates.iter();
    let candidates = candidates.map(|held| candidate(held, shapes)).collect();
    let containers = plan.containers.iter();
    let containers = containers.map(|at| container(at, shapes));
    v1::PlanningRecord {
        step: plan.number,
        alternatives: number(plan.alternatives),
        items: plan.items.clone(),
        candidates,
        containers: containers.collect(),
        attempts: plan.attempts.iter().map(attempt).collect(),
        ..v1::PlanningRecord::default()
    }
}

fn candidate(held: &Candidate, shapes: &mut Shapes) -> v1::RecordedCandidate {
    let frame = |pose: &Option<_>| pose.as_ref().map(convert::pose::write);
    let solid = held.model.as_ref().map(|model| shapes.solid(model));
    v1::RecordedCandidate {
        arrival: held.arrival as u64,
        pose: number(held.pose),
        item: shapes.item(&held.item),
        solid: solid.unwrap_or_default(),
        mass_kg: held.mass_kg,
        heightmap_from_item: frame(&held.lying.heightmap_from_item),
        waits_at: frame(&held.lying.waits_at),
        rules: message::write_rules(&held.rules),
        stop: stop(&held.stop),
    }
}

fn stop(stop: &Stop) -> u32 {
    stop.number().unwrap_or(0)
}

fn container(at: &ContainerStep, shapes: &mut Shapes) -> v1::RecordedContainer {
    let stops = at.scene.leaving().map(Leaving::stops).unwrap_or_default();
    v1::RecordedContainer {
        container: at.name.clone(),
        scene: Some(convert::scene::write(&at.grid, &at.scene)),
        content: at
            .scene
            .content()
            .map(|content| content_of(content, shapes)),
        stops: stops.iter().map(stop).collect(),
    }
}

fn content_of(content: &Content, shapes: &mut Shapes) -> v1::RecordedContent {
    let lying = content.solids().iter().map(|solid| (solid, false));
    let assumed = content.assumed().iter().map(|solid| (solid, true));
    let bodies = lying.chain(assumed);
    let bodies = bodies.map(|(solid, is_assumed)| v1::RecordedBody {
        is_assumed,
        ..body(solid, shapes)
    });
    v1::RecordedContent {
        bodies: bodies.collect(),
        has_seen: content.has_seen(),
        is_partial: content.has_unknown(),
    }
}

fn body(solid: &LyingSolid, shapes: &mut Shapes) -> v1::RecordedBody {
    v1::RecordedBody {
        name: solid.burden.name.to_string(),
        solid: shapes.solid(&solid.model),
        container_from_item: Some(convert::pose::write(&solid.container_from_item)),
        mass_kg: solid.burden.mass_kg,
        carries_kg: solid.burden.carries_kg,
        is_assumed: false,
    }
}

fn attempt(admitted: &AttemptPlan) -> v1::RecordedAttempt {
    let containers = admitted.iter().map(|candidates| v1::AdmittedCandidates {
        candidates: candidates.iter().map(|index| number(*index)).collect(),
    });
    v1::RecordedAttempt {
        containers: containers.collect(),
    }
}

fn number(number: usize) -> u32 {
    u32::try_from(number).unwrap_or(u32::MAX)
}
