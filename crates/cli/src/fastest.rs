//! Which source of proposals decides fastest, measured before the packing.

use std::sync::Arc;
use std::time::{Duration, Instant};

use ppnpack_packing::check::BoxedCheck;
use ppnpack_packing::episode::{IdealCell, Observer, Play, Step, play};
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::Scene;
use ppnpack_packing::item::Item;
use ppnpack_packing::look_ahead::LookAheadSettings;
use ppnpack_packing::method::{Method, OpenNetwork, ProposalSource};
use ppnpack_packing::plan::{Candidate, Planner};
use ppnpack_packing::scene_value::SceneValue;
use ppnpack_packing::step::StepInput;
use ppnpack_packing::trial::TrialSettings;
use ppnpack_robot::station::ArmStation;
use serde::Serialize;

use crate::failure::{Failure, OrRun, Outcome};

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

/// Gives a method the fastest of some sources of proposals, where there are several; tells what each was measured to
/// cost, the fastest first.
///
/// A sample of `items` is packed as planned, without physics. Each source plans the same steps twice, and the second time
/// counts, when its memory is allocated and its item features are known.
pub(crate) fn choose(
    method: &mut Method,
    sources: &[ProposalSource],
    grid: &Grid,
    items: &[Arc<Item>],
    station: Option<&ArmStation>,
    threads: u32,
    network: Option<&dyn OpenNetwork>,
) -> Outcome<Vec<Cost>> {
    if sources.len() < 2 {
        return Ok(Vec::new());
    }
    let planner = |source: &ProposalSource| -> Outcome<Planner> {
        // To try placements, to value what they leave and to look ahead costs the same with every source.
        let of_source = Method {
            proposals: source.clone(),
            trial: TrialSettings::off(),
            scene_value: SceneValue::default(),
            look_ahead: LookAheadSettings::default(),
            ..method.clone()
        };
        let proposer = of_source.proposer(grid, network)?;
        let check = station.map(|station| Box::new(station.check()) as BoxedCheck);
        Ok(of_source.build_with(grid, proposer, check, threads)?)
    };
    let steps = sample(
        &mut planner(&ProposalSource::Bounded)?,
        method.buffer,
        grid,
        items,
    )?;
    let mut costs = Vec::with_capacity(sources.len());
    for source in sources {
        let decision_s = match planner(source) {
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
    if let Some(fastest) = costs.first() {
        method.proposals = fastest.proposals.clone();
    }
    Ok(costs)
}

fn sample(
    planner: &mut Planner,
    buffer: usize,
    grid: &Grid,
    items: &[Arc<Item>],
) -> Outcome<Vec<Sampled>> {
    let items = Candidate::sequence(items.iter().take(SAMPLE_ITEMS).cloned());
    let mut recorder = Recorder::default();
    let (mut cell, how) = (IdealCell::new(grid), Play::with_buffer(buffer));
    play(grid, planner, &mut cell, items, how, &mut recorder).or_run()?;
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
