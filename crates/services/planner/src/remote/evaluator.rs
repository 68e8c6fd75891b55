//! Evaluation by a heuristic service; what none answers is searched in the planner.

use std::collections::VecDeque;

use ppnpack_packing::planning::method::{Method, Stability};
use ppnpack_packing::planning::valid::Tally;
use ppnpack_packing::ranking::evaluator::Evaluator;
use ppnpack_packing::ranking::proposals::{CandidateProposals, Proposals};
use ppnpack_packing::ranking::refusal::Refusals;
use ppnpack_packing::ranking::search::Search;
use ppnpack_packing::ranking::step::{
    Evaluated, PlacementCounts, Shortfall, StageError, StepInput,
};
use ppnpack_wire::error::WireError;
use ppnpack_wire::{convert, v1};

use super::items::ItemMessages;
use super::peers::Peers;

/// Minimum number of placements that a service is asked for: some do not pass the planner's checks.
const LEAST_ASKED: usize = 64;

/// Asks a heuristic service once in a step.
pub(crate) struct ServiceEvaluator {
    peers: Peers,
    method: Method,
    items: ItemMessages,
    /// The planner's own search.
    own: Search,
    group: Vec<usize>,
    proposals: Proposals,
    /// The placements of a service's answer that are left, until more are wanted.
    answer: Option<VecDeque<Evaluated>>,
    /// The placements of it that were given already.
    given: Vec<Evaluated>,
    /// The service's counts of placements.
    tallies: Vec<Tally>,
    shortfall: Shortfall,
}

impl ServiceEvaluator {
    pub(crate) fn new(peers: Peers, method: &Method, own: Search) -> Self {
        Self {
            peers,
            method: method.clone(),
            items: ItemMessages::default(),
            own,
            group: Vec::new(),
            proposals: Proposals::default(),
            answer: None,
            given: Vec::new(),
            tallies: Vec::new(),
            shortfall: Shortfall::default(),
        }
    }

    /// Has a service find the best placements; gives them as the planner's own search values them.
    fn ask(&mut self, input: &StepInput<'_>) -> Result<VecDeque<Evaluated>, String> {
        let instance = self.peers.chosen();
        let instance = instance.ok_or("no heuristic service is alive")?;
        let number = |number: usize| u32::try_from(number).unwrap_or(u32::MAX);
        let parts = self.group.iter().map(|candidate| v1::SearchPart {
            candidate: number(*candidate),
            proposals: match self.proposals.of(*candidate) {
                CandidateProposals::All => None,
                CandidateProposals::Some(placements) => {
                    Some(convert::placement::write_all(placements.iter().copied()))
                }
            },
        });
        let request = v1::EvaluateRequest {
            scene: Some(convert::scene::write(input.grid, input.scene)),
            parts: parts.collect(),
            objective: Some(convert::objective::write(&self.method.search_settings())),
            checks: checks(self.method.stability),
            limit: number(input.wanted().max(LEAST_ASKED)),
            step: input.step,
            ..v1::EvaluateRequest::default()
        };
        let reply = self.items.ask(&self.peers, &instance, input, |ids, items| {
            let candidates = ids.iter().zip(input.candidates);
            v1::EvaluateRequest {
                candidates: candidates
                    .map(|(id, held)| v1::CandidateItem {
                        item_id: id.to_bytes(),
                        arrival: held.arrival as u64,
                        pose: number(held.pose),
                    })
                    .collect(),
                items,
                ..request.clone()
            }
        });
        let failed = |error: String| format!("heuristic service {instance} failed ({error})");
        let reply = reply.map_err(|error| failed(error.to_string()))?;
        let (named, tallies) = read_reply(&reply).map_err(|error| failed(error.to_string()))?;
        let own = self.own_of(input, &named);
        let own = own.map_err(|error| failed(error.to_string()))?;
        let own = own.ok_or_else(|| failed("it names placements that are none".to_owned()))?;
        self.tallies = tallies;
        Ok(own)
    }

