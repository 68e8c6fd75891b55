//! Proposing with the shipped network: a step's candidates on one container, their features cached.
//!
//! Objects are the built-in household set, or those of the folder in `PPNPACK_BENCH_OBJECTS`. The
//! container is half full, packed by SDFM; another one at each iteration.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    missing_docs,
    reason = "a panic here is a failing run"
)]

#[path = "../tests/support/recorded.rs"]
mod recorded;

use std::hint::black_box;
use std::path::PathBuf;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use ppnpack_catalogue::catalogue::{Catalogue, Settings};
use ppnpack_model::settings::Device;
use ppnpack_model::weights::Model;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::ranking::proposals::{Percent, Proposals, Proposer};
use ppnpack_packing::ranking::step::StepInput;
use ppnpack_ppn::proposer::NetworkProposer;

use recorded::Recorded;

/// The steps of an episode, with the buffer each was planned for.
fn steps(grid: &Grid, buffer: usize) -> Vec<Recorded> {
    let named = std::env::var("PPNPACK_BENCH_OBJECTS");
    let name = named.as_deref().unwrap_or(ppnpack_household::BUILTIN);
    let settings = Settings::default();
    let source = ppnpack_household::source(name);
    let catalogue = Catalogue::load(&source, &settings, grid.resolution(), &|_, _| {}).unwrap();
    // 37 is coprime to the usual catalogue sizes, so this visits all objects in a mixed order.
    let objects = (0..80).map(|arrival| (arrival * 37 + 11) % catalogue.len());
    let arrivals = objects.map(|object| catalogue.get(object).unwrap().item.clone());
    recorded::steps(grid, arrivals, buffer)
}

fn proposing(criterion: &mut Criterion) {
    let grid = Grid::reference();
    let steps = steps(&grid, 5);
    // From a quarter to three quarters of the episode.
    let half_full = &steps[steps.len() / 4..3 * steps.len() / 4];
    let model = std::env::var("PPNPACK_BENCH_MODEL").map_or_else(
        |_| Model::shipped().unwrap(),
        |path| Model::read(&PathBuf::from(path)).unwrap(),
    );
    let share = Percent::new(5.0).unwrap();
    let mut proposer = NetworkProposer::new(&model, &grid, share, Device::Cpu, &[]).unwrap();
    let mut proposals = Proposals::default();
    let mut propose = |index: usize, candidates: usize| {
        let (scene, buffer) = &half_full[index % half_full.len()];
        let candidates = &buffer[..candidates.min(buffer.len())];
        let input = StepInput::new(&grid, scene, candidates);
        proposer.propose(black_box(&input), &mut proposals).unwrap();
    };
    (0..half_full.len()).for_each(|index| propose(index, 5));
    let mut group = criterion.benchmark_group("propose");
    for candidates in [1, 5] {
        let what = format!("network's best 5 %, candidates: {candidates}");
        let id = BenchmarkId::new(what, "1 cm, 4 yaws");
        group.bench_function(id, |bencher| {
            let mut index = 0;
            bencher.iter(|| {
                index += 1;
                propose(index, candidates);
            });
        });
    }
    group.finish();
}

criterion_group!(benches, proposing);
criterion_main!(benches);
