//! Sequences packed by a way: what all experiments have in common.

use std::sync::Arc;
use std::time::Duration;

use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_cli::failure::{OrInput, OrRun, Outcome};
use ppnpack_cli::options::{CatalogueOptions, Network, Simulated, load};
use ppnpack_cli::sequence::Sequence;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::planning::method::{Method, OpenNetwork, ProposalSource, Stability};
use ppnpack_packing::planning::plan::Planner;
use ppnpack_packing::ranking::step::Timings;
use ppnpack_packing::streams::episode::{Episode, Observer, Play, play};
use ppnpack_physics::outcome::{self, is_unsteady};
use ppnpack_physics::packing_cell::{Sampling, SimulatedPackingCell};
use ppnpack_physics::settings::CellSettings;
use ppnpack_physics::trial;
use ppnpack_physics::twin::TwinSettings;
use serde::{Deserialize, Serialize};

use crate::apart::Apart;
use crate::cases::Case;
use crate::runs::RunsOptions;
use crate::way::Way;

pub(crate) fn sdfm(
    proposals: ProposalSource,
    stability: Stability,
    buffer: usize,
    seed: u64,
) -> Method {
    Method {
        proposals,
        stability,
        buffer,
        seed,
        ..Method::published()
    }
}

pub(crate) struct Packer<'a> {
    pub(crate) way: Way,
    pub(crate) grid: Grid,
    pub(crate) catalogue: Arc<Catalogue>,
    /// The cell as the planner knows it.
    pub(crate) simulated: Simulated,
    pub(crate) apart: Apart,
    pub(crate) network: Option<Network<'a>>,
}

#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct Run {
    pub(crate) objects: Vec<usize>,
    pub(crate) items: usize,
    pub(crate) placed: usize,
    /// Toppled, slid or fell out, of what was placed.
    pub(crate) unsteady: usize,
    pub(crate) set_aside: usize,
    pub(crate) in_other_pose: usize,
    /// Searched exhaustively, as none of their proposals was valid.
    pub(crate) steps_widened: usize,
    pub(crate) voxels_m3: f64,
    pub(crate) meshes_m3: f64,
    pub(crate) floor_compactness: f64,
    pub(crate) box_compactness: f64,
    pub(crate) mesh_floor_compactness: f64,
    pub(crate) height_m: f64,
    /// How far the highest of what is inside ends above the rim.
    pub(crate) above_rim_m: f64,
    /// Decision times of the steps.
    pub(crate) decision_s: Vec<f64>,
    /// Means over the steps, by stage.
    pub(crate) propose_s: f64,
    pub(crate) evaluate_s: f64,
    pub(crate) check_s: f64,
}

