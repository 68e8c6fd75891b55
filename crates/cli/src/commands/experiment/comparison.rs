//! Several methods on the same sequences, in one cell: what table 1, table 4 and the Pareto charts have in common.

use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_packing::grid::Grid;
use ppnpack_packing::objective::{Heuristic, Order, Weights};
use ppnpack_packing::plan::Timings;
use serde::{Deserialize, Serialize};

use super::runs::Runs;
use super::statistics::Mean;
use crate::failure::{Failure, OrRun, Outcome};
use crate::options::{Method, Network, ProposalSource, Simulated, StabilityOption};
use crate::sequence::Sequence;
use crate::simulation::simulate;
use crate::workers;

/// What all runs of a comparison share.
#[derive(Debug, Serialize)]
pub(super) struct Setting {
    pub(super) version: &'static str,
    pub(super) catalogue_hash: String,
    pub(super) grid: Grid,
    pub(super) simulated: Simulated,
    pub(super) buffer: usize,
    pub(super) stability: StabilityOption,
    pub(super) seed: u64,
}

/// A method that is compared.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Contender {
    pub(super) name: String,
    pub(super) heuristic: Heuristic,
    pub(super) order: Order,
    pub(super) proposals: ProposalSource,
}

/// One packed sequence.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Run {
    pub(super) objects: Vec<usize>,
    /// Mean decision time per packed item, in seconds.
    pub(super) decision_s: f64,
    /// The same by stage.
    pub(super) propose_s: f64,
    pub(super) evaluate_s: f64,
    pub(super) check_s: f64,
    pub(super) items: usize,
    pub(super) placed: usize,
    pub(super) voxels_m3: f64,
    pub(super) meshes_m3: f64,
    pub(super) compactness: f64,
    pub(super) mesh_compactness: f64,
    pub(super) height_m: f64,
}

/// The means over the sequences of a method.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Means {
    pub(super) cases: usize,
    pub(super) decision_s: Mean,
    pub(super) propose_s: Mean,
    pub(super) evaluate_s: Mean,
    pub(super) check_s: Mean,
    pub(super) items: Mean,
    pub(super) fallen_out: Mean,
    pub(super) voxels_cm3: Mean,
    pub(super) meshes_cm3: Mean,
    pub(super) compactness_percent: Mean,
    pub(super) mesh_compactness_percent: Mean,
    pub(super) height_m: Mean,
}

impl Means {
    pub(super) fn of(runs: &[Run]) -> Self {
        let mean = |value: fn(&Run) -> f64| Mean::of(runs.iter().map(value));
        Self {
            cases: runs.len(),
            decision_s: mean(|run| run.decision_s),
            propose_s: mean(|run| run.propose_s),
            evaluate_s: mean(|run| run.evaluate_s),
            check_s: mean(|run| run.check_s),
            items: mean(|run| run.items as f64),
            fallen_out: mean(|run| (run.placed - run.items) as f64),
            voxels_cm3: mean(|run| run.voxels_m3 * 1e6),
            meshes_cm3: mean(|run| run.meshes_m3 * 1e6),
            compactness_percent: mean(|run| run.compactness * 100.0),
            mesh_compactness_percent: mean(|run| run.mesh_compactness * 100.0),
            height_m: mean(|run| run.height_m),
        }
    }
}

/// The sum of a value over some runs divided by the sum over others on the same sequences, in percent. The interval
/// is that of a ratio of paired means (by the differences to the ratio's line).
pub(super) fn ratio_percent(runs: &[Run], others: &[Run], value: fn(&Run) -> f64) -> Mean {
    let sum = |runs: &[Run]| runs.iter().map(value).sum::<f64>();
    let (ours, theirs) = (sum(runs), sum(others));
    if theirs <= 0.0 {
        return Mean::default();
    }
    let ratio = ours / theirs;
    let pairs = runs.iter().zip(others);
    let deviation = Mean::of(pairs.map(|(run, other)| value(run) - ratio * value(other)));
    let scale = runs.len() as f64 / theirs;
    Mean {
        mean: 100.0 * ratio,
        half_width: 100.0 * deviation.half_width * scale,
    }
}

