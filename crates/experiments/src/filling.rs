//! `ppnpack experiment filling`: how full containers get, and what topples or slides, under robot conditions.

use std::path::PathBuf;

use clap::Args;
use ppnpack_cli::failure::Outcome;
use ppnpack_cli::options::CatalogueOptions;
use serde_json::json;

use crate::apart::Physics;
use crate::cases::SequenceOptions;
use crate::comparison::WIDENED;
use crate::document::Page;
use crate::packer::{Packer, Run};
use crate::runs::RunsOptions;
use crate::sheet::{Column, Lines};
use crate::way::{self, Way};

/// A column of this experiment's tables.
type Measured = Column<Run>;

/// Packs test sequences in robot conditions with several methods, and compares volume, steadiness and time.
#[derive(Debug, Args)]
pub(crate) struct FillingArguments {
    #[command(flatten)]
    catalogue: CatalogueOptions,

    #[command(flatten)]
    sequences: SequenceOptions<0, 100>,

    /// A JSON file with the methods to compare, such as experiments/filling.json; the first is what the others are compared with, and
    /// results are named by the file
    #[arg(long, value_name = "FILE")]
    methods: PathBuf,

    /// Of them, only this one beside the first; may be given several times
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,

    /// The physics of the cells that are packed in; each has a table of its own
    #[arg(
        long,
        value_enum,
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "own,apart"
    )]
    physics: Vec<Physics>,

    #[command(flatten)]
    runs: RunsOptions,
}

pub(crate) fn run(arguments: &FillingArguments) -> Outcome {
    let ways = way::chosen(&arguments.methods, &arguments.only)?;
    let name = arguments.methods.file_stem().unwrap_or_default();
    let name = &*name.to_string_lossy();
    let (sequences, workers) = (&arguments.sequences, arguments.runs.workers());
    let mut page = Page::new(
        name,
        format!(
            "# How full, how steady\n\n\
             Sequences {} to {} in robot conditions: laid down from 1 cm, by an exact scan where no camera is named. *Unsteady* is what \
             toppled by more than 30 degrees, slid by more than 2 cm or left the container when it was placed. Differences are to \
             the first method, sequence by sequence, with 95 % intervals by Student's t. {WIDENED} Decision times are of one step on \
             one thread, {workers} sequences at once.\n",
            sequences.first,
            sequences.last(),
        ),
    );
    page.keep("workers", workers);
    page.keep("first_case", sequences.first);
    page.keep("cases", sequences.cases);
    page.keep("ways", &ways);
    let mut tables = Vec::new();
    for physics in &arguments.physics {
        let apart = physics.apart();
        let pack = |way: &Way| {
            let packer = Packer::robot(way.clone(), &arguments.catalogue, apart)?;
            let cases = sequences.read(&packer.catalogue)?;
            let runs = packer.pack_all(&cases, 0, &arguments.runs, name)?;
            Ok((way.name.clone(), runs))
        };
        let runs = ways.iter().map(pack).collect::<Outcome<_>>()?;
        let mut lines = Lines::new("name", runs);
        page.say(&format!(
            "{}\n{}",
            apart.in_words(),
            lines.table("method", &columns())
        ));
        tables.push(json!({ "apart": apart, "lines": lines }));
    }
    page.keep("tables", tables);
    page.publish(&arguments.runs.out)
}

fn columns() -> Vec<Measured> {
    vec![
        Measured::mean("items", "items", 1, |run| run.items as f64),
        Measured::mean("meshes_cm3", "mesh volume (cm³)", 0, Run::meshes_cm3),
        Measured::difference("difference_cm3", "difference (cm³)", 0, Run::meshes_cm3),
        Measured::change("difference_percent", Run::meshes_cm3),
        Measured::share("unsteady_percent", "unsteady", |run| {
            [run.unsteady, run.placed]
        }),
        Measured::sum("placed", "", |run| run.placed).hidden(),
        Measured::sum("unsteady", "", |run| run.unsteady).hidden(),
        Measured::mean("set_aside", "set aside", 1, |run| run.set_aside as f64),
        Measured::share("in_other_pose_percent", "in another pose", |run| {
            [run.in_other_pose, run.placed]
        }),
        Measured::sum("steps_widened", "steps widened", |run| run.steps_widened),
        Measured::time("decision_median_s", "decision, median", (0.5, 1), |run| {
            &run.decision_s
        }),
        Measured::time("decision_95_s", "95 %", (0.95, 1), |run| &run.decision_s),
    ]
}
