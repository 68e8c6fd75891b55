//! Evaluation by the heuristic services that are alive, all together; what they do not answer is searched here, and,
//! where that is wanted, what is found sooner here.

use std::sync::Arc;
use std::time::{Duration, Instant};

use ppnpack_packing::item::Item;
use ppnpack_packing::plan::Evaluator;
use ppnpack_packing::proposals::{Proposals, possible_count_at, possible_count_below_rim};
use ppnpack_packing::search::SearchSettings;
use ppnpack_packing::step::{Evaluated, PlacementCounts, StageError, StepInput};
use ppnpack_packing::valid::{BestValid, Tally, ValidSearch};
use ppnpack_service::alive::Alive;
use ppnpack_service::rpc::{CallError, Client, PendingCall};
use ppnpack_wire::error::WireError;
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::keys::{Cell, Instance};
use ppnpack_wire::{convert, v1};

use super::context::StepContext;
use super::items::ItemMessages;
use super::local::LocalSearch;
use super::merge::merge;
use super::pace::Pace;
use super::split::{Part, parts, split};

/// The most placements that a service is asked for at once.
const MAX_LIMIT: usize = 65_536;

/// How many times more placements are asked for when those that came were not enough.
const GROWTH: usize = 8;

/// What is left of the time limit for the rest of the step when a search stops.
const RESERVE: Duration = Duration::from_millis(3);

/// Replicas that share a step at most.
const MAX_REPLICAS: usize = 16;

/// Evaluates with others.
pub(crate) struct SharedEvaluator {
    cell: Cell,
    client: Client,
    alive: Arc<Alive>,
    context: Arc<StepContext>,
    limit: Duration,
    settings: SearchSettings,
    checks: Vec<i32>,
    local: LocalSearch,
    pace: Pace,
    /// Whether the sooner way is taken; the services' otherwise.
    is_sooner_taken: bool,
    items: ItemMessages,
    parts: Vec<Part>,
    asked: usize,
    given: usize,
    best: BestValid,
}

/// A share of the work that a service was asked to do.
struct Begun {
    instance: Instance,
    share: Vec<Part>,
    call: Result<PendingCall<v1::EvaluateRequest>, CallError>,
}

/// What the services are asked to judge by, and what stands in for them.
pub(crate) struct Judgement {
    pub(crate) settings: SearchSettings,
    /// The checks that placements must pass, as on the wire.
    pub(crate) checks: Vec<i32>,
    /// The same in this process.
    pub(crate) local: ValidSearch,
}

impl SharedEvaluator {
    pub(crate) fn new(
        cell: Cell,
        client: Client,
        alive: Arc<Alive>,
        context: Arc<StepContext>,
        limit: Duration,
        judgement: Judgement,
    ) -> Self {
        Self {
            cell,
            client,
            alive,
            context,
            limit,
            settings: judgement.settings,
            checks: judgement.checks,
            local: LocalSearch::new(judgement.local),
            pace: Pace::default(),
            is_sooner_taken: false,
            items: ItemMessages::default(),
            parts: Vec::new(),
            asked: 0,
            given: 0,
            best: BestValid::default(),
        }
    }

    /// Searches in this process what is found sooner that way.
    #[must_use]
    pub(crate) fn sooner_way(mut self) -> Self {
        self.is_sooner_taken = true;
        self
    }

    /// Has everything searched for the best `limit` placements.
    fn fetch(&mut self, input: &StepInput<'_>, limit: usize) -> Result<BestValid, StageError> {
        let mut alive = self.alive.instances();
        alive.truncate(MAX_REPLICAS);
        if alive.is_empty() {
            self.context
                .degrade("no heuristic service is alive: searched in the planner".to_owned());
            return self.search_all_here(input, limit);
        }
        let placements = placements(&self.parts, input);
        let (replicas, started) = (alive.len(), Instant::now());
        if self.is_sooner_taken && self.pace.is_sooner_here(placements, replicas) {
            return self.search_all_here(input, limit);
        }
        let found = self.ask(input, limit, alive)?;
        self.pace.asked(placements, replicas, started.elapsed());
        Ok(found)
    }

