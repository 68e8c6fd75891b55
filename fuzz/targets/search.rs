//! A request to evaluate, read as the heuristic service reads it and searched: whatever passes the
//! checks of the wire, the search gives placements that lie within the container, or an error.
#![no_main]

use std::sync::Arc;

use libfuzzer_sys::fuzz_target;
use ppnpack_packing::kernel::item::Item;
use ppnpack_packing::ranking::proposals::Proposals;
use ppnpack_packing::ranking::search::Search;
use ppnpack_packing::ranking::step::{Candidate, StepInput};
use ppnpack_packing::planning::valid::ValidSearch;
use ppnpack_wire::{MAX_MESSAGE_BYTES, convert, decode, v1};

/// Larger grids are searched in the same way, but slowly.
const MAX_CELLS: usize = 48 * 48;
const MAX_YAWS: usize = 8;
const MAX_ITEMS: usize = 4;

fn search(data: &[u8]) -> Option<()> {
    let request: v1::EvaluateRequest = decode(data, MAX_MESSAGE_BYTES).ok()?;
    let (grid, scene) = convert::scene::read(request.scene.as_ref()?).ok()?;
    let yaws = grid.resolution().yaws().count();
    if grid.nx() * grid.ny() > MAX_CELLS || yaws > MAX_YAWS || request.items.len() > MAX_ITEMS {
        return None;
    }
    let items = request.items.iter().map(convert::item::read);
    let items: Vec<Item> = items.collect::<Result<_, _>>().ok()?;
    if items.iter().any(|item| item.views().len() != yaws) {
        return None;
    }
    let candidates = Candidate::sequence(items.into_iter().map(Arc::new));
    let mut proposals = Proposals::default();
    for index in 0..candidates.len() {
        let part = request.parts.get(index);
        match part.and_then(|part| part.proposals.as_ref()) {
            Some(given) => proposals.push(convert::placement::read_all("parts", given).ok()?),
            None => proposals.push_all(),
        }
    }
    let settings =
        convert::objective::read_required("objective", request.objective.as_ref()).ok()?;
    let checks = convert::check::read_all(&request.checks).ok()?;
    let search = Search::new(&grid, &settings).ok()?.bounded();
    let mut search = ValidSearch::new(Box::new(search), checks);
    let input = StepInput {
        step: request.step,
        ..StepInput::new(&grid, &scene, &candidates)
    };
    let group: Vec<usize> = (0..candidates.len()).collect();
    search.rank(&input, &group, &proposals).ok()?;
    for _ in 0..16 {
        let Some(found) = search.next_valid(&input).ok()? else {
            break;
        };
        let at = found.placement.resting.placement;
        let view = &candidates[found.placement.candidate].item.views()[at.yaw];
        assert!(at.x + view.nx() <= grid.nx() && at.y + view.ny() <= grid.ny());
    }
    Some(())
}

fuzz_target!(|data: &[u8]| {
    search(data);
});