    /// Values placements by the planner's own search; `None` where they are not those that were
    /// asked for, or lie otherwise. Whoever answers may be mistaken, or a stranger.
    fn own_of(
        &mut self,
        input: &StepInput<'_>,
        named: &[Evaluated],
    ) -> Result<Option<VecDeque<Evaluated>>, StageError> {
        let is_asked_for = |found: &Evaluated| {
            let is_proposed = match self.proposals.of(found.candidate) {
                CandidateProposals::All => true,
                CandidateProposals::Some(placements) => {
                    placements.contains(&found.resting.placement)
                }
            };
            is_proposed && self.group.contains(&found.candidate)
        };
        if !named.iter().all(is_asked_for) {
            return Ok(None);
        }
        let mut proposals = Proposals::default();
        for candidate in 0..input.candidates.len() {
            let of_it = named.iter().filter(|found| found.candidate == candidate);
            proposals.push(of_it.map(|found| found.resting.placement));
        }
        let is_named = |candidate: &usize| named.iter().any(|found| found.candidate == *candidate);
        let group: Vec<usize> = self.group.iter().copied().filter(is_named).collect();
        self.own.rank(input, &group, &proposals)?;
        let mut own = VecDeque::new();
        while let Some(found) = self.next_own(input)? {
            if !named.iter().any(|named| is_same(named, &found)) {
                return Ok(None);
            }
            own.push_back(found);
        }
        // For want of time some are left out.
        Ok((own.len() == named.len() || self.shortfall.is_cut).then_some(own))
    }

    /// Gives the next placement of the planner's own search.
    fn next_own(&mut self, input: &StepInput<'_>) -> Result<Option<Evaluated>, StageError> {
        let next = self.own.next_best(input)?;
        if let Some(own) = self.own.shortfall() {
            self.shortfall.add(own);
        }
        Ok(next)
    }
}

impl Evaluator for ServiceEvaluator {
    fn rank(
        &mut self,
        input: &StepInput<'_>,
        group: &[usize],
        proposals: &Proposals,
    ) -> Result<(), StageError> {
        self.shortfall.clear();
        self.tallies.clear();
        self.group = group.to_vec();
        self.proposals = proposals.clone();
        self.answer = None;
        self.given.clear();
        match self.ask(input) {
            Ok(answer) => self.answer = Some(answer),
            Err(reason) => {
                self.shortfall
                    .degrade(format!("{reason}: searched in the planner"));
                self.own.rank(input, group, proposals)?;
            }
        }
        Ok(())
    }

    fn next_best(&mut self, input: &StepInput<'_>) -> Result<Option<Evaluated>, StageError> {
        if let Some(answer) = &mut self.answer {
            if let Some(next) = answer.pop_front() {
                self.given.push(next);
                return Ok(Some(next));
            }
            // That nothing else is possible the planner sees for itself.
            self.answer = None;
            self.tallies.clear();
            self.own.rank(input, &self.group, &self.proposals)?;
        }
        while let Some(next) = self.next_own(input)? {
            if !self.given.iter().any(|given| is_same(given, &next)) {
                return Ok(Some(next));
            }
        }
        Ok(None)
    }

    fn counts(&self, candidate: usize) -> PlacementCounts {
        match &self.answer {
            None => self.own.counts(candidate),
            Some(_) => self
                .tallies
                .iter()
                .find(|tally| tally.candidate == candidate)
                .map_or_else(PlacementCounts::default, |tally| tally.counts),
        }
    }

    fn add_refusals(&self, candidate: usize, refusals: &mut Refusals) {
        let tallies = self.tallies.iter();
        for tally in tallies.filter(|tally| tally.candidate == candidate) {
            refusals.add(&tally.refusals);
        }
    }

    fn shortfall(&self) -> Option<&Shortfall> {
        Some(&self.shortfall)
    }
}

/// Gives the checks of a stability test, as requests name them.
fn checks(stability: Stability) -> Vec<i32> {
    match stability {
        Stability::Physical => vec![v1::Check::PhysicalStability.into()],
        Stability::Published => vec![v1::Check::PublishedStability.into()],
        Stability::None => Vec::new(),
    }
}

/// Says whether both are the same item at the same place. The last digits of values may differ
/// between processors.
fn is_same(one: &Evaluated, other: &Evaluated) -> bool {
    (one.candidate, one.resting) == (other.candidate, other.resting)
}

fn read_reply(reply: &v1::EvaluateReply) -> Result<(Vec<Evaluated>, Vec<Tally>), WireError> {
    let placements = reply.placements.iter().map(convert::placement::read_ranked);
    let tallies = reply.counts.iter().map(convert::placement::read_tally);
    Ok((
        placements.collect::<Result<_, _>>()?,
        tallies.collect::<Result<_, _>>()?,
    ))
}

#[cfg(test)]
mod tests;
