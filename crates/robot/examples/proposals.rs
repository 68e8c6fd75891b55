//! Where pruned proposals pay with an arm: decision time, packed volume and checks per step of each source of
//! proposals, on real objects, with the arm's check and without.
//!
//! `cargo run --release -p ppnpack-robot --example proposals -- CATALOGUE SEQUENCES.npy [COUNT [GRIDS]]`: the first COUNT
//! sequences (5); GRIDS is `coarse`, `fine` or `both`. Items stay where they are placed; no physics.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "an experiment that cannot run should say so at once"
)]

use std::sync::Arc;
use std::time::Instant;

use ndarray::Array2;
use ppnpack_catalogue::cache::CacheDir;
use ppnpack_catalogue::catalogue::{Catalogue, Settings, Source};
use ppnpack_packing::coarse::{CoarseGrid, CoarseToFine, Coarsening};
use ppnpack_packing::episode::{IdealCell, Observer, Step, play};
use ppnpack_packing::grid::{ContainerSize, Grid, Resolution, Yaws};
use ppnpack_packing::item::Item;
use ppnpack_packing::objective::Order;
use ppnpack_packing::plan::{Planner, StepInput};
use ppnpack_packing::proposals::{Percent, ProposeAll, ProposeRandom, Proposer};
use ppnpack_packing::search::{Search, SearchSettings};
use ppnpack_packing::stability::{PhysicalStability, PhysicalStabilitySettings};
use ppnpack_robot::station::{ArmStation, StationSettings};

const BUFFER: usize = 5;

/// Where proposals come from, with the share in percent.
#[derive(Debug, Clone, Copy)]
enum Proposing {
    All,
    Bounded,
    Coarse(f64),
    Random(f64),
}

const SOURCES: [Proposing; 5] = [
    Proposing::All,
    Proposing::Bounded,
    Proposing::Coarse(5.0),
    Proposing::Coarse(0.5),
    Proposing::Random(5.0),
];

/// What the sequences of a line of the table came to.
#[derive(Debug, Default)]
struct Found {
    steps: usize,
    decision_s: f64,
    check_s: f64,
    volume_m3: f64,
    asked: u64,
    refused: u64,
    most_asked: u64,
    cycles_s: Vec<f64>,
}

/// Notes what the steps of a sequence came to.
struct Notes<'a> {
    found: &'a mut Found,
    station: Option<&'a ArmStation>,
}

impl Observer for Notes<'_> {
    fn on_step(&mut self, step: &Step, input: &StepInput<'_>) {
        let Self { found, station } = self;
        let item = &step.candidate.item;
        found.steps += 1;
        found.decision_s += step.timings.total().as_secs_f64();
        found.check_s += step.timings.check.as_secs_f64();
        found.volume_m3 += item.mesh_volume_m3();
        if let Some(station) = station {
            let tally = station.take_tally();
            found.asked += tally.asked;
            found.refused += tally.refused.values().sum::<u64>();
            found.most_asked = found.most_asked.max(tally.asked);
            let cycle = station
                .cycle(input, &step.candidate, &step.choice.resting)
                .unwrap();
            found.cycles_s.push(cycle.cycle_s);
        }
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (folder, sequences) = (&arguments[0], &arguments[1]);
    let count: usize = arguments.get(2).map_or(5, |text| text.parse().unwrap());
    let which = arguments.get(3).map_or("both", String::as_str);
    let sequences: Array2<i64> = ndarray_npy::read_npy(sequences).unwrap();
    let grids = [("coarse", 0.01, 4), ("fine", 0.0025, 16)];
    for (name, cell_m, yaws) in grids {
        if which != "both" && which != name {
            continue;
        }
        let resolution = Resolution::new(cell_m, 0.002, Yaws::half_turn(yaws).unwrap()).unwrap();
        let settings = Settings {
            cache: CacheDir::User,
            ..Settings::default()
        };
        let source = Source::Folder(folder.into());
        let catalogue = Catalogue::load(&source, &settings, &resolution, &|_, _| ()).unwrap();
        let grid = Grid::new(ContainerSize::REFERENCE, resolution).unwrap();
        println!(
            "\ncells of {} mm, {yaws} yaws, {count} sequences",
            cell_m * 1e3
        );
        measure(&catalogue, &grid, &sequences, count);
    }
}

