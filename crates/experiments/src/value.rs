//! `ppnpack experiment value`: the value of what a placement leaves, learned from packings.
//!
//! Sequences are packed as usual; at each step the figures of the scene after the placement are noted, and at the end how much was
//! packed after it. A ridge regression of that on the figures gives the coefficients of [`SceneValue`].

mod ridge;

use clap::Args;
use ppnpack_cli::failure::{Failure, OrInput, OrRun, Outcome};
use ppnpack_cli::options::{CatalogueOptions, Conditions, GridOptions};
use ppnpack_files::write_whole;
use ppnpack_packing::episode::{Observer, Step};
use ppnpack_packing::scene_value::{FIGURES, FIGURES_OF_ITEMS, SceneValue, Squares, figures};
use ppnpack_packing::step::StepInput;
use serde::{Deserialize, Serialize};

use crate::apart::Apart;
use crate::cases::{Case, SequenceOptions};
use crate::document::{OutOptions, Page};
use crate::packer::Packer;
use crate::runs::RunsOptions;
use crate::way::Way;
use ridge::{Sample, explained, fit};

/// In standard deviations of the figures; from 30 to 1,000 what is explained differs by less than a thousandth.
const PENALTY: f64 = 100.0;

/// The sequences before this one are the tests': what is learned is measured on them.
const FIRST_FOR_LEARNING: u32 = 100;

/// Packs sequences in robot conditions and learns what scenes are worth.
#[derive(Debug, Args)]
pub(crate) struct ValueArguments {
    #[command(flatten)]
    catalogue: CatalogueOptions,

    #[command(flatten)]
    grid: GridOptions,

    #[command(flatten)]
    sequences: SequenceOptions<1000, 200>,

    /// How many items may be set aside
    #[arg(long, value_name = "COUNT", default_value_t = 20)]
    set_aside: usize,

    #[command(flatten)]
    runs: RunsOptions,

    #[command(flatten)]
    out: OutOptions,
}

/// What was seen of a packed sequence.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct Seen {
    objects: Vec<usize>,
    /// Of each step: the figures of what the placement left.
    figures: Vec<Vec<f64>>,
    /// Of each step: the mesh volume of its item and of all before it.
    packed_m3: Vec<f64>,
    /// The mesh volume in the container at the end.
    meshes_m3: f64,
}

impl Observer for Seen {
    fn on_step(&mut self, step: &Step, input: &StepInput<'_>) {
        let resting = &step.choice.resting;
        let Some(view) = step.candidate.item.views().get(resting.placement.yaw) else {
            return;
        };
        let after = Squares::of(input.grid, input.scene.heightmap()).with(view, resting);
        let before_m3 = self.packed_m3.last().copied().unwrap_or_default();
        self.figures
            .push(figures(input, &after, step.choice.candidate));
        self.packed_m3
            .push(before_m3 + step.candidate.item.mesh_volume_m3());
    }
}

pub(crate) fn run(arguments: &ValueArguments) -> Outcome {
    let first = arguments.sequences.first;
    if first < FIRST_FOR_LEARNING {
        return Err(Failure::input(format_args!(
            "--first {}: sequences 0 to {} are the tests', from which nothing may be learned; give {FIRST_FOR_LEARNING} or more",
            first,
            FIRST_FOR_LEARNING - 1
        )));
    }
    let way = way(arguments);
    way.method.validate().or_input()?;
    let packer = Packer::robot(way, &arguments.catalogue, Apart::default())?;
    let cases = arguments.sequences.read(&packer.catalogue)?;
    let folder = arguments.runs.folder(&arguments.out, "value");
    let settings = (packer.catalogue.content_hash(), &packer.way);
    let is_right = |case: &Case, seen: &Seen| seen.objects == case.sequence.objects;
    let see = |case: &Case| {
        let mut seen = Seen::default();
        let run = packer.pack(&case.sequence, case.seed(0), &mut seen)?;
        Ok(Seen {
            objects: run.objects,
            meshes_m3: run.meshes_m3,
            ..seen
        })
    };
    let runs = &arguments.runs;
    let seen = runs.make(&folder, &settings, &cases, Case::name, is_right, see)?;
    let size = packer.grid.container();
    let container_m3 = size.x_m * size.y_m * size.z_m;
    let seen = seen.iter();
    let sequences: Vec<Vec<Sample>> = seen.map(|seen| samples(seen, container_m3)).collect();
    publish(arguments, &packer.way, &sequences)
}

