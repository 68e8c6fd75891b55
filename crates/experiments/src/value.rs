//! `ppnpack experiment value`: the value of what a placement leaves, learned from packings.
//!
//! Sequences are packed as usual; at each step the figures of the scene after the placement are noted, and at the end how much was
//! packed after it. A ridge regression of that on the figures gives the coefficients of [`SceneValue`].

mod results;
mod ridge;

use clap::Args;
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_cli::failure::{Failure, OrInput, Outcome};
use ppnpack_cli::options::{CatalogueOptions, Conditions, GridOptions};
use ppnpack_packing::episode::{Observer, Step};
use ppnpack_packing::scene_value::{SceneValue, Squares, figures};
use ppnpack_packing::step::StepInput;
use serde::{Deserialize, Serialize};

use crate::cases::{Case, SequenceOptions};
use crate::document::OutOptions;
use crate::filling::apart::Apart;
use crate::filling::{Way, pack};
use crate::runs::{Runs, RunsOptions, hash};
use results::Results;
use ridge::Sample;

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

    /// The weight of the value by which the sequences are packed, of coefficients that are built in; with 0 the objective alone
    #[arg(
        long,
        value_name = "NUMBER",
        default_value_t = 0.0,
        allow_hyphen_values = true
    )]
    scene_value: f64,

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

/// Notes the figures of each step.
#[derive(Default)]
struct Notes {
    seen: Seen,
}

impl Observer for Notes {
    fn on_step(&mut self, step: &Step, input: &StepInput<'_>) {
        let resting = &step.choice.resting;
        let Some(view) = step.candidate.item.views().get(resting.placement.yaw) else {
            return;
        };
        let after = Squares::of(input.grid, input.scene.heightmap()).with(view, resting);
        let before_m3 = self.seen.packed_m3.last().copied().unwrap_or_default();
        let seen = &mut self.seen;
        seen.figures
            .push(figures(input, &after, step.choice.candidate));
        seen.packed_m3
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
    let resolution = way.grid.resolution().or_input()?;
    let catalogue = arguments.catalogue.load(&resolution)?;
    let cases = arguments.sequences.read(&catalogue)?;
    let folder = arguments.runs.folder(&arguments.out, "value");
    let kept = Runs::new(&folder, &(catalogue.content_hash(), &way))?;
    let see = |case: &Case| see(&kept, &way, &catalogue, case);
    let seen = arguments.runs.make(&cases, see)?;
    let size = way.grid.container;
    let container_m3 = size.x_m * size.y_m * size.z_m;
    let samples: Vec<Vec<Sample>> = seen
        .iter()
        .map(|seen| samples(seen, container_m3))
        .collect();
    let results = Results::new(arguments, way, &samples)?;
    results.save_methods(&arguments.out.folder("value"))?;
    arguments
        .out
        .publish("value", &results, &results.markdown())
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
    way.method.scene_value = SceneValue {
        weight: arguments.scene_value,
        ..SceneValue::default()
    };
    way
}

/// Packs a sequence, where that was not done before.
fn see(kept: &Runs, way: &Way, catalogue: &Catalogue, case: &Case) -> Outcome<Seen> {
    let Case { number, sequence } = case;
    let is_right = |seen: &Seen| seen.objects == sequence.objects;
    let name = format!("{}-{number:05}", hash(way, 16)?);
    kept.finish(&name, is_right, || {
        let mut notes = Notes::default();
        let (seed, apart) = (u64::from(*number), Apart::default());
        let run = pack(way, catalogue, sequence, seed, &apart, &mut notes)?;
        Ok(Seen {
            objects: sequence.objects.clone(),
            meshes_m3: run.meshes_m3,
            ..notes.seen
        })
    })
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
