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

use crate::document::Page;
use crate::runs::RunsOptions;
use crate::sheet::{Cell, Column, Lines};
use crate::statistics::Mean;
use methods::{Method, Run};
use rules::Setting;
use source::Instance;

/// A column of this experiment's tables.
type Measured = Column<Run>;

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
}

pub(crate) fn run(arguments: &BoxesArguments) -> Outcome {
    let mut page = Page::new(
        "boxes",
        format!(
            "# Online box packing\n\n\
             A bin of 10 x 10 x 10, boxes with whole sides drawn uniformly from 1 to 5, one known at a time; an episode ends \
             with the first box that fits nowhere. {} instances from {} on, seed {}; means with 95 % confidence \
             intervals. {} at once.\n",
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
        lines.append(table);
    }
    page.keep("first", arguments.first);
    page.keep("instances", arguments.instances);
    page.keep("seed", arguments.seed);
    page.keep("rollouts", arguments.rollouts);
    page.keep("workers", arguments.runs.workers());
    page.keep("lines", lines);
    page.publish(&arguments.runs.out)
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
    let settings = (setting, method, rollouts, arguments.seed);
    let runs = arguments.runs.kept("boxes", &settings)?.make(
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
