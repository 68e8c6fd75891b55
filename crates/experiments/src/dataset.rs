//! `ppnpack dataset`: training data for placement proposal networks.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_catalogue::shape_class::ShapeClass;
use ppnpack_dataset::{
    Dataset, DatasetError, DatasetWriter, Drawn, Expert, ExpertSettings, FORMAT_VERSION, Recorder,
    SequenceRecord, Settings, Split, draw,
};
use ppnpack_packing::kernel::objective::Weights;
use ppnpack_packing::planning::method::{Method, ProposalSource, Stability};
use serde_json::{Value, json};

use crate::apart::Apart;
use crate::packer::{Packer, sdfm};
use crate::way::Way;
use crate::workers;
use ppnpack_cli::failure::{Failure, OrInput, OrRun, Outcome};
use ppnpack_cli::options::{
    CatalogueOptions, Choice, Conditions, GridOptions, PhysicsOptions, Simulated, one_of,
};
use ppnpack_cli::output::{print_json, print_line};
use ppnpack_cli::sequence::{Sequence, SequenceFile};

/// The stability test that placements must pass.
const STABILITY: Stability = Stability::Published;

const SHAPES: [Choice<ShapeClass>; 2] = [
    (
        "regular",
        ShapeClass::Regular,
        "objects that fill at least half of their bounding box",
    ),
    ("irregular", ShapeClass::Irregular, "all others"),
];

/// Packs random sequences with the exhaustive SDF minimisation and records, for every item of the
/// buffer at every step, which placements are the best. A killed run goes on where it was when the
/// command is repeated.
#[derive(Debug, Args)]
pub struct DatasetArguments {
    #[command(flatten)]
    catalogue: CatalogueOptions,

    /// Draw from the objects of one class alone, as table 2 does [default: from all]
    #[arg(long, value_parser = one_of(&SHAPES))]
    shapes: Option<ShapeClass>,

    /// How many sequences; what a folder has of them is kept
    #[arg(long, value_name = "COUNT", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    sequences: u32,

    /// How many objects a sequence has, drawn at random
    #[arg(long, value_name = "COUNT", default_value_t = 80, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    length: u32,

    /// A .npy file of sequences, int64 [sequences, length], that must not be drawn: those of a test
    #[arg(long, value_name = "FILE")]
    never: Option<PathBuf>,

    /// Record the value of every placement too, which a regression loss needs
    #[arg(long)]
    values: bool,

    #[command(flatten)]
    grid: GridOptions,

    #[command(flatten)]
    physics: PhysicsOptions,

    /// How many items the expert may choose among
    #[arg(long, value_name = "COUNT", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    buffer: u32,

    /// The seed of everything that is random
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    seed: u64,

    /// Sequences packed at once [default: one per core]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..=1024))]
    workers: Option<u32>,

    /// Folder of the dataset
    #[arg(long, value_name = "DIR", default_value = "out/dataset")]
    out: PathBuf,

    /// First sequence of --cases
    #[arg(long, value_name = "NUMBER", default_value_t = 0, requires = "cases")]
    first: u32,

    /// Play so many of all sequences alone; the same command without this, in a folder with the
    /// files of all, makes the dataset
    #[arg(long, value_name = "COUNT")]
    cases: Option<u32>,

    /// Print a summary as JSON instead of a line
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &DatasetArguments) -> Outcome {
    let grid = arguments.grid.grid(Conditions::Reference)?;
    let (physics, seed) = (&arguments.physics, arguments.seed);
    let simulated = physics.simulated(&grid, seed, Conditions::Reference)?;
    let catalogue = arguments.catalogue.load(grid.resolution())?;
    let catalogue = match arguments.shapes {
        Some(class) => catalogue.of_class(class),
        None => catalogue,
    };
    let settings = settings(arguments, &catalogue, &simulated)?;
    refuse_known(arguments, &catalogue, &settings)?;
    let writer = DatasetWriter::open(&arguments.out, settings.clone(), catalogue.items())
        .map_err(of_folder)?;
    let workers = arguments.workers.map(|workers| workers as usize);
    let workers = workers.unwrap_or_else(workers::default_count);
    let (expert, buffer) = (&settings.expert, arguments.buffer as usize);
    let packer = Packer {
        way: Way {
            grid: arguments.grid.settings(Conditions::Reference),
            poses: arguments.catalogue.settings().poses,
            set_aside: 0,
            method: Method {
                weights: Some(expert.weights),
                ..sdfm(ProposalSource::All, STABILITY, buffer, 0)
            },
            ..Way::default()
        },
        grid,
        catalogue: Arc::new(catalogue),
        simulated,
        apart: Apart::default(),
        network: None,
    };
    let add = |sequence: &u32| writer.add(&play(*sequence, &packer, &settings)?).or_run();
    let mut missing = writer.missing();
    if let Some(cases) = arguments.cases {
        let range = arguments.first..arguments.first.saturating_add(cases);
        missing.retain(|sequence| range.contains(sequence));
    }
    workers::map("Playing sequences", &missing, workers, add)?;
    if arguments.cases.is_some() {
        let played = missing.len();
        let words = format!(
            "{played} sequences were played; the same command without --cases makes the dataset"
        );
        return say(arguments, &json!({ "played": played }), &words);
    }
    print(arguments, &writer.finish().or_run()?)
}

