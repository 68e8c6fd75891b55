//! Evaluation by the heuristic services that are alive, all together; what they do not answer is searched here, and,
//! where that is wanted, what is found sooner here.

use std::time::{Duration, Instant};

use ppnpack_packing::evaluator::Evaluator;
use ppnpack_packing::item::Item;
use ppnpack_packing::method::Stability;
use ppnpack_packing::proposals::{
    Proposals, YawRange, possible_count_at, possible_count_below_rim,
};
use ppnpack_packing::refusal::Refusals;
use ppnpack_packing::step::{Evaluated, PlacementCounts, Shortfall, StageError, StepInput};
use ppnpack_packing::valid::Tally;
use ppnpack_service::rpc::{CallError, PendingCall};
use ppnpack_wire::error::WireError;
use ppnpack_wire::keys::Instance;
use ppnpack_wire::{convert, v1};

use super::items::ItemMessages;
use super::local::{LocalSearches, MAX_SEARCHES};
use super::pace::Pace;
use super::peers::Peers;
use super::source::{Searcher, Source, take_best};
use super::split::{Part, parts, split};

/// The most placements that a service is asked for at once.
const MAX_PAGE: usize = 4_096;

/// How many times more placements are asked for when those that came were not enough.
const GROWTH: usize = 8;

/// What is left of the time limit for the rest of the step when a search stops.
const RESERVE: Duration = Duration::from_millis(3);

/// Replicas that share a step at most.
const MAX_REPLICAS: usize = 16;

/// Evaluates with others.
pub(crate) struct SharedEvaluator {
    peers: Peers,
    local: LocalSearches,
    pace: Pace,
    /// Whether the sooner way is taken; the services' otherwise.
    is_sooner_taken: bool,
    items: ItemMessages,
    /// Names the ranking to the services.
    ranking_id: String,
    /// How many placements a service is asked for.
    page: usize,
    sources: Vec<Source>,
    /// By candidate of the input: placements within the container, over all yaws.
    possible: Vec<u64>,
    shortfall: Shortfall,
}

/// More of a source's placements, as its service is asked for them.
struct Asked {
    /// Of the source.
    number: usize,
    instance: Instance,
    share: Vec<Part>,
    after: Option<Evaluated>,
}

type Call = Result<PendingCall<v1::EvaluateRequest>, CallError>;

/// What a service answered.
struct Found {
    placements: Vec<Evaluated>,
    is_complete: bool,
    tallies: Vec<Tally>,
}

impl Found {
    /// Without what was given before: a service that does not know `after` begins anew with each page.
    fn going_on_after(mut self, after: Option<&Evaluated>) -> Result<Self, String> {
        if let Some(after) = after {
            self.placements.retain(|at| at.rank_cmp(after).is_gt());
            if self.placements.is_empty() && !self.is_complete {
                return Err("it does not go on where it stopped".to_owned());
            }
        }
        Ok(self)
    }
}

impl SharedEvaluator {
    /// Searches in this process what is found sooner that way, where `is_sooner_taken`.
    pub(crate) fn new(peers: Peers, local: LocalSearches, is_sooner_taken: bool) -> Self {
        Self {
            peers,
            local,
            pace: Pace::default(),
            is_sooner_taken,
            items: ItemMessages::default(),
            ranking_id: String::new(),
            page: 1,
            sources: Vec::new(),
            possible: Vec::new(),
            shortfall: Shortfall::default(),
        }
    }

    /// Has everything searched: by services, or here.
    fn begin(&mut self, input: &StepInput<'_>, parts: &[Part]) -> Result<(), StageError> {
        let mut alive = self.peers.alive.instances();
        alive.truncate(MAX_REPLICAS);
        if alive.is_empty() {
            let why = "no heuristic service is alive: searched in the planner";
            self.shortfall.degrade(why.to_owned());
            return self.search_here(input, parts, None);
        }
        let (all, replicas) = (placements(parts, input), alive.len());
        if self.is_sooner_taken && self.pace.is_sooner_here(all, replicas) {
            return self.search_here(input, parts, None);
        }
        let shares = alive
            .into_iter()
            .zip(split(parts, input.candidates, replicas))
            .filter(|(_, share)| !share.is_empty());
        let source =
            |(instance, share)| Source::new(share, Searcher::Service(instance, Vec::new()));
        self.sources = shares.map(source).collect();
        let started = Instant::now();
        self.fetch(input)?;
        self.pace.asked(all, replicas, started.elapsed());
        Ok(())
    }