    fn search_all_here(
        &mut self,
        input: &StepInput<'_>,
        limit: usize,
    ) -> Result<BestValid, StageError> {
        let parts = std::mem::take(&mut self.parts);
        let found = self.search_here(input, &parts, limit);
        self.parts = parts;
        found
    }

    /// Has services search, each its share.
    fn ask(
        &mut self,
        input: &StepInput<'_>,
        limit: usize,
        alive: Vec<Instance>,
    ) -> Result<BestValid, StageError> {
        let shares = split(&self.parts, input.candidates, alive.len());
        let now = Instant::now();
        let left = self.context.deadline().saturating_duration_since(now);
        let deadline = now + self.limit.min(left / 2);
        let shares = alive.into_iter().zip(shares);
        let begun: Vec<Begun> = shares
            .filter(|(_, share)| !share.is_empty())
            .map(|(instance, share)| {
                let request = self.request(&instance, input, &share, limit);
                let call = self
                    .client
                    .begin_instance(&self.cell, &instance, request, deadline);
                Begun {
                    instance,
                    share,
                    call,
                }
            })
            .collect();
        let mut found = Vec::with_capacity(begun.len());
        for begun in begun {
            let (instance, share) = (begun.instance.clone(), begun.share.clone());
            found.push(match self.finish(begun, input, limit, deadline) {
                Ok(best) => best,
                Err(reason) => {
                    self.context.degrade(format!(
                        "heuristic service {instance} did not answer ({reason}): its part was searched in the planner"
                    ));
                    self.search_here(input, &share, limit)?
                }
            });
        }
        Ok(merge(found, limit))
    }

    fn request(
        &mut self,
        instance: &Instance,
        input: &StepInput<'_>,
        share: &[Part],
        limit: usize,
    ) -> v1::EvaluateRequest {
        let items = || input.candidates.iter().map(|held| &*held.item);
        let ids = self.items.ids(items());
        let candidates = ids.iter().zip(input.candidates);
        v1::EvaluateRequest {
            scene: Some(convert::scene::write(input.grid, input.scene)),
            candidates: candidates
                .map(|(id, held)| v1::CandidateItem {
                    item_id: id.to_bytes(),
                    arrival: held.arrival as u64,
                })
                .collect(),
            items: self.items.unsent(instance, items()),
            parts: share.iter().map(write_part).collect(),
            objective: Some(convert::objective::write(&self.settings)),
            checks: self.checks.clone(),
            limit: u32::try_from(limit).unwrap_or(u32::MAX),
            step: input.step,
            ..v1::EvaluateRequest::default()
        }
    }

    fn finish(
        &mut self,
        begun: Begun,
        input: &StepInput<'_>,
        limit: usize,
        deadline: Instant,
    ) -> Result<BestValid, String> {
        let instance = &begun.instance;
        let answer = match begun.call.and_then(PendingCall::wait) {
            Err(error) if error.status() == Some(v1::Status::MissingItems) => {
                self.items.forget(instance);
                let request = self.request(instance, input, &begun.share, limit);
                self.client
                    .call_instance(&self.cell, instance, request, deadline)
            }
            answer => answer,
        };
        let reply = answer.map_err(|error| error.to_string())?;
        let ids: Vec<ItemId> = self
            .items
            .ids(input.candidates.iter().map(|held| &*held.item));
        self.items.has(instance, &ids);
        read_reply(&reply).map_err(|error| error.to_string())
    }

