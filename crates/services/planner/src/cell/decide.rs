//! From a request to a decision: the scene, the buffer, the plan.

use std::ops::Range;
use std::time::{Duration, Instant};

use ppnpack_packing::blocked::block;
use ppnpack_packing::heightmap::Scene;
use ppnpack_packing::plan::{CandidateReport, Plan, Reason};
use ppnpack_packing::refusal::Refusals;
use ppnpack_packing::step::{Candidate, Evaluated, PlacementCounts};
use ppnpack_packing::valid::Tally;
use ppnpack_wire::v1::{self, Status};
use ppnpack_wire::{convert, header};

use super::CellPlanner;
use super::counts;
use super::footprint::footprint;
use super::refusal::Refusal;
use crate::interruption::INTERRUPTED;
use crate::planning::Step;
use crate::scenes::Seen;
use ppnpack_protocol::session::{ItemState, SessionItem};

/// What planning a step led to.
pub(crate) enum Decided {
    Decision(Box<v1::Decision>),
    NothingFits(Vec<v1::ItemReason>),
    NothingWaits,
}

/// What a step is planned on.
struct Prepared {
    /// Each with its place in the order of arrivals.
    items: Vec<(usize, SessionItem)>,
    /// The items in their order, each in all the poses in which it may be packed.
    candidates: Vec<Candidate>,
    seen: Seen,
    /// What was seen, with everything blocked that must stay free.
    scene: Scene,
    /// Of the step.
    number: u64,
    deadline: Instant,
}

impl Prepared {
    fn step(&self, alternatives: usize) -> Step<'_> {
        Step {
            scene: &self.scene,
            candidates: &self.candidates,
            number: self.number,
            alternatives,
            deadline: self.deadline,
        }
    }

    /// The place among the items of the one that a candidate is.
    fn item_of(&self, candidate: usize) -> Option<usize> {
        let arrival = self.candidates.get(candidate)?.arrival;
        self.items.iter().position(|(held, _)| *held == arrival)
    }

    /// The candidates of an item, by its place among the items, in the order of its poses.
    fn poses_of(&self, item: usize) -> Range<usize> {
        let arrival = self.items.get(item).map(|(arrival, _)| *arrival);
        let is_of = |held: &&Candidate| Some(held.arrival) == arrival;
        let before = self.candidates.iter().take_while(|held| !is_of(held));
        let first = before.count();
        let poses = self.candidates.iter().skip(first).take_while(is_of);
        first..first + poses.count()
    }

    /// A placement of a candidate as one of its item.
    fn write_ranked(&self, ranked: &Evaluated) -> v1::RankedPlacement {
        let item = self.item_of(ranked.candidate).unwrap_or_default();
        let held = self.candidates.get(ranked.candidate);
        convert::placement::write_ranked_item(ranked, item, held.map_or(0, |held| held.pose))
    }
}

impl CellPlanner {
    /// Plans the next step and enters the decision; it is on disk when this returns. Where nothing in the buffer has a
    /// valid placement, items are set aside, as many as may be, until one that arrives after them has.
    pub(crate) fn decide(
        &mut self,
        request_id: &str,
        alternatives: usize,
        deadline: Instant,
    ) -> Result<Decided, Refusal> {
        let begun = Instant::now();
        let mut setting_aside = Duration::ZERO;
        let (prepared, planned, choice, waited) = loop {
            let started = Instant::now();
            let buffer = self.session.buffer(self.settings.method.buffer);
            let items: Vec<_> = buffer.map(|(at, item)| (at, item.clone())).collect();
            if items.is_empty() {
                return Ok(Decided::NothingWaits);
            }
            let prepared = self.prepare(items, deadline)?;
            let waited = started.elapsed();
            let planned = self.plan(&prepared.step(alternatives))?;
            if let Some(choice) = planned.choice() {
                break (prepared, planned, choice, waited);
            }
            if !self.session.may_set_aside() {
                let reasons = self.reasons(&prepared, planned.candidates());
                return Ok(Decided::NothingFits(reasons));
            }
            in_time(deadline)?;
            self.set_aside(&prepared, planned.candidates())?;
            setting_aside = begun.elapsed();
        };
        // Whoever asked may have left, and a decision that nobody knows of keeps others waiting.
        in_time(deadline)?;
        let mut decision = self.decision(request_id, &prepared, &choice, &planned)?;
        decision.stages.insert(0, header::stage("prepare", waited));
        if !setting_aside.is_zero() {
            let stage = header::stage("set_aside", setting_aside);
            decision.stages.insert(0, stage);
        }
        let saving = Instant::now();
        let entered = decision.clone();
        self.change(|session| session.decide(entered))?;
        decision
            .stages
            .push(header::stage("save", saving.elapsed()));
        counts::decisions(&self.cell, !decision.degraded.is_empty(), 1);
        self.will_inspect(&decision, &prepared.seen.scene);
        self.news.decisions.push(decision.clone());
        Ok(Decided::Decision(Box::new(decision)))
    }