    /// Has every source that is dry go on.
    fn fetch(&mut self, input: &StepInput<'_>) -> Result<(), StageError> {
        let deadline = self.peers.deadline(input);
        let mut begun: Vec<(Asked, Call)> = Vec::new();
        for number in 0..self.sources.len() {
            let source = self.sources.get(number).filter(|source| source.is_dry());
            let Some(source) = source else {
                continue;
            };
            let Searcher::Service(instance, _) = &source.searcher else {
                self.go_on_here(number, input)?;
                continue;
            };
            let asked = Asked {
                number,
                instance: instance.clone(),
                share: source.share.clone(),
                after: source.last().copied(),
            };
            let request = self.request(&asked, input);
            let Peers { cell, client, .. } = &self.peers;
            let call = client.begin_instance(cell, &asked.instance, request, deadline);
            begun.push((asked, call));
        }
        if begun.is_empty() {
            return Ok(());
        }
        for (asked, call) in begun {
            let answer = self.finish(&asked, call, input, deadline);
            let Some(source) = self.sources.get_mut(asked.number) else {
                continue;
            };
            match answer {
                Ok(found) => {
                    source.extend(found.placements, found.is_complete);
                    source.searcher = Searcher::Service(asked.instance, found.tallies);
                }
                Err(reason) => {
                    self.shortfall.degrade(format!(
                        "heuristic service {} failed ({reason}): its part was searched in the planner",
                        asked.instance
                    ));
                    *source = Source::gone();
                    self.search_here(input, &asked.share, asked.after)?;
                }
            }
        }
        self.page = (self.page * GROWTH).min(MAX_PAGE);
        Ok(())
    }

    fn request(&mut self, asked: &Asked, input: &StepInput<'_>) -> v1::EvaluateRequest {
        let items = || input.candidates.iter().map(|held| &*held.item);
        let ids = self.items.ids(items());
        let candidates = ids.iter().zip(input.candidates);
        let method = self.local.method();
        v1::EvaluateRequest {
            scene: Some(convert::scene::write(input.grid, input.scene)),
            candidates: candidates
                .map(|(id, held)| v1::CandidateItem {
                    item_id: id.to_bytes(),
                    arrival: held.arrival as u64,
                    pose: u32::try_from(held.pose).unwrap_or(u32::MAX),
                })
                .collect(),
            items: self.items.unsent(&asked.instance, items()),
            parts: asked.share.iter().map(write_part).collect(),
            objective: Some(convert::objective::write(&method.search_settings())),
            checks: checks(method.stability),
            limit: u32::try_from(self.page).unwrap_or(u32::MAX),
            step: input.step,
            ranking_id: self.ranking_id.clone(),
            after: asked.after.as_ref().map(convert::placement::write_ranked),
            ..v1::EvaluateRequest::default()
        }
    }

    fn finish(
        &mut self,
        asked: &Asked,
        call: Call,
        input: &StepInput<'_>,
        deadline: Instant,
    ) -> Result<Found, String> {
        let instance = &asked.instance;
        let answer = match call.and_then(PendingCall::wait) {
            Err(error) if error.status() == Some(v1::Status::MissingItems) => {
                self.items.forget(instance);
                let request = self.request(asked, input);
                let Peers { cell, client, .. } = &self.peers;
                client.call_instance(cell, instance, request, deadline)
            }
            answer => answer,
        };
        let reply = answer.map_err(|error| error.to_string())?;
        let items = input.candidates.iter().map(|held| &*held.item);
        let ids = self.items.ids(items);
        self.items.has(instance, &ids);
        let found = read_reply(&reply).map_err(|error| error.to_string())?;
        found.going_on_after(asked.after.as_ref())
    }

    /// Searches in this process: whole where that is expected to take less than half of the time left, by parts
    /// otherwise, so that there is an answer when the time is over. What comes up to `after` is left out.
    fn search_here(
        &mut self,
        input: &StepInput<'_>,
        parts: &[Part],
        after: Option<Evaluated>,
    ) -> Result<(), StageError> {
        let started = Instant::now();
        let left = input
            .deadline
            .map(|deadline| deadline.saturating_duration_since(started));
        let left = left.map(|left| left.saturating_sub(RESERVE));
        let all = placements(parts, input);
        let expected = self.pace.expected_here(all);
        let is_quick = left.is_none_or(|left| expected.is_some_and(|all| 2 * all < left));
        let free = MAX_SEARCHES.saturating_sub(self.searching_here()).max(1);
        let together = if is_quick { 1 } else { parts.len().min(free) };
        let size = parts.len().div_ceil(together.max(1)).max(1);
        let is_late = || left.is_some_and(|left| started.elapsed() >= left);
        let (mut searched, mut left_out) = (0, 0);
        for share in parts.chunks(size) {
            if !is_quick && is_late() {
                left_out += share.len();
                continue;
            }
            self.begin_here(input, share.to_vec(), after.as_ref())?;
            searched += placements(share, input);
        }
        if searched > 0 {
            self.pace.searched_here(searched, started.elapsed());
        }
        if left_out > 0 {
            self.shortfall
                .cut(format!("the time limit left {left_out} items unsearched"));
        }
        Ok(())
    }

