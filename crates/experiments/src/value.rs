//! `ppnpack experiment value`: the value of what a placement leaves, learned from packings.
//!
//! Packs sequences as usual; notes the figures after each placement, and what was packed until
//! then. `experiments/value.py` learns of these the coefficients of [`SceneValue`].

use clap::Args;
use ppnpack_cli::failure::{Failure, OrInput, Outcome};
use ppnpack_cli::options::{CatalogueOptions, Conditions, GridOptions};
use ppnpack_packing::ranking::scene_value::{FIGURES_OF_ITEMS, SceneValue, Squares, figures};
use ppnpack_packing::ranking::step::StepInput;
use ppnpack_packing::streams::episode::{Observer, Step};
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::apart::Apart;
use crate::cases::{Case, SequenceOptions};
use crate::packer::Packer;
use crate::results::with;
use crate::runs::RunsOptions;
use crate::way::Way;

/// The sequences before this one are the tests': what is learned is measured on them.
const FIRST_FOR_LEARNING: u32 = 100;

/// Packs sequences in robot conditions and notes what placements left, from which
/// `experiments/value.py` learns what that is worth.
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
}

#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct Seen {
    objects: Vec<usize>,
    figures: Vec<Vec<f64>>,
    /// Mesh volume of the item of each step and of all before it.
    packed_m3: Vec<f64>,
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
    let runs = arguments.runs.kept("value", &settings)?;
    runs.make(&cases, Case::name, is_right, see)?;
    let results = json!({
        "way": packer.way,
        "figures_of_items": FIGURES_OF_ITEMS,
        "folder": runs.name(),
    });
    let results = with(results, arguments.sequences.said());
    arguments.runs.publish("value", results, "value")
}

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
