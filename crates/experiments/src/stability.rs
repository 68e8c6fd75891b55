//! `ppnpack experiment stability`: both stability tests against what the simulated cell does.

use std::path::PathBuf;

use clap::Args;
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_packing::buffer::Buffer;
use ppnpack_packing::check::Evidence;
use ppnpack_packing::episode::PackingCell;
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::Scene;
use ppnpack_packing::objective::Order;
use ppnpack_packing::plan::{Candidate, Evaluated, Evaluator, Planner, StepInput};
use ppnpack_packing::proposals::{Proposals, ProposeAll, Proposer};
use ppnpack_packing::search::{Search, SearchSettings};
use ppnpack_packing::stability::{
    PhysicalStability, PhysicalStabilitySettings, PublishedStability,
};
use ppnpack_packing::step::StageError;
use ppnpack_physics::packing_cell::{Sampling, SimulatedPackingCell};
use ppnpack_physics::settings::CellSettings;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::document::{self, Answer, Document};
use crate::runs::{Runs, ShardOptions};
use crate::statistics::{percent, percentage};
use crate::workers;
use ppnpack_cli::failure::{Failure, OrInput, OrRun, Outcome};
use ppnpack_cli::options::{CatalogueOptions, Conditions, GridOptions, PhysicsOptions};

/// Tries placements in half-packed containers and compares both stability tests with what becomes of the items.
///
/// In each scene items of the buffer are released at placements drawn at random among those that fit, and at those
/// that SDFM ranks best without any stability test; the scene is restored after each. An item stood if it slid by at
/// most a centimetre and did not topple.
#[derive(Debug, Args)]
pub(crate) struct StabilityArguments {
    #[command(flatten)]
    catalogue: CatalogueOptions,

    /// How many sequences are packed to make scenes
    #[arg(long, value_name = "COUNT", default_value_t = 40, value_parser = clap::value_parser!(u32).range(1..))]
    sequences: u32,

    /// Placements of each kind tried in each scene
    #[arg(long, value_name = "COUNT", default_value_t = 6, value_parser = clap::value_parser!(u32).range(1..))]
    placements: u32,

    #[command(flatten)]
    grid: GridOptions,

    #[command(flatten)]
    physics: PhysicsOptions,

    /// The seed of everything that is random
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    seed: u64,

    /// Surfaces closer than this are in contact for the physical test
    #[arg(long, value_name = "LENGTH", default_value = "2mm", value_parser = ppnpack_cli::length::parse_length)]
    tolerance: f64,

    /// The margin of the physical test
    #[arg(long, value_name = "LENGTH", default_value = "3mm", value_parser = ppnpack_cli::length::parse_distance)]
    margin: f64,

    /// Where report.html, stability.md and stability.json are written
    #[arg(long, value_name = "DIR", default_value = "out/stability")]
    out: PathBuf,

    #[command(flatten)]
    runs: ShardOptions,

    /// Print the results as JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// Heights from which items are released: laid down by a robot, and dropped as in the reference.
const RELEASE_HEIGHTS_M: [f64; 2] = [0.005, 0.12];

/// Items are tried every so many packed ones.
const STEPS_BETWEEN_SCENES: u64 = 4;

/// Items drawn for a sequence.
const SEQUENCE_LENGTH: usize = 60;

/// How many of SDFM's best placements are drawn from.
const BEST_RANKS: usize = 200;

/// An item whose smaller horizontal side is below this is small, in cells.
const SMALL_CELLS: usize = 2;

/// A horizontal move above this is a slide, in metres.
const SLIDE_M: f64 = 0.01;

/// Everything is given this long to come to rest, in seconds.
const SETTLE_S: f64 = 3.0;

#[derive(Debug, Serialize)]
struct Settings {
    catalogue_hash: String,
    grid: Grid,
    physics: CellSettings,
    scan: Sampling,
    physical: PhysicalStabilitySettings,
    placements: usize,
    seed: u64,
}

/// How a placement was drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Drawn {
    /// Among all that fit.
    Anywhere,
    /// Among those that SDFM ranks best.
    Best,
}

/// One placement tried.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Trial {
    item: String,
    drawn: Drawn,
    is_small: bool,
    release_m: f64,
    published: bool,
    physical: bool,
    /// How far inside the physical test's support polygon the centre of mass lies, in metres; null without area.
    depth_m: Option<f64>,
    slide_m: f64,
    tilt_rad: f64,
    stood: bool,
}