    /// Adds a search of this process, and has its best placement found.
    fn begin_here(
        &mut self,
        input: &StepInput<'_>,
        share: Vec<Part>,
        after: Option<&Evaluated>,
    ) -> Result<(), StageError> {
        let search = self.searching_here();
        self.local.rank(search, &with_reserve(input), &share)?;
        let number = self.sources.len();
        self.sources
            .push(Source::new(share, Searcher::Here(search)));
        self.go_on_here(number, input)?;
        let Some(after) = after else {
            return Ok(());
        };
        while let Some(next) = self.sources.get(number).and_then(Source::peek)
            && next.rank_cmp(after).is_le()
        {
            self.sources.get_mut(number).and_then(Source::take);
            self.go_on_here(number, input)?;
        }
        Ok(())
    }

    /// How many searches go on in this process.
    fn searching_here(&self) -> usize {
        let is_here = |source: &&Source| matches!(source.searcher, Searcher::Here(_));
        self.sources.iter().filter(is_here).count()
    }

    fn go_on_here(&mut self, number: usize, input: &StepInput<'_>) -> Result<(), StageError> {
        let Some(source) = self.sources.get_mut(number) else {
            return Ok(());
        };
        let Searcher::Here(search) = source.searcher else {
            return Ok(());
        };
        let next = self.local.next(search, &with_reserve(input))?;
        let is_last = next.is_none();
        source.extend(next, is_last);
        if is_last && self.local.is_cut(search) {
            let why = "the time limit left placements unchecked";
            self.shortfall.cut(why.to_owned());
        }
        Ok(())
    }
}

impl Evaluator for SharedEvaluator {
    fn rank(
        &mut self,
        input: &StepInput<'_>,
        group: &[usize],
        proposals: &Proposals,
    ) -> Result<(), StageError> {
        self.sources.clear();
        self.shortfall.clear();
        self.ranking_id = format!("{:032x}", rand::random::<u128>());
        self.page = input.wanted().min(MAX_PAGE);
        let items = input.candidates.iter().map(|held| &*held.item);
        // Parts with proposals count the placements of all yaws each.
        let possible =
            |item: &Item| possible_count_below_rim(input.grid, item, YawRange::all(item));
        self.possible = items.map(possible).collect();
        self.begin(input, &parts(group, input.candidates, proposals))
    }

    fn next_best(&mut self, input: &StepInput<'_>) -> Result<Option<Evaluated>, StageError> {
        while !self.shortfall.is_cut && self.sources.iter().any(Source::is_dry) {
            self.fetch(input)?;
        }
        Ok(take_best(&mut self.sources))
    }

    fn counts(&self, candidate: usize) -> PlacementCounts {
        let mut counts = PlacementCounts::default();
        for tally in self.tallies(candidate) {
            counts.proposed += tally.counts.proposed;
            counts.fitting += tally.counts.fitting;
        }
        let is_searched = |source: &Source| {
            let mut share = source.share.iter();
            share.any(|part| part.candidate == candidate)
        };
        if self.sources.iter().any(is_searched) {
            counts.possible = self.possible.get(candidate).copied().unwrap_or_default();
        }
        counts
    }

    fn add_refusals(&self, candidate: usize, refusals: &mut Refusals) {
        for tally in self.tallies(candidate) {
            refusals.add(&tally.refusals);
        }
    }

    fn shortfall(&self) -> Option<&Shortfall> {
        Some(&self.shortfall)
    }
}

impl SharedEvaluator {
    /// What each source says of a candidate.
    fn tallies(&self, candidate: usize) -> impl Iterator<Item = Tally> {
        self.sources.iter().filter_map(move |source| {
            let mut share = source.share.iter();
            share.find(|part| part.candidate == candidate)?;
            match &source.searcher {
                Searcher::Service(_, tallies) => {
                    let mut tallies = tallies.iter();
                    tallies.find(|tally| tally.candidate == candidate).cloned()
                }
                Searcher::Here(search) => self.local.tally(*search, candidate),
                Searcher::Gone => None,
            }
        })
    }
}

/// The step as it is searched here: it stops early enough for the rest of the step.
fn with_reserve<'a>(input: &StepInput<'a>) -> StepInput<'a> {
    let stops = |deadline: Instant| deadline.checked_sub(RESERVE).unwrap_or(deadline);
    StepInput {
        deadline: input.deadline.map(stops),
        ..*input
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

/// The checks of a stability test, as requests name them.
fn checks(stability: Stability) -> Vec<i32> {
    match stability {
        Stability::Physical => vec![v1::Check::PhysicalStability.into()],
        Stability::Published => vec![v1::Check::PublishedStability.into()],
        Stability::None => Vec::new(),
    }
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

fn read_reply(reply: &v1::EvaluateReply) -> Result<Found, WireError> {
    let placements = reply.placements.iter().map(convert::placement::read_ranked);
    let tallies = reply.counts.iter().map(convert::placement::read_tally);
    Ok(Found {
        placements: placements.collect::<Result<_, _>>()?,
        // An empty page ends a ranking whatever else is said of it.
        is_complete: reply.is_complete || reply.placements.is_empty(),
        tallies: tallies.collect::<Result<_, _>>()?,
    })
}

#[cfg(test)]
mod tests;
