//! `evaluate`: the best valid placements of some items.

use std::time::Instant;

use ppnpack_packing::grid::Grid;
use ppnpack_packing::proposals::{Proposals, YawRange};
use ppnpack_packing::step::{Candidate, Evaluated, StepInput};
use ppnpack_packing::valid::ValidSearch;
use ppnpack_service::rpc::Incoming;
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::{convert, header, v1};

use crate::worker::{Answer, Given, Ranking, Refusal, Worker};

/// The most placements that one request may ask for.
const MAX_LIMIT: u32 = 65_536;

/// The most candidates of one request.
const MAX_CANDIDATES: usize = 1_000;

pub(crate) fn evaluate(
    worker: &mut Worker,
    incoming: &Incoming<v1::EvaluateRequest>,
) -> Result<Answer<v1::EvaluateReply>, Refusal> {
    let started = Instant::now();
    let request = incoming.message();
    let limit = read_limit(request.limit)?;
    let (grid, scene) = convert::scene::read_required("scene", request.scene.as_ref())?;
    let ids = read_ids(&request.candidates)?;
    let items = worker.items(&request.items, &ids, &grid)?;
    let candidates = request.candidates.iter().zip(items);
    let candidates = candidates.map(|(candidate, item)| {
        let arrival = usize::try_from(candidate.arrival).unwrap_or(usize::MAX);
        Candidate {
            pose: usize::try_from(candidate.pose).unwrap_or(usize::MAX),
            ..Candidate::new(arrival, item)
        }
    });
    let candidates: Vec<Candidate> = candidates.collect();
    check_work(&request.parts, &grid, worker.most_placements())?;
    let (group, proposals) = read_parts(&request.parts, &candidates)?;
    let settings = convert::objective::read_required("objective", request.objective.as_ref())?;
    let after = request.after.as_ref().map(convert::placement::read_ranked);
    let asked = Asked {
        group: &group,
        proposals: &proposals,
        limit,
        content: read_content(request)?,
        after: after.transpose()?,
    };
    let ranking = worker.ranking(incoming.cell(), &grid, &settings, &request.checks)?;
    let input = StepInput {
        step: request.step,
        deadline: Some(incoming.answer_by()),
        ..StepInput::new(&grid, &scene, &candidates)
    };
    let read = Instant::now();
    let (placements, is_complete) = asked.of(ranking, &input)?;
    let placements = placements.iter().map(convert::placement::write_ranked);
    let tallies = group.iter().map(|held| ranking.search.tally(*held));
    let counts = tallies.map(|tally| convert::placement::write_tally(&tally));
    let reply = v1::EvaluateReply {
        placements: placements.collect(),
        is_complete,
        counts: counts.collect(),
        ..v1::EvaluateReply::default()
    };
    let stages = vec![
        header::stage("read", read - started),
        header::stage("evaluate", read.elapsed()),
    ];
    Ok((reply, stages))
}

/// What a request wants of a ranking.
struct Asked<'a> {
    group: &'a [usize],
    proposals: &'a Proposals,
    limit: usize,
    /// What the ranking is of; `None` where no more of it will be wanted.
    content: Option<v1::EvaluateRequest>,
    after: Option<Evaluated>,
}

impl Asked<'_> {
    /// The next valid placements of the ranking, and whether there are no more after them.
    fn of(
        self,
        ranking: &mut Ranking,
        input: &StepInput<'_>,
    ) -> Result<(Vec<Evaluated>, bool), Refusal> {
        let Ranking { search, given } = ranking;
        let is_there = |given: &Given| {
            Some(&given.content) == self.content.as_ref() && Some(given.last) == self.after
        };
        let candidates = match given.take().filter(is_there) {
            Some(given) => given.candidates,
            None => {
                search.rank(input, self.group, self.proposals)?;
                self.leave_out(search, input)?;
                input.candidates.to_vec()
            }
        };
        let input = StepInput {
            candidates: &candidates,
            ..*input
        };
        let mut placements = Vec::new();
        let mut is_complete = false;
        while placements.len() < self.limit && !is_complete {
            match search.next_valid(&input)? {
                Some(valid) => placements.push(valid.placement),
                None => is_complete = true,
            }
        }
        if search.is_cut() {
            // The ranking is not gone on with, and what was found of it may not be the best.
            return Err(Refusal::Late);
        }
        let last = placements.last().copied().or(self.after);
        *given = self.content.zip(last).map(|(content, last)| Given {
            content,
            candidates,
            last,
        });
        Ok((placements, is_complete))
    }

    /// Goes through a new ranking up to what was given before.
    fn leave_out(&self, search: &mut ValidSearch, input: &StepInput<'_>) -> Result<(), Refusal> {
        let Some(after) = &self.after else {
            return Ok(());
        };
        while let Some(valid) = search.next_valid(input)? {
            if valid.placement == *after {
                return Ok(());
            }
        }
        if search.is_cut() {
            return Err(Refusal::Late);
        }
        let unknown = "after: this is no valid placement of the ranking";
        Err(Refusal::Invalid(unknown.to_owned()))
    }
}

