//! From a request to a decision: the scene, the buffer, the plan.

use std::time::{Duration, Instant};

use ppnpack_packing::planning::plan::{CandidateReport, Plan, Reason};
use ppnpack_packing::planning::valid::Tally;
use ppnpack_packing::ranking::refusal::Refusals;
use ppnpack_packing::ranking::step::{PlacementCounts, StepInput};
use ppnpack_packing::scene::Scene;
use ppnpack_wire::v1::{self, Status};
use ppnpack_wire::{convert, header};

use super::plan::{Found, PlansContainers, StepPlan, write_ranked};
use super::prepare::{Prepared, poses_of};
use super::{NotPlanned, Planned, Stepper};
use crate::refusal::Refusal;

/// Share of a request's remaining time that is kept for checking, saving and answering.
const KEPT_SHARE: f64 = 0.05;

/// Minimum time that is kept: for a write to a disk, and an answer that waits for a busy processor.
const LEAST_KEPT: Duration = Duration::from_millis(10);

/// The result of planning a step.
pub(crate) enum Decided {
    Decision(Box<Chosen>),
    NothingFits(Vec<v1::ItemReason>),
    NothingWaits,
}

/// A decision, and what it was made on.
pub(crate) struct Chosen {
    pub(crate) decision: v1::Decision,
    /// The content of its container, without anything blocked.
    pub(crate) before: Scene,
    pub(crate) plan: StepPlan,
    pub(crate) found: Found,
}

impl Stepper {
    /// Plans a step for a request, or for the automatic mode. Where nothing in the buffer has a valid
    /// placement, items are set aside, as many as may be, until one that arrives after them has.
    pub(super) fn decide(
        &mut self,
        request_id: Option<&str>,
        alternatives: usize,
        deadline: Instant,
    ) -> Planned {
        let mut set_aside = Vec::new();
        let decided = self.decide_and_set_aside(request_id, alternatives, deadline, &mut set_aside);
        Planned { set_aside, decided }
    }

    fn decide_and_set_aside(
        &mut self,
        request_id: Option<&str>,
        alternatives: usize,
        deadline: Instant,
        set_aside: &mut Vec<v1::ItemReason>,
    ) -> Result<Decided, NotPlanned> {
        let begun = Instant::now();
        let until = planned_by(begun, deadline);
        let mut items = self.buffered();
        if items.is_empty() {
            return Ok(Decided::NothingWaits);
        }
        let sights = self.look(until)?;
        let waited = begun.elapsed();
        let mut setting_aside = Duration::ZERO;
        let (prepared, found) = loop {
            let mut prepared = self.prepare(&sights, items, alternatives, until)?;
            // Whoever gives a plan less time than it takes wants something by then; nobody waits
            // for the automatic mode.
            prepared.plan.takes_untried = request_id.is_some();
            let found = self.plan(&prepared)?;
            if found.plan.choice().is_some() {
                break (prepared, found);
            }
            let id = self.session.id();
            if let Some(record) = self.recorder.record(id, &prepared.plan, &found, None) {
                self.recorder.publish(&record);
            }
            // What fits nowhere now may fit into a container that comes.
            let may_set_aside = self.session.may_set_aside() && !self.session.is_renewing();
            if may_set_aside {
                in_time(until)?;
            }
            let reason = may_set_aside.then(|| self.find_to_set_aside(&prepared, &found));
            let Some(reason) = reason.transpose()?.flatten() else {
                let reasons = self.reasons(&prepared, &found);
                return Ok(Decided::NothingFits(reasons));
            };
            self.session.set_aside(reason.clone())?;
            set_aside.push(reason);
            setting_aside = begun.elapsed();
            items = self.buffered();
            if items.is_empty() {
                return Ok(Decided::NothingWaits);
            }
        };
        let mut decision = self.decision(request_id, &prepared, &found, deadline)?;
        decision.stages.insert(0, header::stage("prepare", waited));
        if !setting_aside.is_zero() {
            let stage = header::stage("set_aside", setting_aside);
            decision.stages.insert(0, stage);
        }
        let Prepared { plan, mut seen, .. } = prepared;
        let (_, seen) = seen.swap_remove(found.container);
        Ok(Decided::Decision(Box::new(Chosen {
            decision,
            before: seen.scene,
            plan,
            found,
        })))
    }

