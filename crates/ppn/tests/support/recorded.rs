//! Packings by the exhaustive search with SDFM, recorded step by step.

use std::sync::Arc;

use ppnpack_packing::checks::check::BoxedCheck;
use ppnpack_packing::checks::stability::PublishedStability;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::item::Item;
use ppnpack_packing::kernel::objective::{Heuristic, Order};
use ppnpack_packing::planning::plan::Planner;
use ppnpack_packing::ranking::proposals::{ProposeAll, Proposer};
use ppnpack_packing::ranking::search::{Search, SearchSettings};
use ppnpack_packing::ranking::step::{Candidate, StepInput};
use ppnpack_packing::scene::Scene;
use ppnpack_packing::streams::episode::{IdealCell, Observer, Play, Step, play};

/// A step's container, with the buffer that it was planned for.
pub(crate) type Recorded = (Scene, Vec<Candidate>);

pub(crate) fn planner(grid: &Grid, proposer: Box<dyn Proposer>) -> Planner {
    let settings = SearchSettings {
        heuristic: Heuristic::Sdfm,
        order: Order::Balance,
        ..SearchSettings::default()
    };
    let search = Box::new(Search::new(grid, &settings).unwrap());
    let checks: Vec<BoxedCheck> = vec![Box::new(PublishedStability::default())];
    Planner::new(proposer, search, checks, Order::Balance, 0)
}

#[derive(Default)]
struct Recorder(Vec<Recorded>);

impl Observer for Recorder {
    fn on_step(&mut self, _step: &Step, input: &StepInput<'_>) {
        let candidates = input.candidates.to_vec();
        self.0.push((input.scene.clone(), candidates));
    }
}

/// Packs items as they arrive; gives the steps.
pub(crate) fn steps(
    grid: &Grid,
    arrivals: impl Iterator<Item = Arc<Item>>,
    buffer: usize,
) -> Vec<Recorded> {
    let (arrivals, how) = (Candidate::sequence(arrivals), Play::with_buffer(buffer));
    let mut exhaustive = planner(grid, Box::new(ProposeAll));
    let (mut cell, mut recorder) = (IdealCell::new(grid), Recorder::default());
    play(
        grid,
        &mut exhaustive,
        &mut cell,
        arrivals,
        how,
        &mut recorder,
    )
    .unwrap();
    recorder.0
}
