//! `ppnpack experiment pareto`: decision time against volume, for every source of proposals.

use clap::Args;
use ppnpack_cli::failure::Outcome;
use ppnpack_cli::network::Backend;
use ppnpack_packing::planning::method::ProposalSource;
use serde_json::{Value, json};

use crate::cases::SequenceOptions;
use crate::comparison::{Comparison, ComparisonOptions, GridOption};
use crate::results::with;
use crate::way::Way;

/// Packs test sequences on several grids with every source of proposals at several shares K.
#[derive(Debug, Args)]
pub(crate) struct ParetoArguments {
    #[command(flatten)]
    sequences: SequenceOptions<0, 20>,

    /// The grids
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        default_value = "coarse,medium,fine"
    )]
    grids: Vec<GridOption>,

    /// The shares K that are compared, in percent
    #[arg(
        long = "shares",
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "0.25,1,5,20"
    )]
    percents: Vec<f64>,

    #[command(flatten)]
    comparison: ComparisonOptions,
}

pub(crate) fn run(arguments: &ParetoArguments, backend: &dyn Backend) -> Outcome {
    let mut first: Option<Comparison<'_>> = None;
    let mut grids = Vec::new();
    for option in &arguments.grids {
        let comparison = Comparison::new(&arguments.comparison, backend, option.settings())?;
        let cases = arguments.sequences.read(&comparison.catalogue)?;
        let line = |way: Way| {
            let folder = comparison.pack("pareto", &way, &cases)?;
            let proposals = way.method.proposals;
            Ok(json!({ "method": way.name, "proposals": proposals, "folder": folder }))
        };
        let lines = ways(arguments, &comparison).into_iter().map(line);
        let lines: Vec<Value> = lines.collect::<Outcome<_>>()?;
        let [key, name] = option.names();
        grids.push(json!({ "name": name, "key": key, "lines": lines }));
        first.get_or_insert(comparison);
    }
    let Some(comparison) = first else {
        return Ok(());
    };
    let results = json!({ "grids": grids });
    comparison.publish("pareto", with(results, arguments.sequences.said()))
}

fn ways(arguments: &ParetoArguments, comparison: &Comparison<'_>) -> Vec<Way> {
    let percents = || arguments.percents.iter().copied();
    let mut sources = vec![ProposalSource::All, ProposalSource::Bounded];
    sources.extend(percents().filter_map(|percent| comparison.proposals(percent)));
    sources.extend(percents().map(|percent| ProposalSource::Random { percent }));
    let sources = sources.into_iter();
    sources
        .map(|proposals| comparison.way(proposals.to_string(), proposals))
        .collect()
}