impl Packer<'_> {
    /// Packs in robot conditions, seen as the way says.
    pub(crate) fn robot(way: Way, options: &CatalogueOptions, apart: Apart) -> Outcome<Self> {
        let grid = way.grid.build().or_input()?;
        let mut settings = options.settings();
        settings.poses = way.poses;
        let catalogue = load(&options.source(), &settings, grid.resolution())?;
        let simulated = Simulated {
            scan: Sampling::Greatest,
            camera: way.camera,
            preloaded: None,
            cell: CellSettings {
                container: grid.container(),
                ..CellSettings::robot()
            },
        };
        Ok(Self {
            way,
            grid,
            catalogue: Arc::new(catalogue),
            simulated,
            apart,
            network: None,
        })
    }

    /// Gives an empty container's planner and cell. The seed is that of everything random.
    pub(crate) fn bench(&self, seed: u64) -> Outcome<(Planner, SimulatedPackingCell)> {
        let method = Method {
            seed,
            ..self.way.method.clone().for_poses(self.way.poses)
        };
        let known = CellSettings {
            seed,
            ..self.simulated.cell.clone()
        };
        let pool = trial::pool(self.way.threads).or_run()?;
        let twin = TwinSettings::of(&known);
        let trial = trial::check(method.trial, &method.loads, twin, pool).or_input()?;
        let network = self.network.as_ref();
        let network = network.map(|network| network as &dyn OpenNetwork);
        let planner =
            method.build_with(&self.grid, method.proposer(&self.grid, network)?, trial)?;
        let physics = self.apart.cell(known);
        let cell = self
            .simulated
            .packing_cell(physics, &self.grid, &self.catalogue)?;
        Ok((planner, cell.with_pose_error(self.apart.pose_error)))
    }

    pub(crate) fn how(&self) -> Play {
        Play {
            set_aside: self.way.set_aside,
            ..Play::with_buffer(self.way.method.buffer)
        }
    }

    /// Packs a sequence before an observer; gives the episode and the cell as it was left.
    pub(crate) fn play(
        &self,
        sequence: &Sequence,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Outcome<(Episode, SimulatedPackingCell)> {
        let (mut planner, mut cell) = self.bench(seed)?;
        let items = sequence.candidates(&self.catalogue);
        let episode = play(
            &self.grid,
            &mut planner,
            &mut cell,
            items,
            self.how(),
            observer,
        );
        Ok((episode.or_run()?, cell))
    }

    pub(crate) fn pack(
        &self,
        sequence: &Sequence,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Outcome<Run> {
        let (episode, cell) = self.play(sequence, seed, observer)?;
        Ok(Run::of(sequence, &self.grid, &episode, &cell))
    }

    /// Packs all sequences but those kept, and names their folder; each seed is `seed` plus number.
    pub(crate) fn pack_all(
        &self,
        cases: &[Case],
        seed: u64,
        runs: &RunsOptions,
        experiment: &str,
    ) -> Outcome<String> {
        let settings = (
            self.catalogue.content_hash(),
            &self.way,
            &self.simulated,
            &self.apart,
            seed,
        );
        let kept = runs.kept(experiment, &settings)?;
        kept.make(
            cases,
            Case::name,
            |case, run: &Run| run.objects == case.sequence.objects,
            |case| self.pack(&case.sequence, case.seed(seed), &mut ()),
        )?;
        Ok(kept.name())
    }
}

impl Run {
    pub(crate) fn of(
        sequence: &Sequence,
        grid: &Grid,
        episode: &Episode,
        cell: &SimulatedPackingCell,
    ) -> Self {
        let (steps, metrics) = (&episode.steps, &episode.metrics);
        let mean = |stage: fn(&Timings) -> Duration| {
            let total: Duration = steps.iter().map(|step| stage(&step.timings)).sum();
            total.as_secs_f64() / steps.len().max(1) as f64
        };
        let decisions = steps.iter().map(|step| step.timings.total().as_secs_f64());
        let height = episode.scene.heightmap().highest_content(grid);
        Self {
            objects: sequence.objects.clone(),
            items: metrics.packed.items,
            placed: steps.len(),
            unsteady: unsteady(cell),
            set_aside: episode.set_aside.len(),
            in_other_pose: steps.iter().filter(|it| it.candidate.pose > 0).count(),
            steps_widened: episode.steps_widened(),
            voxels_m3: metrics.packed.voxels_m3,
            meshes_m3: metrics.packed.meshes_m3,
            floor_compactness: metrics.floor_compactness,
            box_compactness: metrics.box_compactness,
            mesh_floor_compactness: metrics.mesh_floor_compactness,
            height_m: f64::from(height) * grid.resolution().height_unit_m(),
            above_rim_m: above_rim_m(grid, cell),
            decision_s: decisions.collect(),
            propose_s: mean(|timings| timings.propose),
            evaluate_s: mean(|timings| timings.evaluate),
            check_s: mean(|timings| timings.check),
        }
    }
}

/// How far the highest item inside ends above the rim, in metres.
fn above_rim_m(grid: &Grid, cell: &SimulatedPackingCell) -> f64 {
    let contents = cell.cell().contents().into_iter();
    let inside = contents.filter(|body| body.inside);
    let above_m = inside.map(|body| {
        let (mesh, pose) = (&body.model.mesh, &body.container_from_item);
        outcome::above_rim_m(grid.container(), mesh, pose)
    });
    above_m.fold(0.0, f64::max)
}

/// How many items toppled, slid or fell out when they were placed.
pub(crate) fn unsteady(cell: &SimulatedPackingCell) -> usize {
    let reports = cell.placed().iter().map(|placed| &placed.report);
    let unsteady =
        reports.filter(|report| is_unsteady(report.toppled, report.slide_m, report.inside));
    unsteady.count()
}