pub(crate) fn run(arguments: &StabilityArguments) -> Outcome {
    let grid = arguments.grid.grid(Conditions::Reference)?;
    let simulated = arguments
        .physics
        .simulated(&grid, arguments.seed, Conditions::Robot)?;
    if simulated.camera.is_some() {
        return Err(Failure::input(
            "--view camera: what stays is told of an exact scan",
        ));
    }
    let mut physics = simulated.cell;
    physics.settle_time_s = arguments.physics.settle.unwrap_or(SETTLE_S);
    let catalogue = arguments.catalogue.load(grid.resolution())?;
    let settings = Settings {
        catalogue_hash: catalogue.content_hash(),
        grid,
        physics,
        scan: simulated.scan,
        physical: PhysicalStabilitySettings {
            contact_tolerance_m: arguments.tolerance,
            margin_m: arguments.margin,
        },
        placements: arguments.placements as usize,
        seed: arguments.seed,
    };
    let part = arguments.runs.part(&arguments.out);
    let runs = Runs::new(&part.runs, &settings)?;
    let jobs = (0..u64::from(arguments.sequences))
        .flat_map(|sequence| (0..RELEASE_HEIGHTS_M.len()).map(move |release| (sequence, release)));
    let cores = workers::default_count();
    let jobs: Vec<(u64, usize)> = part.of(jobs).collect();
    let trials = workers::map("Trying placements", &jobs, cores, |job| {
        let (sequence, release) = job;
        let name = format!("sequence-{sequence:04}-release-{release}");
        let play = || Trials::new(&catalogue, &settings, *job)?.play();
        runs.finish(&name, |_| true, play)
    })?;
    let Some(trials) = part.finish(&runs, trials)? else {
        return part.tell(arguments.json);
    };
    let trials: Vec<Trial> = trials.into_iter().flatten().collect();
    let results = Results {
        tallies: tallies(&trials),
        settings: &settings,
    };
    draw(arguments, &results.tallies)?;
    let document = Document {
        name: "stability",
        answer: Answer {
            question: "Do stability tests tell what stays?",
            text: answer(&results.tallies),
            picture: "stability.svg".to_owned(),
        },
        results: &results,
        asked: arguments,
        measured: &["tallies"],
        markdown: markdown(&results, trials.len()),
    };
    document.publish(&arguments.out, arguments.json)
}

fn draw(arguments: &StabilityArguments, tallies: &[Tally]) -> Outcome {
    let bars = tallies
        .iter()
        .filter(|tally| tally.accepted > 0)
        .map(|tally| {
            let height_cm = tally.release_m * 100.0;
            let label = format!("{}, {}, {height_cm:.1} cm", tally.test, tally.placements);
            (
                label,
                percentage(tally.accepted_toppled_or_slid, tally.accepted),
            )
        });
    let titles = [
        "What a test accepts and does not stay",
        "Toppled or slid, of the accepted (%)",
    ];
    document::bars(&arguments.out, "stability", titles, bars)
}

/// How often each test is wrong, over all placements.
fn answer(tallies: &[Tally]) -> String {
    let of_test = |test: &str| {
        let sum = |count: fn(&Tally) -> usize| {
            let tallies = tallies.iter().filter(|tally| tally.test == test);
            tallies.map(count).sum::<usize>()
        };
        let accepted = sum(|tally| tally.accepted);
        format!(
            "Of what the {test} test accepts {} toppled or slid, and of what it rejects {} would have stood.",
            percent(sum(|tally| tally.accepted_toppled_or_slid), accepted),
            percent(
                sum(|tally| tally.rejected_but_stood),
                sum(|tally| tally.trials) - accepted
            )
        )
    };
    TESTS.map(of_test).join(" ")
}

/// The trials along one packed sequence.
struct Trials<'a> {
    settings: &'a Settings,
    cell: SimulatedPackingCell,
    buffer: Buffer,
    planner: Planner,
    ranking: Search,
    published: PublishedStability,
    physical: PhysicalStability,
    random: ChaCha8Rng,
    release_m: f64,
    trials: Vec<Trial>,
}

