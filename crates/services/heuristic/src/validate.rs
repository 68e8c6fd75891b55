//! `validate`: whether given placements are valid.

use std::time::Instant;

use ppnpack_packing::check::{BoxedCheck, Fits, Verdict};
use ppnpack_packing::placement::{Placement, RestingPlacement};
use ppnpack_packing::resting::RestingHeights;
use ppnpack_packing::step::{Candidate, StepInput};
use ppnpack_service::rpc::Incoming;
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::v1::Check;
use ppnpack_wire::{convert, header, v1};

use crate::worker::{Answer, Refusal, Worker};

/// The most placements of one request.
const MAX_PLACEMENTS: usize = 65_536;

pub(crate) fn validate(
    worker: &mut Worker,
    incoming: &Incoming<v1::ValidateRequest>,
) -> Result<Answer<v1::ValidateReply>, Refusal> {
    let started = Instant::now();
    let request = incoming.message();
    let (grid, scene) = convert::scene::read_required("scene", request.scene.as_ref())?;
    let id = ItemId::from_bytes("item_id", &request.item_id)?;
    let items = worker.items(request.item.as_slice(), &[id], &grid)?;
    let placements = request.placements.clone().unwrap_or_default();
    let placements = convert::placement::read_all("placements", &placements)?;
    if !(1..=MAX_PLACEMENTS).contains(&placements.len()) {
        return Err(Refusal::Invalid(format!(
            "{} placements where 1 to {MAX_PLACEMENTS} are possible",
            placements.len()
        )));
    }
    let candidates = items.into_iter().map(|item| Candidate::new(0, item));
    let candidates: Vec<Candidate> = candidates.collect();
    let Some(candidate) = candidates.first() else {
        return Err(Refusal::Invalid("the item is missing".to_owned()));
    };
    let mut resting = RestingHeights::new(&grid);
    resting.update(scene.heightmap(), std::iter::once(&*candidate.item));
    let height = |placement: &Placement| {
        let view = candidate.item.views().get(placement.yaw)?;
        resting.at(view, placement.x, placement.y)
    };
    let input = StepInput::new(&grid, &scene, &candidates);
    let mut checks = convert::check::read_all(&request.checks)?;
    checks.push(Box::new(Fits));
    checks.sort_by_key(|check| check.cost());
    let mut validities = Vec::with_capacity(placements.len());
    let answer_by = incoming.answer_by();
    for placement in placements {
        if Instant::now() >= answer_by {
            return Err(Refusal::Late);
        }
        let Some(resting_height) = height(&placement) else {
            validities.push(v1::Validity::default());
            continue;
        };
        let resting = RestingPlacement {
            placement,
            resting_height,
        };
        validities.push(v1::Validity {
            resting_height: u32::try_from(resting_height).unwrap_or(0),
            is_inside: true,
            refused_by: refused_by(&mut checks, &input, candidate, &resting)?.into(),
        });
    }
    let reply = v1::ValidateReply {
        validities,
        ..v1::ValidateReply::default()
    };
    let stages = vec![header::stage("validate", started.elapsed())];
    Ok((reply, stages))
}

/// The first check that refuses a placement; unspecified where all accept it.
fn refused_by(
    checks: &mut [BoxedCheck],
    input: &StepInput<'_>,
    candidate: &Candidate,
    resting: &RestingPlacement,
) -> Result<Check, Refusal> {
    for check in checks {
        let verdict = check
            .judge(input, candidate, resting)
            .map_err(|error| Refusal::Failed(error.to_string()))?;
        if let Verdict::Refused(refusal) = verdict {
            return Ok(convert::check::of_cause(refusal.cause));
        }
    }
    Ok(Check::Unspecified)
}
