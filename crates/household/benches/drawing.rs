//! Drawing random proposals for a buffer of five household objects at three grids.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    missing_docs,
    reason = "a panic here is a failing run"
)]

mod grids;

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use ppnpack_packing::heightmap::{Heightmap, Scene};
use ppnpack_packing::plan::{Candidate, StepInput};
use ppnpack_packing::proposals::{Percent, Proposals, ProposeRandom, ProposeTries, Proposer};

use grids::GRIDS;

fn drawing(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("drawing");
    for named in GRIDS {
        let (_, _, name) = named;
        let grid = grids::grid(named);
        let catalogue = grids::catalogue(&grid);
        let candidates = Candidate::sequence(catalogue.items().into_iter().take(5));
        let scene = Scene::from_heightmap(Heightmap::empty(&grid));
        let share = |percent| ProposeRandom::new(Percent::new(percent).unwrap(), 0);
        let proposers: [(&str, Box<dyn Proposer>); 4] = [
            ("a random 0.25 %", Box::new(share(0.25))),
            ("a random 5 %", Box::new(share(5.0))),
            ("a random 60 %", Box::new(share(60.0))),
            (
                "3 yaws with 3 positions",
                Box::new(ProposeTries::new(3, 3, 0)),
            ),
        ];
        for (label, mut proposer) in proposers {
            let (mut proposals, mut step) = (Proposals::default(), 0_u64);
            group.bench_function(BenchmarkId::new(label, name), |bencher| {
                bencher.iter(|| {
                    step += 1;
                    let input = StepInput {
                        step,
                        ..StepInput::new(&grid, &scene, &candidates)
                    };
                    proposer.propose(&input, &mut proposals).unwrap();
                    black_box(proposals.of(0));
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, drawing);
criterion_main!(benches);
