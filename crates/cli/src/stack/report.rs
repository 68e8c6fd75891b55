//! A packing over the wire, as its report needs it.

use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context, Result};
use nalgebra::Isometry3;
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_catalogue::object::CatalogueObject;
use ppnpack_packing::checks::check::Evidence;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::ranking::refusal::Refusals;
use ppnpack_packing::ranking::step::{Evaluated, Timings};
use ppnpack_packing::scene::Scene;
use ppnpack_packing::streams::episode::{Step, packed_volume};
use ppnpack_packing::streams::metrics::Metrics;
use ppnpack_wire::{convert, v1};

use super::controller::{Done, Packed};
use crate::report::{ArmWork, Content, EndingSummary, Packing, Settings, Settled, Unplaceable};
use crate::sequence::Sequence;

/// Gives the id of the item at a place in the sequence of arrivals.
pub fn item_id(arrival: usize) -> String {
    format!("item-{arrival}")
}

/// Gives the place in the sequence of arrivals that an item id names.
pub fn arrival_of(item_id: &str) -> Option<usize> {
    item_id.strip_prefix("item-")?.parse().ok()
}

/// Converts the packing that a controller saw.
pub(crate) fn packing(
    settings: Settings,
    catalogue: &Catalogue,
    packed: &Packed,
    arm: Option<ArmWork>,
    took: Duration,
) -> Result<Packing> {
    let grid = settings.grid.clone();
    let topple_rad = settings.simulated.cell.outcome.topple_rad;
    let steps = packed.done.iter().map(|done| step(done, catalogue));
    let steps: Vec<Step> = steps.collect::<Result<_>>()?;
    let settled = packed.done.iter().map(|done| settled(done, topple_rad));
    let contents = contents(&packed.state, catalogue)?;
    let scene = scene(&packed.heightmap, &grid)?;
    let is_inside = |arrival| {
        let mut contents = contents.iter();
        contents.any(|(other, content)| *other == arrival && content.inside)
    };
    let volume = packed_volume(&grid, &steps, is_inside);
    Ok(Packing {
        metrics: Metrics::new(&grid, scene.heightmap(), volume),
        ending: ending(packed, catalogue, &settings.sequence),
        set_aside: unplaceable(&packed.set_aside, catalogue, &settings.sequence),
        settings,
        steps,
        settled: settled.collect(),
        moves: packed.done.iter().map(|done| done.moves.clone()).collect(),
        scene,
        contents,
        preloaded: Vec::new(),
        took,
        arm,
    })
}

fn step(done: &Done, catalogue: &Catalogue) -> Result<Step> {
    let decision = &done.decision;
    let (arrival, object) = known(&decision.item_id, &decision.object, catalogue)?;
    let placement = decision.placement.as_ref();
    let placement = placement.context("a decision has no placement")?;
    let pose = usize::try_from(decision.pose)?;
    let candidate = object.candidates(arrival).into_iter().nth(pose);
    let candidate = candidate.with_context(|| format!("the catalogue has no pose {pose} of it"))?;
    let mut buffer = decision.buffer.iter();
    let item = buffer.position(|item| *item == decision.item_id);
    let alternatives = decision.alternatives.iter();
    let alternatives = alternatives.map(convert::placement::read_ranked);
    let cycle = decision.cycle.as_deref().map(convert::cycle::read);
    let settling = decision.settling.as_ref().map(convert::settling::read);
    let load = decision.load.as_deref().map(convert::load::read);
    Ok(Step {
        step: decision.step,
        candidate,
        choice: Evaluated {
            candidate: item.unwrap_or_default(),
            resting: convert::placement::read_resting(placement)?,
            value: decision.value,
        },
        evidence: Evidence {
            cycle: cycle.transpose()?.map(Arc::new),
            settling: settling.transpose()?,
            load: load.transpose()?,
            ..Evidence::default()
        },
        alternatives: alternatives.collect::<Result<_, _>>()?,
        timings: Timings {
            propose: stage(decision, "propose"),
            evaluate: stage(decision, "evaluate"),
            check: stage(decision, "check"),
        },
        degraded: decision.degraded.clone(),
        is_widened: decision.is_widened,
        refusals: Refusals::default(),
    })
}

