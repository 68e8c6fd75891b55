//! `evaluate`: the best valid placements of some items.

use std::time::Instant;

use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::ranking::proposals::Proposals;
use ppnpack_packing::ranking::step::{Candidate, StepInput};
use ppnpack_service::one_worker::{self, Refusal};
use ppnpack_service::rpc::{Done, Incoming};
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::{convert, header, v1};

use crate::worker::{Worker, search_failed};

/// Maximum number of placements that one request may ask for.
const MAX_LIMIT: u32 = 65_536;

const MAX_CANDIDATES: usize = 1_000;

impl one_worker::Worker for Worker {
    type Request = v1::EvaluateRequest;

    fn work(
        &mut self,
        incoming: &Incoming<v1::EvaluateRequest>,
    ) -> Result<(v1::EvaluateReply, Done), Refusal> {
        let started = Instant::now();
        let request = incoming.message();
        let limit = read_limit(request.limit)?;
        let (grid, scene) = convert::scene::read_required("scene", request.scene.as_ref())?;
        let ids = read_ids(&request.candidates)?;
        let items = self.items(&request.items, &ids, &grid)?;
        let candidates = request.candidates.iter().zip(items);
        let candidates = candidates.map(|(candidate, item)| {
            let arrival = usize::try_from(candidate.arrival).unwrap_or(usize::MAX);
            Candidate {
                pose: usize::try_from(candidate.pose).unwrap_or(usize::MAX),
                ..Candidate::new(arrival, item)
            }
        });
        let candidates: Vec<Candidate> = candidates.collect();
        check_work(&request.parts, &grid, self.most_placements())?;
        let (group, proposals) = read_parts(&request.parts, &candidates)?;
        let settings = convert::objective::read_required("objective", request.objective.as_ref())?;
        let search = self.search(incoming.cell(), &grid, &settings, &request.checks)?;
        let input = StepInput {
            step: request.step,
            deadline: Some(incoming.answer_by()),
            ..StepInput::new(&grid, &scene, &candidates)
        };
        let read = Instant::now();
        search
            .rank(&input, &group, &proposals)
            .map_err(search_failed)?;
        let mut placements = Vec::new();
        let mut is_complete = false;
        while placements.len() < limit && !is_complete {
            match search.next_valid(&input).map_err(search_failed)? {
                Some(valid) => placements.push(convert::placement::write_ranked(&valid.placement)),
                None => is_complete = true,
            }
        }
        if search.is_cut() {
            // What was found may not be the best.
            return Err(Refusal::Late);
        }
        let tallies = group.iter().map(|held| search.tally(*held));
        let counts = tallies.map(|tally| convert::placement::write_tally(&tally));
        let reply = v1::EvaluateReply {
            placements,
            is_complete,
            counts: counts.collect(),
            ..v1::EvaluateReply::default()
        };
        let stages = vec![
            header::stage("read", read - started),
            header::stage("evaluate", read.elapsed()),
        ];
        let model = None;
        Ok((reply, Done { stages, model }))
    }
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
    let all_yaws = grid.resolution().yaws().count() as u64;
    let yaws = parts.iter().map(|part| match &part.proposals {
        Some(_) => 1,
        None => all_yaws,
    });
    let cells = (grid.nx() * grid.ny()) as u64;
    let work = cells.saturating_mul(yaws.sum());
    if work <= most as u64 {
        return Ok(());
    }
    Err(Refusal::Invalid(format!(
        "parts: {cells} cells times the yaws of all candidates are {work} placements where {most} are possible: ask for fewer candidates at once, or set most_placements"
    )))
}

/// Reads the candidates that are searched, and what is proposed for each.
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
        match &part.proposals {
            None => proposals.push_all(),
            Some(placements) => {
                let placements = convert::placement::read_all("parts.proposals", placements)?;
                let yaws = candidate.item.views().len();
                if placements.iter().any(|at| at.yaw >= yaws) {
                    let other = "parts.proposals: a placement at a yaw that the item has not";
                    return Err(Refusal::Invalid(other.to_owned()));
                }
                proposals.push(placements);
            }
        }
    }
    Ok((group, proposals))
}