    fn buffered(&self) -> Vec<v1::SessionItem> {
        let buffer = self.session.buffer(self.settings.method.buffer);
        buffer.cloned().collect()
    }

    /// Gives the largest item of a step in which none has a valid placement, to be set aside, and
    /// why; of equal ones the first to arrive. `None` where there is none: what rules keep out waits
    /// for another container.
    fn find_to_set_aside(
        &mut self,
        prepared: &Prepared,
        found: &Found,
    ) -> Result<Option<v1::ItemReason>, Refusal> {
        let volume_m3 = |item: &&v1::SessionItem| {
            let candidates = &prepared.plan.candidates;
            let held = candidates.get(poses_of(candidates, item).start);
            held.map_or(0.0, |held| held.item.mesh_volume_m3())
        };
        let items = prepared.items.iter();
        let items = items.filter(|item| prepared.barred(item, found.container, true).is_none());
        // Of equal ones, `min_by` gives the first.
        let Some(largest) = items.min_by(|a, b| volume_m3(b).total_cmp(&volume_m3(a))) else {
            return Ok(None);
        };
        let reason = self.reason(prepared, found, largest);
        let lost = || Refusal::new(Status::Failed, "the plan says nothing of an item");
        let reason = reason.ok_or_else(lost)?;
        let v1::ItemReason { item_id, text, .. } = &reason;
        tracing::info!(cell = %self.cell, item_id, reason = text, "set aside");
        Ok(Some(reason))
    }

    pub(super) fn explain(
        &mut self,
        item_id: &str,
        deadline: Instant,
    ) -> Result<v1::ExplainReply, NotPlanned> {
        let items = vec![self.session.waiting(item_id)?.clone()];
        let until = planned_by(Instant::now(), deadline);
        let sights = self.look(until)?;
        let prepared = self.prepare(&sights, items, 0, until)?;
        let found = self.plan(&prepared)?;
        let choice = found.plan.choice();
        let reasons = match &choice {
            Some(_) => Vec::new(),
            None => self.reasons(&prepared, &found),
        };
        Ok(v1::ExplainReply {
            best: choice
                .as_ref()
                .map(|best| write_ranked(&prepared.plan.items, &found.candidates, best)),
            reason: reasons.into_iter().next(),
            counts: Some(write_reports(found.plan.candidates())),
            ..v1::ExplainReply::default()
        })
    }

    /// Plans a step over the open containers: the fullest that can take an item of the buffer.
    /// Rules that give way do so where nothing could be packed with them.
    ///
    /// # Errors
    /// [`Status::Unavailable`] where nothing fits into those that are seen, and others are not.
    fn plan(&mut self, prepared: &Prepared) -> Result<Found, Refusal> {
        let found = prepared.plan.plan(self)?;
        let none = || Refusal::new(Status::Failed, "no container was planned on");
        let found = found.ok_or_else(none)?;
        if found.plan.choice().is_none() && !prepared.left_out.is_empty() {
            return Err(Refusal::unavailable(prepared.left_out.join("; ")));
        }
        Ok(found)
    }