impl<'a> Trials<'a> {
    fn new(
        catalogue: &Catalogue,
        settings: &'a Settings,
        (sequence, release): (u64, usize),
    ) -> Outcome<Self> {
        let release_m = RELEASE_HEIGHTS_M.get(release).copied().unwrap_or_default();
        let mut physics = settings.physics.clone();
        physics.release.height_m = release_m;
        // Both release heights see the same items.
        let mut random = ChaCha8Rng::seed_from_u64(settings.seed.wrapping_add(sequence));
        let objects = (0..SEQUENCE_LENGTH).map(|_| random.random_range(0..catalogue.len()));
        let items = objects.filter_map(|object| Some(catalogue.get(object)?.item.clone()));
        let search = SearchSettings {
            seed: settings.seed,
            ..SearchSettings::default()
        };
        let grid = &settings.grid;
        let physical = PhysicalStability::new(settings.physical);
        Ok(Self {
            settings,
            cell: SimulatedPackingCell::new(physics, grid, catalogue, settings.scan).or_input()?,
            buffer: Buffer::new(Candidate::sequence(items), 5),
            planner: Planner::new(
                Box::new(ProposeAll),
                Box::new(Search::new(grid, &search).or_input()?),
                vec![Box::new(physical.clone())],
                Order::Balance,
                settings.seed,
            ),
            ranking: Search::new(grid, &search).or_input()?,
            published: PublishedStability::default(),
            physical,
            random,
            release_m,
            trials: Vec::new(),
        })
    }

    /// Packs the sequence, trying placements every few items.
    fn play(mut self) -> Outcome<Vec<Trial>> {
        let grid = &self.settings.grid;
        for step in 0.. {
            let scene = done(self.cell.scan())?;
            let candidates = self.buffer.candidates().to_vec();
            let input = StepInput {
                step,
                ..StepInput::new(grid, &scene, &candidates)
            };
            if step.is_multiple_of(STEPS_BETWEEN_SCENES) {
                self.try_placements(&input)?;
            }
            let Some(choice) = self.planner.plan(&input).or_run()?.choice() else {
                break;
            };
            let Some(taken) = self.buffer.take(choice.candidate) else {
                break;
            };
            let evidence = Evidence::default();
            done(self.cell.place(&taken, &choice.resting, &evidence))?;
        }
        Ok(self.trials)
    }

    fn try_placements(&mut self, input: &StepInput<'_>) -> Outcome {
        for (index, candidate) in input.candidates.iter().enumerate() {
            let mut proposals = Proposals::default();
            done(ProposeAll.propose(input, &mut proposals))?;
            done(self.ranking.rank(input, &[index], &proposals))?;
            let mut ranked = Vec::new();
            while let Some(next) = done(self.ranking.next_best(input))? {
                ranked.push(next);
            }
            let (all, best) = (ranked.len(), ranked.len().min(BEST_RANKS));
            for (drawn, among) in [(Drawn::Anywhere, all), (Drawn::Best, best)] {
                for _ in 0..self.settings.placements.min(among) {
                    let rank = self.random.random_range(0..among);
                    if let Some(at) = ranked.get(rank).copied() {
                        let trial = self.try_one(input.scene, candidate, &at, drawn)?;
                        self.trials.push(trial);
                    }
                }
            }
        }
        Ok(())
    }

    fn try_one(
        &mut self,
        scene: &Scene,
        candidate: &Candidate,
        at: &Evaluated,
        drawn: Drawn,
    ) -> Outcome<Trial> {
        let grid = &self.settings.grid;
        let view = candidate.item.views().get(at.resting.placement.yaw);
        let view =
            view.ok_or_else(|| Failure::Run(anyhow::anyhow!("the placement has no view")))?;
        let report = done(self.cell.try_place(candidate, &at.resting))?;
        let depth_m = self.physical.depth_m(grid, scene, view, &at.resting);
        let published = &mut self.published;
        let is_stable = published.is_stable(grid, scene.heightmap(), view, &at.resting);
        Ok(Trial {
            item: candidate.item.name().to_string(),
            drawn,
            is_small: view.nx().min(view.ny()) <= SMALL_CELLS,
            release_m: self.release_m,
            published: is_stable,
            physical: depth_m >= self.settings.physical.margin_m,
            depth_m: depth_m.is_finite().then_some(depth_m),
            slide_m: report.slide_m,
            tilt_rad: report.tilt_rad,
            stood: report.inside && !report.toppled && report.slide_m <= SLIDE_M,
        })
    }
}

