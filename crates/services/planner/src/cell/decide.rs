//! From a request to a decision: the scene, the buffer, the plan.

use std::collections::HashMap;
use std::time::Instant;

use ppnpack_packing::blocked::block;
use ppnpack_packing::heightmap::Scene;
use ppnpack_packing::plan::{CandidateReport, Reason};
use ppnpack_packing::step::Candidate;
use ppnpack_packing::valid::Tally;
use ppnpack_robot::feasibility::NAME;
use ppnpack_wire::v1::{self, Status};
use ppnpack_wire::{convert, header};

use super::footprint::footprint;
use super::{CellPlanner, Refusal};
use crate::planning::{Planned, Wanted};
use crate::scenes::Seen;
use crate::session::{ItemState, SessionItem};

/// What planning a step led to.
pub(crate) enum Decided {
    Decision(Box<v1::Decision>),
    NothingFits(Vec<v1::ItemReason>),
    NothingWaits,
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
        let buffer: Vec<(usize, SessionItem)> = self
            .session
            .buffer(self.settings.buffer)
            .map(|(arrival, item)| (arrival, item.clone()))
            .collect();
        if buffer.is_empty() {
            return Ok(Decided::NothingWaits);
        }
        let candidates = self.candidates(&buffer)?;
        let seen = self.seen(deadline)?;
        let scene = self.blocked(&seen.scene)?;
        let waited = started.elapsed();
        let planned = self.plan(&scene, &buffer, &candidates, alternatives, deadline)?;
        if planned.choice.is_none() {
            let reasons = self.reasons(&seen.scene, &buffer, &candidates, &planned, deadline);
            return Ok(Decided::NothingFits(reasons));
        }
        if Instant::now() >= deadline {
            // Whoever asked has left, and a decision that nobody knows of keeps others waiting.
            let late = "the time limit passed while planning";
            return Err(Refusal::new(Status::TimedOut, late));
        }
        let mut decision =
            self.decision(request_id, (&seen, &scene), &buffer, &candidates, planned)?;
        decision.stages.insert(0, header::stage("prepare", waited));
        let saving = Instant::now();
        let entered = decision.clone();
        self.change(|session| session.decide(entered))?;
        decision
            .stages
            .push(header::stage("save", saving.elapsed()));
        self.will_inspect(&decision, &seen.scene);
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
        let buffer = vec![(arrival, item.clone())];
        let candidates = self.candidates(&buffer)?;
        let seen = self.seen(deadline)?;
        let scene = self.blocked(&seen.scene)?;
        let planned = self.plan(&scene, &buffer, &candidates, 0, deadline)?;
        let refusals = planned.refusals.first().cloned().unwrap_or_default();
        let counts = planned.reports.first();
        let counts = counts.map(|report| write_report(report, refusals));
        let reasons = match planned.choice {
            Some(_) => Vec::new(),
            None => self.reasons(&seen.scene, &buffer, &candidates, &planned, deadline),
        };
        Ok(v1::ExplainReply {
            best: planned
                .choice
                .as_ref()
                .map(convert::placement::write_ranked),
            reason: reasons.into_iter().next(),
            counts,
            ..v1::ExplainReply::default()
        })
    }

    fn candidates(&mut self, buffer: &[(usize, SessionItem)]) -> Result<Vec<Candidate>, Refusal> {
        let candidate = |(arrival, item): &(usize, SessionItem)| {
            let held = self.item(item)?;
            if let Some(station) = self.planning.station() {
                station.pick_from(*arrival, item.lying.heightmap_frame());
            }
            Ok(Candidate {
                arrival: *arrival,
                item: held,
            })
        };
        buffer.iter().map(candidate).collect()
    }

    fn seen(&mut self, deadline: Instant) -> Result<Seen, Refusal> {
        let least = self.session.least_state_number();
        self.scenes
            .current(least, deadline)
            .map_err(|reason| Refusal::new(Status::Unavailable, reason))
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
                let shape = self.item(item)?;
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

    fn plan(
        &mut self,
        scene: &Scene,
        buffer: &[(usize, SessionItem)],
        candidates: &[Candidate],
        alternatives: usize,
        deadline: Instant,
    ) -> Result<Planned, Refusal> {
        let rules = buffer.iter().map(|(arrival, item)| (*arrival, item.rules));
        let wanted = Wanted {
            step: self.session.step(),
            alternatives,
            deadline,
            rules: rules.collect::<HashMap<_, _>>(),
        };
        let planned = self
            .planning
            .plan(scene, candidates, wanted)
            .map_err(|error| Refusal::new(Status::Failed, error))?;
        if planned.choice.is_none() && planned.is_cut {
            let late =
                "the time limit passed before a valid placement was found: give it more time";
            return Err(Refusal::new(Status::TimedOut, late));
        }
        Ok(planned)
    }

    fn decision(
        &self,
        request_id: &str,
        (seen, scene): (&Seen, &Scene),
        buffer: &[(usize, SessionItem)],
        candidates: &[Candidate],
        planned: Planned,
    ) -> Result<v1::Decision, Refusal> {
        let lost = || Refusal::new(Status::Failed, "the plan chose an item that is not there");
        let choice = planned.choice.ok_or_else(lost)?;
        let (_, item) = buffer.get(choice.candidate).ok_or_else(lost)?;
        let held = candidates.get(choice.candidate).ok_or_else(lost)?;
        let pose = held
            .item
            .container_from_item(self.planning.grid(), &choice.resting);
        let container_from_item = item.lying.own_frame(&pose.ok_or_else(lost)?);
        let cycle = self.planning.cycle(scene, held, &choice, &item.lying);
        let cycle = cycle.map_err(|refusal| {
            Refusal::new(Status::Failed, format_args!("the arm's cycle: {refusal}"))
        })?;
        let timings = planned.timings;
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
                .alternatives
                .iter()
                .map(convert::placement::write_ranked)
                .collect(),
            buffer: buffer
                .iter()
                .map(|(_, item)| item.item_id.clone())
                .collect(),
            heightmap: Some(seen.id),
            state_number: seen.state_number,
            degraded: planned.degraded,
            is_widened: planned.is_widened,
            stages,
            cycle: cycle.map(Box::new),
        })
    }

    /// Why the items of the buffer have no valid placement. What only the blocked regions keep out is told apart.
    fn reasons(
        &mut self,
        scene: &Scene,
        buffer: &[(usize, SessionItem)],
        candidates: &[Candidate],
        planned: &Planned,
        deadline: Instant,
    ) -> Vec<v1::ItemReason> {
        // Planning without the regions is another step for the arm, which forgets this one.
        let of_arm: Vec<Option<String>> = buffer
            .iter()
            .map(|(arrival, _)| self.planning.station()?.why(*arrival))
            .collect();
        let mut reasons = Vec::with_capacity(buffer.len());
        let reports = planned.reports.iter().zip(of_arm);
        for (index, (entry, (report, of_arm))) in buffer.iter().zip(reports).enumerate() {
            let Some(candidate) = candidates.get(index) else {
                continue;
            };
            let is_blocked = self.fits_without_regions(scene, entry, candidate, deadline);
            let mut reason = write_reason(&entry.1.item_id, report.reason, is_blocked);
            if let (Some(Reason::Rejected(NAME)), Some(why), false) =
                (report.reason, of_arm, is_blocked)
            {
                reason.text = format!("{}: {why}", reason.text);
            }
            reasons.push(reason);
        }
        reasons
    }

    fn fits_without_regions(
        &mut self,
        scene: &Scene,
        entry: &(usize, SessionItem),
        candidate: &Candidate,
        deadline: Instant,
    ) -> bool {
        let has_regions = !self.session.keep_out().is_empty()
            || self
                .session
                .items()
                .iter()
                .any(|item| item.rules.is_fragile);
        if !has_regions {
            return false;
        }
        let (buffer, candidates) = ([entry.clone()], [candidate.clone()]);
        let planned = self.plan(scene, &buffer, &candidates, 0, deadline);
        planned.is_ok_and(|planned| planned.choice.is_some())
    }
}

fn write_reason(item_id: &str, reason: Option<Reason>, is_blocked: bool) -> v1::ItemReason {
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

fn write_report(
    report: &CandidateReport,
    refusals: Vec<(&'static str, u64)>,
) -> v1::PlacementCounts {
    convert::placement::write_tally(&Tally {
        candidate: 0,
        counts: report.counts,
        refusals,
    })
}