    fn decision(
        &mut self,
        request_id: Option<&str>,
        prepared: &Prepared,
        found: &Found,
        deadline: Instant,
    ) -> Result<v1::Decision, Refusal> {
        let lost = || Refusal::new(Status::Failed, "the plan chose an item that is not there");
        let (_, seen) = prepared.seen.get(found.container).ok_or_else(lost)?;
        let chosen = prepared.plan.decision(found).ok_or_else(lost)?;
        let container = self.container(&chosen.container)?;
        let decided_at_ns = container.bridge.now_ns(deadline);
        let Found { plan, timings, .. } = found;
        Ok(v1::Decision {
            decision_id: format!("{:032x}", rand::random::<u128>()),
            request_id: request_id.unwrap_or_default().to_owned(),
            session_id: self.session.id().to_owned(),
            step: self.session.step(),
            heightmap: Some(seen.id),
            state_number: seen.state_number,
            degraded: [plan.degraded(), &prepared.left_out].concat(),
            stages: vec![
                header::stage("propose", timings.propose),
                header::stage("evaluate", timings.evaluate),
                header::stage("check", timings.check),
            ],
            set_aside: self.session.reasons_set_aside_now(),
            decided_at_ns,
            ..chosen
        })
    }

    fn reasons(&mut self, prepared: &Prepared, found: &Found) -> Vec<v1::ItemReason> {
        let items = prepared.items.iter();
        let reasons = items.filter_map(|item| self.reason(prepared, found, item));
        reasons.collect()
    }

    /// Says why an item of the buffer has no valid placement: in the first of its poses, and in the
    /// container that holds least. An item that only blocked regions keep out is told apart, by
    /// planning on the scene without them.
    fn reason(
        &mut self,
        prepared: &Prepared,
        found: &Found,
        item: &v1::SessionItem,
    ) -> Option<v1::ItemReason> {
        let is_looked_at = !poses_of(&found.candidates, item).is_empty();
        if let Some(text) = prepared.barred(item, found.container, is_looked_at) {
            return Some(v1::ItemReason {
                item_id: item.item_id.clone(),
                reason: v1::Reason::Rule.into(),
                text,
            });
        }
        let Prepared { plan, seen, .. } = prepared;
        let container = plan.containers.get(found.container)?;
        let (_, seen) = seen.get(found.container)?;
        let poses = poses_of(&plan.candidates, item);
        let alone = StepInput {
            alternatives: 0,
            takes_untried: false,
            ..plan.input(container, &seen.scene, plan.candidates.get(poses)?)
        };
        let is_blocked = self.fits_without_regions(&container.name, &alone);
        let report = found.plan.candidates();
        let report = report.get(poses_of(&found.candidates, item).start);
        let reason = report.and_then(|report| report.reason.as_ref());
        Some(write_reason(&item.item_id, reason, is_blocked))
    }

    fn fits_without_regions(&mut self, container: &str, alone: &StepInput<'_>) -> bool {
        let known = self.session.container(container);
        let is_kept = known.is_ok_and(|container| !container.keep_out.is_empty());
        let is_fragile = |item: &v1::SessionItem| item.rules.is_some_and(|rules| rules.is_fragile);
        let has_regions = is_kept || self.session.packed_in(container).any(is_fragile);
        // A reason that comes too late is none.
        let has_time = alone
            .deadline
            .is_none_or(|deadline| Instant::now() < deadline);
        let plan = (has_regions && has_time).then(|| self.plan_in(container, alone));
        plan.is_some_and(|plan| plan.is_ok_and(|plan| plan.choice().is_some()))
    }
}

impl PlansContainers for Stepper {
    type Error = Refusal;

    fn plan_in(&mut self, container: &str, input: &StepInput<'_>) -> Result<Plan, Refusal> {
        let plan = self.container(container)?.planning.plan(input)?.clone();
        if plan.choice().is_none() && plan.is_cut() {
            let late =
                "the time limit passed before a valid placement was found: give it more time";
            return Err(Refusal::new(Status::TimedOut, late));
        }
        Ok(plan)
    }
}

/// Gives when a step has to be planned, for its answer to come by the deadline.
fn planned_by(now: Instant, deadline: Instant) -> Instant {
    let left = deadline.saturating_duration_since(now);
    let kept = left.mul_f64(KEPT_SHARE).max(LEAST_KEPT);
    now + left.saturating_sub(kept)
}

pub(crate) fn in_time(deadline: Instant) -> Result<(), Refusal> {
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

/// Adds up the placements of an item, in all of its poses.
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