/// Packs all sequences with all methods, those first that come first; gives the runs by method, then sequence.
pub(super) fn pack_all(
    catalogue: &Catalogue,
    setting: &Setting,
    contenders: &[Contender],
    sequences: &[Sequence],
    runs: &Runs,
    workers: usize,
    network: Option<Network<'_>>,
) -> Outcome<Vec<Vec<Run>>> {
    let cases = 0..sequences.len();
    let jobs: Vec<(usize, &Contender)> = cases
        .clone()
        .flat_map(|case| contenders.iter().map(move |contender| (case, contender)))
        .collect();
    workers::for_each("Packing sequences", &jobs, workers, |(case, contender)| {
        let Some(sequence) = sequences.get(*case) else {
            return Ok(());
        };
        let name = name(contender, *case)?;
        let finished: Option<Run> = runs.load(&name);
        if finished.is_some_and(|run| run.objects == sequence.objects) {
            return Ok(());
        }
        let run = pack(catalogue, setting, contender, sequence, *case, network)?;
        runs.save(&name, &run)
    })?;
    let of_contender = |contender: &Contender| {
        cases
            .clone()
            .map(|case| {
                let name = name(contender, case)?;
                let missing = || Failure::Run(anyhow::anyhow!("the run {name} is gone"));
                runs.load(&name).ok_or_else(missing)
            })
            .collect()
    };
    contenders.iter().map(of_contender).collect()
}

/// The name of a run's file: readable, and another one for another method.
fn name(contender: &Contender, case: usize) -> Outcome<String> {
    let method = serde_json::to_vec(contender).or_run()?;
    let hash = blake3::hash(&method).to_hex();
    let letters = contender.name.chars().map(|letter| {
        if letter.is_ascii_alphanumeric() {
            letter.to_ascii_lowercase()
        } else {
            '-'
        }
    });
    let letters: String = letters.collect();
    Ok(format!(
        "{letters}-{}-{case:05}",
        hash.get(..8).unwrap_or("")
    ))
}

/// Packs one sequence with one method.
fn pack(
    catalogue: &Catalogue,
    setting: &Setting,
    contender: &Contender,
    sequence: &Sequence,
    case: usize,
    network: Option<Network<'_>>,
) -> Outcome<Run> {
    let method = Method {
        heuristic: contender.heuristic,
        order: contender.order,
        proposals: contender.proposals.clone(),
        stability: setting.stability,
        arm: None,
        weights: Weights::default(),
        buffer: setting.buffer,
        seed: setting.seed.wrapping_add(case as u64),
    };
    let mut simulated = setting.simulated.clone();
    simulated.cell.seed = method.seed;
    let mut planner = method.planner(&setting.grid, 1, network)?;
    let (episode, _) = simulate(
        catalogue,
        &setting.grid,
        sequence,
        &simulated,
        &mut planner,
        method.buffer,
        &mut (),
    )?;
    let height = episode.scene.heightmap().max();
    let steps = &episode.steps;
    let mean = |stage: fn(&Timings) -> std::time::Duration| {
        let total: std::time::Duration = steps.iter().map(|step| stage(&step.timings)).sum();
        total.as_secs_f64() / steps.len().max(1) as f64
    };
    Ok(Run {
        objects: sequence.objects.clone(),
        decision_s: episode.mean_decision_s(),
        propose_s: mean(|timings| timings.propose),
        evaluate_s: mean(|timings| timings.evaluate),
        check_s: mean(|timings| timings.check),
        items: episode.metrics.packed.items,
        placed: steps.len(),
        voxels_m3: episode.metrics.packed.voxels_m3,
        meshes_m3: episode.metrics.packed.meshes_m3,
        compactness: episode.metrics.compactness,
        mesh_compactness: episode.metrics.mesh_compactness,
        height_m: f64::from(height) * setting.grid.resolution().height_unit_m(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(meshes_m3: f64) -> Run {
        Run {
            objects: vec![],
            decision_s: 0.0,
            propose_s: 0.0,
            evaluate_s: 0.0,
            check_s: 0.0,
            items: 0,
            placed: 0,
            voxels_m3: 0.0,
            meshes_m3,
            compactness: 0.0,
            mesh_compactness: 0.0,
            height_m: 0.0,
        }
    }

    #[test]
    fn a_ratio_of_proportional_runs_is_certain() {
        let others = [run(1.0), run(2.0), run(4.0)];
        let halves = [run(0.5), run(1.0), run(2.0)];
        let ratio = ratio_percent(&halves, &others, |run| run.meshes_m3);
        assert!((ratio.mean - 50.0).abs() < 1e-9 && ratio.half_width < 1e-9);
        let uneven = [run(0.9), run(1.0), run(1.6)];
        let ratio = ratio_percent(&uneven, &others, |run| run.meshes_m3);
        assert!((ratio.mean - 50.0).abs() < 1e-9 && ratio.half_width > 1.0);
        assert_eq!(
            ratio_percent(&[], &[], |run| run.meshes_m3),
            Mean::default()
        );
    }
}
