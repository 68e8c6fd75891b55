//! Evaluation by a heuristic service; what none answers is searched in the planner.

use std::collections::VecDeque;

use ppnpack_packing::evaluator::Evaluator;
use ppnpack_packing::method::{Method, Stability};
use ppnpack_packing::proposals::{CandidateProposals, Proposals};
use ppnpack_packing::refusal::Refusals;
use ppnpack_packing::search::Search;
use ppnpack_packing::step::{Evaluated, PlacementCounts, Shortfall, StageError, StepInput};
use ppnpack_packing::valid::Tally;
use ppnpack_wire::error::WireError;
use ppnpack_wire::{convert, v1};

use super::items::ItemMessages;
use super::peers::Peers;

/// The placements that a service is asked for, where no more are wanted at once: some do not pass the checks of the planner.
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
    /// What a service answered, until more is wanted.
    answer: Option<Answer>,
    /// What the service says became of the placements.
    tallies: Vec<Tally>,
    shortfall: Shortfall,
}

/// The best placements that pass the service's checks.
struct Answer {
    placements: VecDeque<Evaluated>,
    last: Option<Evaluated>,
    is_complete: bool,
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
            tallies: Vec::new(),
            shortfall: Shortfall::default(),
        }
    }

    /// Has a service find the best placements.
    fn ask(&mut self, input: &StepInput<'_>) -> Result<Answer, String> {
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
        let (answer, tallies) = read_reply(&reply).map_err(|error| failed(error.to_string()))?;
        self.tallies = tallies;
        Ok(answer)
    }

    /// The next placement of the planner's own search.
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
        let Some(answer) = &mut self.answer else {
            return self.next_own(input);
        };
        let next = answer.placements.pop_front();
        if next.is_some() || answer.is_complete {
            return Ok(next);
        }
        // The planner goes on where the service stopped.
        let last = answer.last;
        self.answer = None;
        self.own.rank(input, &self.group, &self.proposals)?;
        while let Some(next) = self.next_own(input)? {
            if last.is_none_or(|last| next.rank_cmp(&last).is_gt()) {
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

/// The checks of a stability test, as requests name them.
fn checks(stability: Stability) -> Vec<i32> {
    match stability {
        Stability::Physical => vec![v1::Check::PhysicalStability.into()],
        Stability::Published => vec![v1::Check::PublishedStability.into()],
        Stability::None => Vec::new(),
    }
}

fn read_reply(reply: &v1::EvaluateReply) -> Result<(Answer, Vec<Tally>), WireError> {
    let placements = reply.placements.iter().map(convert::placement::read_ranked);
    let placements: VecDeque<Evaluated> = placements.collect::<Result<_, _>>()?;
    let tallies = reply.counts.iter().map(convert::placement::read_tally);
    let answer = Answer {
        last: placements.back().copied(),
        placements,
        is_complete: reply.is_complete,
    };
    Ok((answer, tallies.collect::<Result<_, _>>()?))
}

#[cfg(test)]
mod tests;