    /// Searches in this process: whole where that is expected to take less than half of the time left, by parts
    /// otherwise, so that there is an answer when the time is over.
    fn search_here(
        &mut self,
        input: &StepInput<'_>,
        parts: &[Part],
        limit: usize,
    ) -> Result<BestValid, StageError> {
        let started = Instant::now();
        let left = self.context.deadline().saturating_duration_since(started);
        let left = left.saturating_sub(RESERVE);
        let all = placements(parts, input);
        if self
            .pace
            .expected_here(all)
            .is_some_and(|all| 2 * all < left)
        {
            let best = self.local.all(input, parts, limit)?;
            self.pace.searched_here(all, started.elapsed());
            return Ok(best);
        }
        let mut is_late = || started.elapsed() >= left;
        let (best, searched) = self.local.until(input, parts, limit, &mut is_late)?;
        let (done, left_out) = parts.split_at(searched.min(parts.len()));
        if !done.is_empty() {
            self.pace
                .searched_here(placements(done, input), started.elapsed());
        }
        if !left_out.is_empty() {
            self.context.cut(left_out.len());
        }
        Ok(best)
    }

    fn tally(&self, candidate: usize) -> Option<&Tally> {
        let mut tallies = self.best.tallies.iter();
        tallies.find(|tally| tally.candidate == candidate)
    }
}

impl Evaluator for SharedEvaluator {
    fn rank(
        &mut self,
        input: &StepInput<'_>,
        group: &[usize],
        proposals: &Proposals,
    ) -> Result<(), StageError> {
        self.parts = parts(group, input.candidates, proposals);
        self.given = 0;
        self.asked = self.context.wanted().clamp(1, MAX_LIMIT);
        self.best = self.fetch(input, self.asked)?;
        for tally in &mut self.best.tallies {
            let item: Option<&Item> = input
                .candidates
                .get(tally.candidate)
                .map(|held| &*held.item);
            // Parts with proposals count the placements of all yaws each.
            tally.counts.possible =
                item.map_or(0, |item| possible_count_below_rim(input.grid, item));
        }
        Ok(())
    }

    fn next_best(&mut self, input: &StepInput<'_>) -> Result<Option<Evaluated>, StageError> {
        loop {
            if let Some(next) = self.best.placements.get(self.given) {
                self.given += 1;
                return Ok(Some(*next));
            }
            if self.best.is_complete || self.context.is_cut() || self.asked >= MAX_LIMIT {
                return Ok(None);
            }
            // The order of placements is the same each time, so those given already are skipped.
            self.asked = (self.asked * GROWTH).min(MAX_LIMIT);
            let tallies = std::mem::take(&mut self.best.tallies);
            self.best = self.fetch(input, self.asked)?;
            for (tally, before) in self.best.tallies.iter_mut().zip(tallies) {
                tally.counts.possible = before.counts.possible;
            }
        }
    }

    fn counts(&self, candidate: usize) -> PlacementCounts {
        self.tally(candidate)
            .map(|tally| tally.counts)
            .unwrap_or_default()
    }

    fn refusals(&self, candidate: usize) -> &[(&'static str, u64)] {
        self.tally(candidate).map_or(&[], |tally| &tally.refusals)
    }
}

/// How many placements are to be searched.
fn placements(parts: &[Part], input: &StepInput<'_>) -> u64 {
    let of_part = |part: &Part| match &part.proposals {
        Some(placements) => placements.len() as u64,
        None => input.candidates.get(part.candidate).map_or(0, |held| {
            possible_count_at(input.grid, &held.item, part.yaws)
        }),
    };
    parts.iter().map(of_part).sum()
}

fn write_part(part: &Part) -> v1::SearchPart {
    let number = |number: usize| u32::try_from(number).unwrap_or(u32::MAX);
    v1::SearchPart {
        candidate: number(part.candidate),
        first_yaw: number(part.yaws.first),
        yaw_count: number(part.yaws.end - part.yaws.first),
        proposals: part
            .proposals
            .as_ref()
            .map(|placements| convert::placement::write_all(placements.iter().copied())),
    }
}

fn read_reply(reply: &v1::EvaluateReply) -> Result<BestValid, WireError> {
    let placements = reply.placements.iter().map(convert::placement::read_ranked);
    let tallies = reply.counts.iter().map(convert::placement::read_tally);
    Ok(BestValid {
        placements: placements.collect::<Result<_, _>>()?,
        is_complete: reply.is_complete,
        tallies: tallies.collect::<Result<_, _>>()?,
    })
}
