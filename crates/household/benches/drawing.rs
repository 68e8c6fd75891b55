//! Drawing random proposals for a buffer of five household objects at three grids.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    missing_docs,
    reason = "a panic here is a failing run"
)]

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use ppnpack_catalogue::catalogue::{Catalogue, Settings};
use ppnpack_packing::grid::{ContainerSize, Grid, Resolution, Yaws};
use ppnpack_packing::heightmap::{Heightmap, Scene};
use ppnpack_packing::plan::{Candidate, StepInput};
use ppnpack_packing::proposals::{Percent, Proposals, ProposeRandom, ProposeTries, Proposer};

/// Cell, yaws and a name.
const GRIDS: [(f64, usize, &str); 3] = [
    (0.01, 4, "1 cm, 4 yaws"),
    (0.005, 8, "5 mm, 8 yaws"),
    (0.0025, 16, "2.5 mm, 16 yaws"),
];

fn drawing(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("drawing");
    for (cell_m, yaws, name) in GRIDS {
        let resolution = Resolution::new(cell_m, 0.002, Yaws::half_turn(yaws).unwrap()).unwrap();
        let grid = Grid::new(ContainerSize::REFERENCE, resolution).unwrap();
        let source = ppnpack_household::source(ppnpack_household::BUILTIN);
        let settings = Settings::default();
        let catalogue = Catalogue::load(&source, &settings, grid.resolution(), &|_, _| {}).unwrap();
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