/// As `ppnpack pack` packs.
fn way(arguments: &ValueArguments) -> Way {
    let poses = arguments.catalogue.settings().poses;
    let mut way = Way {
        name: "learned from".to_owned(),
        grid: arguments.grid.settings(Conditions::Robot),
        poses,
        set_aside: arguments.set_aside,
        ..Way::default()
    };
    // What is learned is what the objective alone leaves out.
    way.method.scene_value = SceneValue::off();
    way
}

/// The steps of a sequence, each with what was packed after it, as a share of the container.
fn samples(seen: &Seen, container_m3: f64) -> Vec<Sample> {
    let steps = seen.figures.iter().zip(&seen.packed_m3);
    let samples = steps.map(|(figures, packed_m3)| Sample {
        figures: figures.clone(),
        packed: packed_m3 / container_m3,
        further: (seen.meshes_m3 - packed_m3) / container_m3,
    });
    samples.collect()
}

/// Writes what was learned, as a document and as methods to compare by `experiment filling --methods`.
fn publish(arguments: &ValueArguments, way: &Way, sequences: &[Vec<Sample>]) -> Outcome {
    let nothing = || Failure::input("nothing was packed that could be learned from");
    let all = sequences.iter().flatten();
    let linear = fit(all.clone(), 0, PENALTY).ok_or_else(nothing)?;
    let explains = |first| explained(sequences, first, PENALTY).ok_or_else(nothing);
    let of_all = explains(0)?;
    // What a placement has no influence on.
    let without_surface = explains(FIGURES - FIGURES_OF_ITEMS)?;
    let mut coefficients = linear.coefficients;
    // What was packed until then is the same for all placements of a step.
    coefficients.truncate(FIGURES);
    let named = |name: &str, value: SceneValue| {
        let mut way = way.clone();
        name.clone_into(&mut way.name);
        way.method.scene_value = value;
        way
    };
    let learned = SceneValue {
        coefficients: coefficients.clone(),
        ..SceneValue::default()
    };
    let ways = [
        named("objective alone", SceneValue::off()),
        named("with the learned value", learned),
    ];
    let ways = serde_json::to_vec_pretty(&ways).or_run()?;
    write_whole(&arguments.out.folder("value").join("methods.json"), &ways)?;
    let (sequences, grid) = (&arguments.sequences, &way.grid);
    let samples = all.count();
    let mut page = Page::new(
        "value",
        format!(
            "# Value: what a placement leaves\n\n\
             Learned from sequences {} to {} in robot conditions: cells of {} mm, {} yaws, {} set aside, poses {}, by the \
             objective alone.\n\n\
             | | |\n|---|---|\n\
             | steps | {samples} |\n\
             | variance explained, of sequences held back | {:.1} % |\n\
             | of that without the figures of the surface | {:.1} % |\n\n\
             `methods.json` has the coefficients: `ppnpack-experiments experiment filling --methods methods.json` says what they are worth.\n",
            sequences.first,
            sequences.last(),
            1e3 * grid.cell_m,
            grid.yaws,
            way.set_aside,
            way.poses,
            100.0 * of_all,
            100.0 * without_surface,
        ),
    );
    page.keep("first_case", sequences.first);
    page.keep("cases", sequences.cases);
    page.keep("way", way);
    page.keep("samples", samples);
    page.keep("explained", of_all);
    page.keep("explained_without_surface", without_surface);
    page.keep("coefficients", coefficients);
    page.publish(&arguments.out)
}