fn measure(catalogue: &Catalogue, grid: &Grid, sequences: &Array2<i64>, count: usize) {
    let station = ArmStation::new(&StationSettings::default()).unwrap();
    let resolution = grid.resolution();
    for object in &catalogue.objects {
        station.hold(&object.item, &object.model);
    }
    let can_be_lifted = |item: &Item| station.lift(item, resolution).is_ok();
    let objects = catalogue.objects.iter();
    let held = objects.filter(|object| can_be_lifted(&object.item)).count();
    println!(
        "{held} of {} objects can be picked",
        catalogue.objects.len()
    );
    println!(
        "| proposals | arm | steps | decision ms | of it checks ms | volume cm3 | asked per step | most | refused | cycle s |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for source in SOURCES {
        for has_arm in [false, true] {
            let started = Instant::now();
            let of_step = has_arm.then_some(&station);
            let mut found = Found::default();
            for row in sequences.rows().into_iter().take(count) {
                let items = row.iter().filter_map(|object| {
                    let item = &catalogue.get(usize::try_from(*object).ok()?)?.item;
                    can_be_lifted(item).then(|| Arc::clone(item))
                });
                let mut planner = planner(grid, source, of_step);
                let mut cell = IdealCell::new(grid);
                let mut notes = Notes {
                    found: &mut found,
                    station: of_step,
                };
                let items = items.collect();
                play(grid, &mut planner, &mut cell, items, BUFFER, &mut notes).unwrap();
                // The last step, which found nothing, is no decision.
                station.take_tally();
            }
            print(source, has_arm, &found, count);
            eprintln!("{:.1} s", started.elapsed().as_secs_f64());
        }
    }
}

fn planner(grid: &Grid, source: Proposing, station: Option<&ArmStation>) -> Planner {
    let settings = SearchSettings::default();
    let search = Search::new(grid, &settings).unwrap();
    let search = match source {
        Proposing::All => search,
        _ => search.bounded(),
    };
    let share = |percent| Percent::new(percent).unwrap();
    let proposer: Box<dyn Proposer> = match source {
        Proposing::All | Proposing::Bounded => Box::new(ProposeAll),
        Proposing::Random(percent) => Box::new(ProposeRandom::new(share(percent), 0)),
        Proposing::Coarse(percent) => {
            let cell_m = 0.01_f64.max(2.0 * grid.resolution().cell_m());
            let grids = CoarseGrid::new(grid, Coarsening::towards(grid, cell_m, 4)).unwrap();
            Box::new(CoarseToFine::searching(grids, &settings, share(percent)).unwrap())
        }
    };
    let stability = PhysicalStability::new(PhysicalStabilitySettings::default());
    let mut checks = vec![Box::new(stability) as _];
    checks.extend(station.map(ArmStation::check));
    Planner::new(proposer, Box::new(search), checks, Order::Balance, 0)
}

fn print(source: Proposing, has_arm: bool, found: &Found, sequences: usize) {
    let steps = found.steps.max(1) as f64;
    let mean_s = found.cycles_s.iter().sum::<f64>() / steps;
    let of_arm = match has_arm {
        true => format!(
            "{:.1} | {} | {:.0} % | {mean_s:.2}",
            found.asked as f64 / steps,
            found.most_asked,
            100.0 * found.refused as f64 / found.asked.max(1) as f64
        ),
        false => "| | |".to_owned(),
    };
    println!(
        "| {source:?} | {} | {:.1} | {:.2} | {:.2} | {:.0} | {of_arm} |",
        if has_arm { "yes" } else { "no" },
        steps / sequences as f64,
        1e3 * found.decision_s / steps,
        1e3 * found.check_s / steps,
        1e6 * found.volume_m3 / sequences as f64
    );
}