/// What a stage of planning or the cell gave.
fn done<T>(result: Result<T, StageError>) -> Outcome<T> {
    result.map_err(anyhow::Error::from_boxed).or_run()
}

/// The tests, by their names in results.
const TESTS: [&str; 2] = ["published", "physical"];

/// Counts of one group of trials for one test.
#[derive(Debug, Clone, Serialize)]
struct Tally {
    placements: &'static str,
    release_m: f64,
    test: &'static str,
    trials: usize,
    accepted: usize,
    accepted_toppled_or_slid: usize,
    rejected_but_stood: usize,
}

fn tallies(trials: &[Trial]) -> Vec<Tally> {
    let groups = [
        ("anywhere", Drawn::Anywhere, false),
        ("SDFM's best", Drawn::Best, false),
        ("small items, anywhere", Drawn::Anywhere, true),
        ("small items, SDFM's best", Drawn::Best, true),
    ];
    let mut tallies = Vec::new();
    for release_m in RELEASE_HEIGHTS_M {
        for (placements, drawn, is_small) in groups {
            let is_in = |trial: &&Trial| {
                (trial.release_m, trial.drawn, trial.is_small) == (release_m, drawn, is_small)
            };
            let group: Vec<&Trial> = trials.iter().filter(is_in).collect();
            for test in TESTS {
                let accepts = |trial: &Trial| match test {
                    "published" => trial.published,
                    _ => trial.physical,
                };
                let count = |matches: &dyn Fn(&Trial) -> bool| {
                    group.iter().filter(|trial| matches(trial)).count()
                };
                tallies.push(Tally {
                    placements,
                    release_m,
                    test,
                    trials: group.len(),
                    accepted: count(&accepts),
                    accepted_toppled_or_slid: count(&|trial| accepts(trial) && !trial.stood),
                    rejected_but_stood: count(&|trial| !accepts(trial) && trial.stood),
                });
            }
        }
    }
    tallies
}

#[derive(Debug, Serialize)]
struct Results<'a> {
    #[serde(serialize_with = "document::with_version")]
    settings: &'a Settings,
    tallies: Vec<Tally>,
}

fn markdown(results: &Results<'_>, trials: usize) -> String {
    let physical = results.settings.physical;
    let mut text = format!(
        "# Stability tests against the simulated cell\n\n\
         {trials} placements tried in partly packed containers, on cells of {} cm. An item stood if, when everything \
         was at rest, it had slid by at most {} cm, had not toppled and was inside. *Anywhere* are placements drawn \
         among all that fit, *SDFM's best* among the {BEST_RANKS} of an item that SDFM ranks best with no stability \
         test. Small items are at most {SMALL_CELLS} cells wide. The physical test counts surfaces within {:.1} mm as \
         contact and asks for a margin of {:.1} mm.\n\n\
         | release | placements | test | tried | accepted | of the accepted, toppled or slid | \
         of the rejected, would have stood |\n|---|---|---|---|---|---|---|\n",
        results.settings.grid.resolution().cell_m() * 100.0,
        SLIDE_M * 100.0,
        physical.contact_tolerance_m * 1e3,
        physical.margin_m * 1e3,
    );
    for tally in &results.tallies {
        text += &format!(
            "| {:.1} cm above | {} | {} | {} | {} | {} | {} |\n",
            tally.release_m * 100.0,
            tally.placements,
            tally.test,
            tally.trials,
            percent(tally.accepted, tally.trials),
            percent(tally.accepted_toppled_or_slid, tally.accepted),
            percent(tally.rejected_but_stood, tally.trials - tally.accepted)
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_answer_adds_all_placements_up_by_test() {
        let tally = |test, placements, accepted_toppled_or_slid| Tally {
            placements,
            release_m: 0.005,
            test,
            trials: 10,
            accepted: 4,
            accepted_toppled_or_slid,
            rejected_but_stood: 3,
        };
        let tallies = [
            tally("published", "anywhere", 1),
            tally("published", "SDFM's best", 3),
            tally("physical", "anywhere", 0),
        ];
        assert_eq!(
            answer(&tallies),
            "Of what the published test accepts 50.0 % toppled or slid, and of what it rejects 50.0 % would have stood. \
             Of what the physical test accepts 0.0 % toppled or slid, and of what it rejects 50.0 % would have stood."
        );
    }
}
