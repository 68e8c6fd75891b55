//! `ppnpack experiment boxes`: the public benchmark of online 3D bin packing.

mod bin;
mod engine;
mod look_ahead;
mod methods;
mod rules;
mod snug;
mod source;
mod support;
mod surface;

use clap::Args;
use ppnpack_cli::failure::Outcome;

use crate::document::{OutOptions, Page};
use crate::runs::RunsOptions;
use crate::sheet::{Cell, Column, Lines};
use crate::statistics::Mean;
use look_ahead::{MARGIN, PLACEMENTS};
use methods::{Method, Run};
use rules::Setting;
use source::Instance;

/// A column of this experiment's tables.
type Measured = Column<'static, Run>;

/// How many instances are a run, which is kept in a file.
const KEPT_TOGETHER: usize = 20;

/// Packs boxes into a bin of 10 x 10 x 10 one by one, as others do.
#[derive(Debug, Args)]
pub(crate) struct BoxesArguments {
    /// The first instance
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    first: u32,

    /// How many instances
    #[arg(long, value_name = "COUNT", default_value_t = 2000, value_parser = clap::value_parser!(u32).range(1..))]
    instances: u32,

    /// The benchmark's settings: 1 has a stability rule and two orientations, 2 six orientations alone
    #[arg(
        long,
        value_enum,
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "1,2"
    )]
    settings: Vec<Setting>,

    /// The methods to compare
    #[arg(
        long,
        value_enum,
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "dbl,hm,sdfm,mta,snug,look-ahead"
    )]
    methods: Vec<Method>,

    /// About how many roll-outs a decision of the look-ahead has
    #[arg(long, value_name = "COUNT", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..))]
    rollouts: u32,

    /// The seed of the boxes and the futures
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    seed: u64,

    #[command(flatten)]
    runs: RunsOptions,

    #[command(flatten)]
    out: OutOptions,
}

pub(crate) fn run(arguments: &BoxesArguments) -> Outcome {
    let mut page = Page::new(
        "boxes",
        format!(
            "# Online box packing\n\n\
             A bin of 10 x 10 x 10, boxes with whole sides drawn uniformly from 1 to 5, one known at a time; an episode ends \
             with the first box that fits nowhere. {} instances from {} on, seed {}; means with 95 % confidence \
             intervals. {} at once.\n\n\
             Rows in italics are of others, on other draws of the same distribution.\n",
            arguments.instances,
            arguments.first,
            arguments.seed,
            arguments.runs.workers(),
        ),
    );
    let mut lines = Lines::new("name", Vec::new());
    for setting in &arguments.settings {
        let runs = |method: &Method| {
            Ok((
                method.name().to_owned(),
                packed(arguments, *setting, *method)?,
            ))
        };
        let runs = arguments.methods.iter().map(runs).collect::<Outcome<_>>()?;
        let mut table = Lines::new("name", runs);
        table.keep("method", &arguments.methods);
        table.keep("setting", std::iter::repeat(setting));
        page.say(&format!(
            "\n## Setting {}\n\n{}",
            setting.in_words(),
            table.table("method", &columns())
        ));
        for (_, name, percent, boxes) in PUBLISHED.iter().filter(|of| of.0 == *setting) {
            page.say(&format!("| {name} | {percent:.1} | {boxes} | | |\n"));
        }
        lines.append(table);
    }
    page.say(&explanation(arguments.rollouts));
    page.keep("first", arguments.first);
    page.keep("instances", arguments.instances);
    page.keep("seed", arguments.seed);
    page.keep("rollouts", arguments.rollouts);
    page.keep("workers", arguments.runs.workers());
    page.keep("lines", lines);
    page.publish(&arguments.out)
}

/// All instances, packed by a method.
fn packed(arguments: &BoxesArguments, setting: Setting, method: Method) -> Outcome<Vec<Run>> {
    let numbers = arguments.first..arguments.first.saturating_add(arguments.instances);
    let instances = numbers.map(|number| Instance {
        seed: arguments.seed,
        number,
    });
    let instances: Vec<Instance> = instances.collect();
    let together: Vec<&[Instance]> = instances.chunks(KEPT_TOGETHER).collect();
    let rollouts = (method == Method::LookAhead).then_some(arguments.rollouts);
    let runs = arguments.runs.make(
        &arguments.runs.folder(&arguments.out, "boxes"),
        &(setting, method, rollouts, arguments.seed),
        &together,
        |together| {
            let first = together.first().map_or(0, |instance| instance.number);
            format!("{first:06}-{}", together.len())
        },
        |together, runs: &Vec<Run>| runs.len() == together.len(),
        |together| {
            let mut player = method.player(setting, arguments.rollouts as usize)?;
            let instances = together.iter();
            instances
                .map(|instance| methods::play(&mut player, setting, instance))
                .collect()
        },
    )?;
    Ok(runs.concat())
}