    /// Sets aside the largest item of a step in which none has a valid placement; of equal ones the first to arrive. It
    /// is on disk when this returns.
    fn set_aside(
        &mut self,
        prepared: &Prepared,
        reports: &[CandidateReport],
    ) -> Result<(), Refusal> {
        let volume_m3 = |index: &usize| {
            let held = prepared.candidates.get(prepared.poses_of(*index).start);
            held.map_or(0.0, |held| held.item.mesh_volume_m3())
        };
        // Of equal ones, `min_by` gives the first.
        let indices = 0..prepared.items.len();
        let largest = indices.min_by(|a, b| volume_m3(b).total_cmp(&volume_m3(a)));
        let reason = largest.and_then(|index| self.reason(prepared, reports, index));
        let lost = || Refusal::new(Status::Failed, "the plan says nothing of an item");
        let reason = reason.ok_or_else(lost)?;
        let entered = reason.clone();
        self.change(|session| session.set_aside(entered))?;
        let v1::ItemReason { item_id, text, .. } = reason;
        tracing::info!(cell = %self.cell, item_id, reason = text, "set aside");
        Ok(())
    }

    /// Where a waiting item would go, or why nowhere.
    pub(crate) fn explain(
        &mut self,
        item_id: &str,
        deadline: Instant,
    ) -> Result<v1::ExplainReply, Refusal> {
        let (arrival, item) = self.session.waiting(item_id)?;
        let items = vec![(arrival, item.clone())];
        let prepared = self.prepare(items, deadline)?;
        let planned = self.plan(&prepared.step(0))?;
        let choice = planned.choice();
        let reasons = match &choice {
            Some(_) => Vec::new(),
            None => self.reasons(&prepared, planned.candidates()),
        };
        Ok(v1::ExplainReply {
            best: choice.as_ref().map(|best| prepared.write_ranked(best)),
            reason: reasons.into_iter().next(),
            counts: Some(write_reports(planned.candidates())),
            ..v1::ExplainReply::default()
        })
    }

    /// Gets what a step is planned on; waits for a heightmap until the deadline.
    fn prepare(
        &mut self,
        items: Vec<(usize, SessionItem)>,
        deadline: Instant,
    ) -> Result<Prepared, Refusal> {
        let mut candidates = Vec::new();
        for (arrival, item) in &items {
            candidates.extend(self.candidates(*arrival, item)?);
        }
        let mut seen = self.seen(deadline)?;
        if let Some(content) = self.content(deadline) {
            seen.scene = seen.scene.with_content(content);
        }
        Ok(Prepared {
            items,
            candidates,
            scene: self.blocked(&seen.scene)?,
            seen,
            number: self.session.step(),
            deadline,
        })
    }

    /// The scene with everything blocked that must stay free.
    fn blocked(&mut self, scene: &Scene) -> Result<Scene, Refusal> {
        let mut regions = self.session.keep_out().to_vec();
        let packed = self.session.items().iter();
        let fragile: Vec<SessionItem> = packed
            .filter(|item| item.rules.is_fragile)
            .cloned()
            .collect();
        for item in &fragile {
            if let ItemState::Packed {
                placement,
                pose,
                planned,
                container_from_item,
                ..
            } = &item.state
            {
                let shape = self.heightmaps(item, *pose)?;
                let moved = container_from_item * planned.inverse();
                if let Some(view) = shape.views().get(placement.placement.yaw) {
                    regions.push(footprint(placement, view, self.planning.grid(), &moved));
                }
            }
        }
        if regions.is_empty() {
            return Ok(scene.clone());
        }
        Ok(block(scene, self.planning.grid(), &regions))
    }

    fn plan(&mut self, step: &Step<'_>) -> Result<Plan, Refusal> {
        let plan = self.planning.plan(step);
        let is_interrupted = self.own.interruption.is_asked_for();
        let plan = plan.map_err(|error| match is_interrupted {
            true => Refusal::unavailable(INTERRUPTED),
            false => error.into(),
        })?;
        if plan.choice().is_none() && plan.is_cut() {
            let late =
                "the time limit passed before a valid placement was found: give it more time";
            return Err(Refusal::new(Status::TimedOut, late));
        }
        Ok(plan.clone())
    }

