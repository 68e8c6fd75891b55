//! `ppnpack experiment boxes`: the public benchmark of online 3D bin packing.

mod bin;
mod engine;
mod look_ahead;
mod methods;
mod published;
mod results;
mod rules;
mod snug;
mod source;
mod support;
mod surface;

use clap::Args;
use ppnpack_cli::failure::Outcome;
use serde::Serialize;

use crate::document::OutOptions;
use crate::runs::{Runs, RunsOptions};
use methods::{Method, Run};
use results::Results;
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

/// What results depend on.
#[derive(Debug, Serialize)]
struct Settings {
    settings: Vec<Setting>,
    first: u32,
    instances: u32,
    seed: u64,
    rollouts: u32,
}

impl BoxesArguments {
    fn settings(&self) -> Settings {
        Settings {
            settings: self.settings.clone(),
            first: self.first,
            instances: self.instances,
            seed: self.seed,
            rollouts: self.rollouts,
        }
    }
}

impl Settings {
    fn all_instances(&self) -> Vec<Instance> {
        let instance = |number| Instance {
            seed: self.seed,
            number,
        };
        let numbers = self.first..self.first.saturating_add(self.instances);
        numbers.map(instance).collect()
    }
}

pub(crate) fn run(arguments: &BoxesArguments) -> Outcome {
    let settings = arguments.settings();
    let instances = settings.all_instances();
    let together: Vec<&[Instance]> = instances.chunks(KEPT_TOGETHER).collect();
    let folder = arguments.runs.folder(&arguments.out, "boxes");
    let mut packed = Vec::new();
    for setting in &arguments.settings {
        for method in &arguments.methods {
            let rollouts = (*method == Method::LookAhead).then_some(settings.rollouts);
            let of = (setting, method, rollouts, settings.seed);
            let kept = Runs::new(&folder, &of)?;
            let pack = |together: &&[Instance]| {
                let first = together.first().map_or(0, |instance| instance.number);
                let name = format!("{first:06}-{}", together.len());
                let is_whole = |runs: &Vec<Run>| runs.len() == together.len();
                kept.finish(&name, is_whole, || {
                    let mut player = method.player(*setting, settings.rollouts as usize)?;
                    let runs = together
                        .iter()
                        .map(|instance| player.play(*setting, instance));
                    runs.collect()
                })
            };
            let runs = arguments.runs.make(&together, pack)?;
            packed.push((*setting, *method, runs.concat()));
        }
    }
    let results = Results::new(&settings, arguments.runs.workers(), &packed);
    arguments.out.publish("boxes", &results, &results.text)
}