/// Gives the place of an item in the sequence of arrivals, and its object.
fn known<'a>(
    item_id: &str,
    object: &str,
    catalogue: &'a Catalogue,
) -> Result<(usize, &'a CatalogueObject)> {
    let found = catalogue.find(object);
    let (_, found) = found.with_context(|| format!("the catalogue has no object {object}"))?;
    Ok((arrived(item_id)?, found))
}

/// Gives the place of an item in the sequence of arrivals.
fn arrived(item_id: &str) -> Result<usize> {
    arrival_of(item_id).with_context(|| format!("item {item_id} is not of here"))
}

fn stage(decision: &v1::Decision, name: &str) -> Duration {
    let mut stages = decision.stages.iter();
    let stage = stages.find(|stage| stage.stage == name);
    Duration::from_nanos(stage.map_or(0, |stage| stage.duration_ns))
}

/// Gives the content of the container, each with its place in the sequence of arrivals.
pub fn contents(state: &v1::CellState, catalogue: &Catalogue) -> Result<Vec<(usize, Content)>> {
    let bodies = state.bodies.iter();
    bodies.map(|body| content(body, catalogue)).collect()
}

/// Gives the poses of the container's content, each with its place in the sequence of arrivals.
pub(super) fn poses(state: &v1::CellState) -> Result<Vec<(usize, Isometry3<f64>)>> {
    let pose = |body: &v1::Body| {
        let arrival = arrived(&body.item_id)?;
        let pose = body.container_from_item.as_ref();
        let pose = convert::pose::read_required("container_from_item", pose)?;
        Ok((arrival, pose))
    };
    state.bodies.iter().map(pose).collect()
}

fn content(body: &v1::Body, catalogue: &Catalogue) -> Result<(usize, Content)> {
    let (arrival, object) = known(&body.item_id, &body.object, catalogue)?;
    let pose = body.container_from_item.as_ref();
    let content = Content {
        model: object.model.clone(),
        container_from_item: convert::pose::read_required("container_from_item", pose)?,
        inside: body.is_inside,
    };
    Ok((arrival, content))
}

fn scene(heightmap: &v1::Heightmap, grid: &Grid) -> Result<Scene> {
    let (seen, scene) = convert::scene::read_required("scene", heightmap.scene.as_ref())?;
    let is_same = seen == *grid;
    anyhow::ensure!(is_same, "perception uses another grid than the planner");
    Ok(scene)
}

fn settled(done: &Done, topple_rad: f64) -> Settled {
    Settled {
        slide_m: done.outcome.slide_m,
        tilt_rad: done.outcome.tilt_rad,
        toppled: done.outcome.tilt_rad > topple_rad,
        inside: done.outcome.is_inside,
    }
}

fn ending(packed: &Packed, catalogue: &Catalogue, sequence: &Sequence) -> EndingSummary {
    match (packed.reasons.as_slice(), packed.set_aside.as_slice()) {
        ([], []) => EndingSummary::AllPacked,
        ([], _) => EndingSummary::OthersSetAside,
        (reasons, _) => EndingSummary::NothingFits {
            items: unplaceable(reasons, catalogue, sequence),
        },
    }
}

/// Gives the items of the sequence that these reasons are of.
fn unplaceable(
    reasons: &[v1::ItemReason],
    catalogue: &Catalogue,
    sequence: &Sequence,
) -> Vec<Unplaceable> {
    let items = reasons.iter().filter_map(|reason| {
        let arrival = arrival_of(&reason.item_id)?;
        let object = catalogue.get(*sequence.objects.get(arrival)?)?;
        Some(Unplaceable {
            arrival,
            item: object.item.name().to_string(),
            reason: reason.text.clone(),
        })
    });
    items.collect()
}