    fn decision(
        &mut self,
        request_id: &str,
        prepared: &Prepared,
        choice: &Evaluated,
        planned: &Plan,
    ) -> Result<v1::Decision, Refusal> {
        let lost = || Refusal::new(Status::Failed, "the plan chose an item that is not there");
        let Prepared { items, seen, .. } = prepared;
        let item = prepared.item_of(choice.candidate);
        let (_, item) = item.and_then(|item| items.get(item)).ok_or_else(lost)?;
        let held = prepared.candidates.get(choice.candidate).ok_or_else(lost)?;
        let frame = held
            .item
            .container_from_item(self.planning.grid(), &choice.resting);
        let container_from_item = held.lying.own_frame(&frame.ok_or_else(lost)?);
        let cycle = planned.evidence().and_then(|found| found.cycle.as_ref());
        let timings = planned.timings();
        let stages = vec![
            header::stage("propose", timings.propose),
            header::stage("evaluate", timings.evaluate),
            header::stage("check", timings.check),
            header::stage("look_ahead", timings.look_ahead),
        ];
        Ok(v1::Decision {
            decision_id: format!("{:032x}", rand::random::<u128>()),
            request_id: request_id.to_owned(),
            session_id: self.session.id().to_owned(),
            step: self.session.step(),
            item_id: item.item_id.clone(),
            object: item.object.clone(),
            placement: Some(convert::placement::write_resting(&choice.resting)),
            container_from_item: Some(convert::pose::write(&container_from_item)),
            value: choice.value,
            alternatives: planned
                .alternatives()
                .map(|other| prepared.write_ranked(other))
                .collect(),
            buffer: items.iter().map(|(_, item)| item.item_id.clone()).collect(),
            heightmap: Some(seen.id),
            state_number: seen.state_number,
            degraded: planned.degraded().to_vec(),
            is_widened: planned.is_widened(),
            stages,
            cycle: cycle.map(|cycle| Box::new(convert::cycle::write(cycle))),
            set_aside: self.session.reasons_set_aside_now(),
            settling: planned
                .evidence()
                .and_then(|found| found.settling.as_ref())
                .map(convert::settling::write),
            pose: u32::try_from(held.pose).unwrap_or(u32::MAX),
            decided_at_ns: self.bridge_clock.now_ns(),
        })
    }

    /// Why the items of the buffer have no valid placement.
    fn reasons(&mut self, prepared: &Prepared, reports: &[CandidateReport]) -> Vec<v1::ItemReason> {
        let indices = 0..prepared.items.len();
        let reasons = indices.filter_map(|index| self.reason(prepared, reports, index));
        reasons.collect()
    }

    /// Why an item of the buffer has no valid placement: in the first of its poses, where it may be packed in several. What only
    /// the blocked regions keep out is told apart, by planning on the scene without them.
    fn reason(
        &mut self,
        prepared: &Prepared,
        reports: &[CandidateReport],
        index: usize,
    ) -> Option<v1::ItemReason> {
        let (_, item) = prepared.items.get(index)?;
        let poses = prepared.poses_of(index);
        let report = reports.get(poses.start)?;
        let is_blocked = self.fits_without_regions(&Step {
            scene: &prepared.seen.scene,
            candidates: prepared.candidates.get(poses)?,
            ..prepared.step(0)
        });
        let reason = report.reason.as_ref();
        Some(write_reason(&item.item_id, reason, is_blocked))
    }

    fn fits_without_regions(&mut self, alone: &Step<'_>) -> bool {
        let mut items = self.session.items().iter();
        let has_regions =
            !self.session.keep_out().is_empty() || items.any(|item| item.rules.is_fragile);
        has_regions && self.plan(alone).is_ok_and(|plan| plan.choice().is_some())
    }
}

/// Refuses what would come too late.
fn in_time(deadline: Instant) -> Result<(), Refusal> {
    if Instant::now() < deadline {
        return Ok(());
    }
    let late = "the time limit passed while planning";
    Err(Refusal::new(Status::TimedOut, late))
}

fn write_reason(item_id: &str, reason: Option<&Reason>, is_blocked: bool) -> v1::ItemReason {
    let (kind, text) = match reason {
        _ if is_blocked => (
            v1::Reason::Constrained,
            "it would fit but for regions that stay free or items that nothing may be placed above"
                .to_owned(),
        ),
        Some(reason @ Reason::TooLarge) => (v1::Reason::TooLarge, reason.to_string()),
        Some(reason @ Reason::NoFit) => (v1::Reason::NoFit, reason.to_string()),
        Some(reason @ Reason::NotProposed) => (v1::Reason::NotProposed, reason.to_string()),
        Some(reason) => (v1::Reason::Rejected, reason.to_string()),
        None => (v1::Reason::Unspecified, "it was not looked at".to_owned()),
    };
    v1::ItemReason {
        item_id: item_id.to_owned(),
        reason: kind.into(),
        text,
    }
}

/// What became of the placements of an item, in all of its poses together.
fn write_reports(reports: &[CandidateReport]) -> v1::PlacementCounts {
    let mut counts = PlacementCounts::default();
    let mut refusals = Refusals::default();
    for report in reports {
        counts.possible += report.counts.possible;
        counts.proposed += report.counts.proposed;
        counts.fitting += report.counts.fitting;
        refusals.add(&report.refusals);
    }
    convert::placement::write_tally(&Tally {
        candidate: 0,
        counts,
        refusals,
    })
}
