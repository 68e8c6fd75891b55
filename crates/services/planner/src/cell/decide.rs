//! From a request to a decision: the scene, the buffer, the plan.

use std::time::Instant;

use ppnpack_packing::blocked::block;
use ppnpack_packing::heightmap::Scene;
use ppnpack_packing::plan::{CandidateReport, Plan, Reason};
use ppnpack_packing::step::{Candidate, Evaluated};
use ppnpack_packing::valid::Tally;
use ppnpack_wire::v1::{self, Status};
use ppnpack_wire::{convert, header};

use super::CellPlanner;
use super::footprint::footprint;
use super::refusal::Refusal;
use crate::planning::Step;
use crate::scenes::Seen;
use crate::session::{ItemState, SessionItem};

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
}

impl CellPlanner {
    /// Plans the next step and enters the decision; it is on disk when this returns.
    pub(crate) fn decide(
        &mut self,
        request_id: &str,
        alternatives: usize,
        deadline: Instant,
    ) -> Result<Decided, Refusal> {
        let started = Instant::now();
        let buffer = self.session.buffer(self.settings.method.buffer);
        let items: Vec<_> = buffer.map(|(at, item)| (at, item.clone())).collect();
        if items.is_empty() {
            return Ok(Decided::NothingWaits);
        }
        let prepared = self.prepare(items, deadline)?;
        let waited = started.elapsed();
        let planned = self.plan(&prepared.step(alternatives))?;
        let Some(choice) = planned.choice() else {
            let reasons = self.reasons(&prepared, planned.candidates());
            return Ok(Decided::NothingFits(reasons));
        };
        if Instant::now() >= deadline {
            // Whoever asked has left, and a decision that nobody knows of keeps others waiting.
            let late = "the time limit passed while planning";
            return Err(Refusal::new(Status::TimedOut, late));
        }
        let mut decision = self.decision(request_id, &prepared, &choice, &planned)?;
        decision.stages.insert(0, header::stage("prepare", waited));
        let saving = Instant::now();
        let entered = decision.clone();
        self.change(|session| session.decide(entered))?;
        decision
            .stages
            .push(header::stage("save", saving.elapsed()));
        self.will_inspect(&decision, &prepared.seen.scene);
        self.news.decisions.push(decision.clone());
        Ok(Decided::Decision(Box::new(decision)))
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
            best: choice.as_ref().map(convert::placement::write_ranked),
            reason: reasons.into_iter().next(),
            counts: planned.candidates().first().map(write_report),
            ..v1::ExplainReply::default()
        })
    }

    /// Gets what a step is planned on; waits for a heightmap until the deadline.
    fn prepare(
        &mut self,
        items: Vec<(usize, SessionItem)>,
        deadline: Instant,
    ) -> Result<Prepared, Refusal> {
        let candidate = |(arrival, item): &(usize, SessionItem)| {
            let shape = self.shape(item)?;
            Ok(Candidate {
                arrival: *arrival,
                item: shape.item,
                model: shape.model,
                lying: item.lying,
                rules: item.rules,
            })
        };
        let candidates: Result<_, Refusal> = items.iter().map(candidate).collect();
        let candidates = candidates?;
        let least = self.session.least_state_number();
        let seen = self.scenes.current(least, deadline);
        let seen = seen.map_err(Refusal::unavailable)?;
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
                planned,
                container_from_item,
                ..
            } = &item.state
            {
                let shape = self.shape(item)?.item;
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
        let plan = plan.map_err(|error| Refusal::new(Status::Failed, error))?;
        if plan.choice().is_none() && plan.is_cut() {
            let late =
                "the time limit passed before a valid placement was found: give it more time";
            return Err(Refusal::new(Status::TimedOut, late));
        }
        Ok(plan.clone())
    }

    fn decision(
        &self,
        request_id: &str,
        prepared: &Prepared,
        choice: &Evaluated,
        planned: &Plan,
    ) -> Result<v1::Decision, Refusal> {
        let lost = || Refusal::new(Status::Failed, "the plan chose an item that is not there");
        let Prepared { items, seen, .. } = prepared;
        let (_, item) = items.get(choice.candidate).ok_or_else(lost)?;
        let held = prepared.candidates.get(choice.candidate).ok_or_else(lost)?;
        let pose = held
            .item
            .container_from_item(self.planning.grid(), &choice.resting);
        let container_from_item = item.lying.own_frame(&pose.ok_or_else(lost)?);
        let cycle = planned.evidence().and_then(|found| found.cycle.as_ref());
        let timings = planned.timings();
        let stages = vec![
            header::stage("propose", timings.propose),
            header::stage("evaluate", timings.evaluate),
            header::stage("check", timings.check),
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
                .map(convert::placement::write_ranked)
                .collect(),
            buffer: items.iter().map(|(_, item)| item.item_id.clone()).collect(),
            heightmap: Some(seen.id),
            state_number: seen.state_number,
            degraded: planned.degraded().to_vec(),
            is_widened: planned.is_widened(),
            stages,
            cycle: cycle.map(|cycle| Box::new(convert::cycle::write(cycle))),
        })
    }

    /// Why the items of the buffer have no valid placement. What only the blocked regions keep out is told apart, by
    /// planning on the scene without them.
    fn reasons(&mut self, prepared: &Prepared, reports: &[CandidateReport]) -> Vec<v1::ItemReason> {
        let mut reasons = Vec::with_capacity(prepared.items.len());
        let candidates = prepared.candidates.iter().zip(reports);
        for ((_, item), (candidate, report)) in prepared.items.iter().zip(candidates) {
            let is_blocked = self.fits_without_regions(&Step {
                scene: &prepared.seen.scene,
                candidates: std::slice::from_ref(candidate),
                ..prepared.step(0)
            });
            let reason = report.reason.as_ref();
            reasons.push(write_reason(&item.item_id, reason, is_blocked));
        }
        reasons
    }

    fn fits_without_regions(&mut self, alone: &Step<'_>) -> bool {
        let mut items = self.session.items().iter();
        let has_regions =
            !self.session.keep_out().is_empty() || items.any(|item| item.rules.is_fragile);
        has_regions && self.plan(alone).is_ok_and(|plan| plan.choice().is_some())
    }
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

fn write_report(report: &CandidateReport) -> v1::PlacementCounts {
    convert::placement::write_tally(&Tally {
        candidate: 0,
        counts: report.counts,
        refusals: report.refusals.clone(),
    })
}