fn columns() -> Vec<Measured> {
    vec![
        Measured::mean(
            "utilisation_percent",
            "utilisation (%)",
            1,
            Run::utilisation_percent,
        ),
        Measured::new("utilisation_variance", "", |runs: &[Run]| {
            let values = || runs.iter().map(Run::utilisation_percent);
            let mean = Mean::of(values()).mean;
            Cell::mean(Mean::of(values().map(|value| (value - mean).powi(2))), 1)
        })
        .hidden(),
        Measured::mean("boxes", "boxes", 1, |run| run.placed.len() as f64),
        Measured::time("decision_median_s", "decision, median", (0.5, 3), |run| {
            &run.decision_s
        }),
        Measured::time("decision_longest_s", "decision, longest", (1.0, 1), |run| {
            &run.decision_s
        }),
        Measured::sum("decisions", "", |run: &Run| run.decision_s.len()).hidden(),
    ]
}

/// Figures of others: the setting, whose, utilisation in percent, boxes where they are told. The reference environment is the published
/// code of PCT, whose heuristics were run as they are: 60 to 300 episodes. PCT: Zhao, Yu and Xu, *Learning Efficient Online 3D Bin
/// Packing on Packing Configuration Trees*, ICLR 2022, 2,000 instances.
const PUBLISHED: [(Setting, &str, f64, &str); 14] = {
    use Setting::{Free, Stable};
    [
        (Stable, "*PCT & EV*, PCT, ICLR 2022, Table 2", 76.0, "29.4"),
        (
            Stable,
            "*PCT & EMS*, PCT, ICLR 2022, Table 1 as others quote it",
            75.8,
            "",
        ),
        (Stable, "*DBL*, reference environment's own", 59.8, ""),
        (Stable, "*HM*, reference environment's own", 57.8, ""),
        (Stable, "*LSAH*, reference environment's own", 52.6, ""),
        (Stable, "*OnlineBPH*, reference environment's own", 50.2, ""),
        (Stable, "*BR*, reference environment's own", 49.3, ""),
        (
            Free,
            "*PCT & EMS*, PCT, ICLR 2022, Table 1 as others quote it",
            86.0,
            "",
        ),
        (Free, "*PCT & EV*, PCT, ICLR 2022, Table 2", 85.3, "32.8"),
        (Free, "*DBL*, reference environment's own", 69.7, ""),
        (Free, "*LSAH*, reference environment's own", 64.3, ""),
        (Free, "*HM*, reference environment's own", 63.8, ""),
        (Free, "*OnlineBPH*, reference environment's own", 59.6, ""),
        (Free, "*BR*, reference environment's own", 57.1, ""),
    ]
};

/// What is compared.
fn explanation(rollouts: u32) -> String {
    format!(
        "\n## What is compared\n\n\
             - *Stability (setting 1).* All boxes have one density. Whenever a box is placed, the load of every box in the bin is \
             found anew: its own weight and what rests on it. That has to act inside the convex hull of the cells that the box \
             rests on; what is passed on is spread over them as that of a stiff body on soft ground. The paper's environment \
             follows loads down a stacking tree (Zhao et al., *Learning Practically Feasible Policies for Online 3D Bin Packing*, \
             2022). Both forbid boxes that topple or tip others; how loads are spread over more than two boxes below differs, as \
             may what happens right on an edge, where a box topples here.\n\
             - *DBL, HM, SDFM, MTA* are the packing engine's, with the weights that the project has for one pose in setting 1 and \
             for several in setting 2. *snug* is this experiment's: it lays a box low, \
             with little volume lost below it, many faces that touch boxes or walls at its sides, and its top level with those \
             beside it or at the rim. Its weights were found by hill climbing on sequences of another generator, by the rule \
             that each box stands by itself.\n\
             - *look-ahead* follows the {PLACEMENTS} best placements by snug to the end of the episode by roll-outs of it, all through the \
             same futures drawn from the known distribution, about {rollouts} roll-outs a decision by sequential halving. The \
             policy's own choice is left only where another one packs more by {MARGIN} standard errors of the mean difference.\n\
             - The boxes and the futures are different streams of one generator.\n",
    )
}