/// What a ranking is of, where it has an id. Grid, objective and checks are those of the search that has it.
fn read_content(request: &v1::EvaluateRequest) -> Result<Option<v1::EvaluateRequest>, Refusal> {
    if request.ranking_id.is_empty() {
        return Ok(None);
    }
    header::id("ranking_id", &request.ranking_id)?;
    Ok(Some(v1::EvaluateRequest {
        scene: request.scene.clone(),
        candidates: request.candidates.clone(),
        parts: request.parts.clone(),
        step: request.step,
        ranking_id: request.ranking_id.clone(),
        ..v1::EvaluateRequest::default()
    }))
}

fn read_limit(limit: u32) -> Result<usize, Refusal> {
    if (1..=MAX_LIMIT).contains(&limit) {
        Ok(limit as usize)
    } else {
        Err(Refusal::Invalid(format!(
            "limit is {limit} where 1 to {MAX_LIMIT} is possible"
        )))
    }
}

fn read_ids(candidates: &[v1::CandidateItem]) -> Result<Vec<ItemId>, Refusal> {
    if !(1..=MAX_CANDIDATES).contains(&candidates.len()) {
        return Err(Refusal::Invalid(format!(
            "{} candidates where 1 to {MAX_CANDIDATES} are possible",
            candidates.len()
        )));
    }
    let id = |held: &v1::CandidateItem| ItemId::from_bytes("candidates.item_id", &held.item_id);
    Ok(candidates.iter().map(id).collect::<Result<_, _>>()?)
}

/// Refuses parts that are more work than may be asked for at once.
fn check_work(parts: &[v1::SearchPart], grid: &Grid, most: usize) -> Result<(), Refusal> {
    let yaws = parts.iter().map(|part| match &part.proposals {
        Some(_) => 1,
        None => u64::from(part.yaw_count),
    });
    let cells = (grid.nx() * grid.ny()) as u64;
    let work = cells.saturating_mul(yaws.sum());
    if work <= most as u64 {
        return Ok(());
    }
    Err(Refusal::Invalid(format!(
        "parts: {cells} cells times the yaws of all candidates are {work} placements where {most} are possible: ask for fewer          candidates or yaws at once, or set most_placements"
    )))
}

/// The candidates that are searched, and what is proposed for each.
fn read_parts(
    parts: &[v1::SearchPart],
    candidates: &[Candidate],
) -> Result<(Vec<usize>, Proposals), Refusal> {
    let mut of_candidate: Vec<Option<&v1::SearchPart>> = vec![None; candidates.len()];
    let mut group = Vec::with_capacity(parts.len());
    for part in parts {
        let index = part.candidate as usize;
        match of_candidate.get_mut(index) {
            Some(entry @ None) => *entry = Some(part),
            Some(Some(_)) => {
                return Err(Refusal::Invalid(format!("parts: two of candidate {index}")));
            }
            None => {
                return Err(Refusal::Invalid(format!(
                    "parts: there is no candidate {index}"
                )));
            }
        }
        group.push(index);
    }
    let mut proposals = Proposals::default();
    for (part, candidate) in of_candidate.into_iter().zip(candidates) {
        let Some(part) = part else {
            proposals.push([]);
            continue;
        };
        let yaws = read_yaws(part, candidate.item.views().len())?;
        match &part.proposals {
            None => proposals.push_all_at(yaws),
            Some(placements) => {
                let placements = convert::placement::read_all("parts.proposals", placements)?;
                if placements.iter().any(|at| !yaws.contains(at.yaw)) {
                    let other = "parts.proposals: a placement at a yaw that is not searched";
                    return Err(Refusal::Invalid(other.to_owned()));
                }
                proposals.push(placements);
            }
        }
    }
    Ok((group, proposals))
}

fn read_yaws(part: &v1::SearchPart, yaws: usize) -> Result<YawRange, Refusal> {
    let first = part.first_yaw as usize;
    let end = first.saturating_add(part.yaw_count as usize);
    if first < end && end <= yaws {
        Ok(YawRange { first, end })
    } else {
        Err(Refusal::Invalid(format!(
            "parts: the yaws {first} to below {end} of an item with {yaws}"
        )))
    }
}