fn settings(
    arguments: &DatasetArguments,
    catalogue: &Catalogue,
    simulated: &Simulated,
) -> Outcome<Settings> {
    let method = Method::published();
    Ok(Settings {
        format_version: FORMAT_VERSION,
        package_version: env!("CARGO_PKG_VERSION").to_owned(),
        catalogue_hash: catalogue.content_hash(),
        objects: u32::try_from(catalogue.len()).or_input()?,
        grid: arguments.grid.grid(Conditions::Reference)?,
        expert: ExpertSettings {
            heuristic: method.heuristic,
            order: method.order,
            weights: Weights::default(),
            stability: serde_json::from_value(serde_json::to_value(STABILITY).or_run()?)
                .or_run()?,
            buffer: arguments.buffer,
        },
        cell: serde_json::to_value(simulated).or_run()?,
        seed: arguments.seed,
        length: arguments.length,
        has_values: arguments.values,
        sequences: arguments.sequences,
    })
}

/// Wrong use of the folder is an input's fault; that it cannot be written is not.
fn of_folder(error: DatasetError) -> Failure {
    match error {
        DatasetError::Write(_) | DatasetError::Read { .. } => Failure::Run(error.into()),
        _ => Failure::Input(error.into()),
    }
}

/// Refuses a seed that draws a sequence of `--never`, or one that begins as such a sequence does.
fn refuse_known(
    arguments: &DatasetArguments,
    catalogue: &Catalogue,
    settings: &Settings,
) -> Outcome {
    let Some(path) = &arguments.never else {
        return Ok(());
    };
    let known = beginnings(&SequenceFile::read(path, catalogue)?, settings)?;
    // All sequences of a file have one length.
    let length = known.keys().next().map_or(0, Vec::len);
    for sequence in 0..arguments.sequences {
        let mut objects = objects(&drawn(settings, sequence));
        objects.truncate(length);
        if let Some(number) = known.get(&objects) {
            return Err(Failure::input(format_args!(
                "--seed {}: sequence {sequence} is sequence {number} of {}; choose another seed",
                settings.seed,
                path.display()
            )));
        }
    }
    Ok(())
}

/// The numbers of a file's sequences by their beginnings, at most as long as a drawn sequence.
fn beginnings(file: &SequenceFile, settings: &Settings) -> Outcome<HashMap<Vec<usize>, usize>> {
    let mut beginnings = HashMap::new();
    for number in 0..file.count() {
        let mut objects = file.get(number)?.objects;
        objects.truncate(settings.length as usize);
        if !objects.is_empty() {
            beginnings.entry(objects).or_insert(number);
        }
    }
    Ok(beginnings)
}

fn drawn(settings: &Settings, sequence: u32) -> Drawn {
    draw(settings.seed, sequence, settings.length, settings.objects)
}

fn objects(drawn: &Drawn) -> Vec<usize> {
    let objects = drawn.objects.iter();
    objects.map(|object| *object as usize).collect()
}

fn play(sequence: u32, packer: &Packer<'_>, settings: &Settings) -> Outcome<SequenceRecord> {
    let drawn = drawn(settings, sequence);
    let played = Sequence {
        from: format!("sequence {sequence} of seed {}", settings.seed),
        objects: objects(&drawn),
    };
    let method = Method {
        seed: drawn.seed,
        ..packer.way.method.clone()
    };
    let (search, checks) = (method.search_settings(), method.stability.checks());
    let labeller = Expert::new(&settings.grid, &search, checks, settings.has_values);
    let mut recorder = Recorder::new(labeller.or_input()?, sequence, drawn.objects);
    packer.play(&played, drawn.seed, &mut recorder)?;
    recorder
        .finish()
        .map_err(|error| Failure::Run(anyhow::anyhow!("sequence {sequence}: {error}")))
}

/// Prints what came of a folder, as JSON or in words.
fn say(arguments: &DatasetArguments, figures: &Value, words: &str) -> Outcome {
    let folder = arguments.out.display();
    match arguments.json {
        true => Ok(print_json(figures)?),
        false => Ok(print_line(&format!("{folder}: {words}"))?),
    }
}

fn print(arguments: &DatasetArguments, dataset: &Dataset) -> Outcome {
    let load = |split| dataset.load(split, false, &|_, _| {}).or_run();
    let (mut steps, mut candidates) = (0, 0);
    for step in load(Split::Train)?.iter().chain(&load(Split::Test)?) {
        steps += 1;
        candidates += step.candidates.len();
    }
    let (sequences, hash) = (arguments.sequences, dataset.hash());
    let figures = json!({
        "hash": hash,
        "sequences": sequences,
        "steps": steps,
        "candidates": candidates,
    });
    let words =
        format!("{sequences} sequences, {steps} steps, {candidates} candidates, hash {hash}");
    say(arguments, &figures, &words)
}
