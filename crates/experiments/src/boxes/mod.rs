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
use serde_json::json;

use crate::runs::RunsOptions;
use methods::{Method, Run};
use rules::Setting;
use source::Instance;

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

    /// The benchmark's settings: 1 has a stability rule and two orientations, 2 just six
    /// orientations
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
    let numbers = arguments.first..arguments.first.saturating_add(arguments.instances);
    let seed = arguments.seed;
    let instances = numbers.map(|number| Instance { seed, number });
    let instances: Vec<Instance> = instances.collect();
    let together: Vec<&[Instance]> = instances.chunks(KEPT_TOGETHER).collect();
    let mut lines = Vec::new();
    for setting in &arguments.settings {
        for method in &arguments.methods {
            let folder = pack(arguments, *setting, *method, &together)?;
            lines.push(json!({ "setting": setting, "method": method, "folder": folder }));
        }
    }
    let results = json!({
        "first": arguments.first,
        "instances": arguments.instances,
        "seed": seed,
        "rollouts": arguments.rollouts,
        "runs": together.iter().map(name).collect::<Vec<_>>(),
        "lines": lines,
    });
    arguments.runs.publish("boxes", results, "boxes")
}

fn name(together: &&[Instance]) -> String {
    let first = together.first().map_or(0, |instance| instance.number);
    format!("{first:06}-{}", together.len())
}

fn pack(
    arguments: &BoxesArguments,
    setting: Setting,
    method: Method,
    together: &[&[Instance]],
) -> Outcome<String> {
    let rollouts = (method == Method::LookAhead).then_some(arguments.rollouts);
    let settings = (setting, method, rollouts, arguments.seed);
    let runs = arguments.runs.kept("boxes", &settings)?;
    runs.make(
        together,
        name,
        |together, runs: &Vec<Run>| runs.len() == together.len(),
        |together| {
            let mut player = method.player(setting, arguments.rollouts as usize)?;
            let instances = together.iter();
            instances
                .map(|instance| methods::play(&mut player, setting, instance))
                .collect()
        },
    )?;
    Ok(runs.name())
}
