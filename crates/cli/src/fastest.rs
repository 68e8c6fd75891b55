//! Which source of proposals decides fastest, measured before the packing.

use std::sync::Arc;
use std::time::{Duration, Instant};

use ppnpack_packing::episode::{IdealCell, Observer, Play, Step, play};
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::Scene;
use ppnpack_packing::item::Item;
use ppnpack_packing::plan::{Candidate, Planner};
use ppnpack_packing::step::StepInput;
use serde::Serialize;

use crate::failure::{Failure, OrRun, Outcome};
use crate::options::{Method, Network, ProposalSource};

/// Items of the sample packing.
const SAMPLE_ITEMS: usize = 40;

/// Steps of it that are measured, evenly spread.
const SAMPLE_STEPS: usize = 12;

/// What a source of proposals was measured to cost.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Cost {
    pub(crate) proposals: ProposalSource,
    /// The mean decision time, in seconds; none where the source cannot be used here.
    pub(crate) decision_s: Option<f64>,
}

/// Measures what each source costs on steps of a sample packing of `items`, the fastest first.
///
/// The sample is packed as planned, without physics. Each source plans the same steps twice, and the second time
/// counts, when its memory is allocated and its item features are known.
pub(crate) fn measure(
    method: &Method,
    sources: &[ProposalSource],
    grid: &Grid,
    items: &[Arc<Item>],
    threads: u32,
    network: Option<Network<'_>>,
) -> Outcome<Vec<Cost>> {
    let steps = sample(method, grid, items, threads)?;
    let mut costs = Vec::with_capacity(sources.len());
    for source in sources {
        let of_source = Method {
            proposals: source.clone(),
            ..method.clone()
        };
        let decision_s = match of_source.planner(grid, threads, network) {
            Ok(mut planner) => {
                replay(&mut planner, grid, &steps)?;
                Some(replay(&mut planner, grid, &steps)?.as_secs_f64() / steps.len().max(1) as f64)
            }
            // Nothing here can run the network: the others are compared.
            Err(Failure::Run(error)) => {
                let reason = format!("{error:#}");
                tracing::warn!(proposals = %source, reason, "cannot be used here");
                None
            }
            Err(error) => return Err(error),
        };
        tracing::info!(proposals = %source, decision_s, "measured");
        costs.push(Cost {
            proposals: source.clone(),
            decision_s,
        });
    }
    let seconds = |cost: &Cost| cost.decision_s.unwrap_or(f64::INFINITY);
    costs.sort_by(|a, b| seconds(a).total_cmp(&seconds(b)));
    Ok(costs)
}

fn sample(
    method: &Method,
    grid: &Grid,
    items: &[Arc<Item>],
    threads: u32,
) -> Outcome<Vec<Sampled>> {
    let exhaustive = Method {
        proposals: ProposalSource::Bounded,
        ..method.clone()
    };
    let mut planner = exhaustive.planner(grid, threads, None)?;
    let items = Candidate::sequence(items.iter().take(SAMPLE_ITEMS).cloned());
    let mut recorder = Recorder::default();
    let mut cell = IdealCell::new(grid);
    play(
        grid,
        &mut planner,
        &mut cell,
        items,
        Play::with_buffer(method.buffer),
        &mut recorder,
    )
    .or_run()?;
    let every = recorder.0.len().div_ceil(SAMPLE_STEPS).max(1);
    Ok(recorder.0.into_iter().step_by(every).collect())
}

fn replay(planner: &mut Planner, grid: &Grid, steps: &[Sampled]) -> Outcome<Duration> {
    let started = Instant::now();
    for (step, Sampled { scene, candidates }) in steps.iter().enumerate() {
        let input = StepInput {
            step: step as u64,
            ..StepInput::new(grid, scene, candidates)
        };
        planner.plan(&input).or_run()?;
    }
    Ok(started.elapsed())
}

/// What a step was planned on.
struct Sampled {
    scene: Scene,
    candidates: Vec<Candidate>,
}

#[derive(Default)]
struct Recorder(Vec<Sampled>);

impl Observer for Recorder {
    fn on_step(&mut self, _step: &Step, input: &StepInput<'_>) {
        self.0.push(Sampled {
            scene: input.scene.clone(),
            candidates: input.candidates.to_vec(),
        });
    }
}
