//! `ppnpack experiment pareto`: decision time against packed volume, for every way to propose placements.

use clap::Args;
use ppnpack_cli::failure::Outcome;
use ppnpack_cli::network::Backend;
use ppnpack_packing::method::ProposalSource;
use serde_json::json;

use crate::cases::SequenceOptions;
use crate::comparison::{Comparison, ComparisonOptions, GridOption, columns};
use crate::document::Page;
use crate::sheet::Lines;
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
    let mut page: Option<Page> = None;
    let mut grids = Vec::new();
    for option in &arguments.grids {
        let comparison = Comparison::new(&arguments.comparison, backend, option.settings())?;
        let cases = arguments.sequences.read(&comparison.catalogue)?;
        let ways = ways(arguments, &comparison);
        let mut lines = Lines::new("method", comparison.pack("pareto", &ways, &cases)?);
        lines.keep("proposals", ways.iter().map(|way| &way.method.proposals));
        let head = format!(
            "# Decision time against packed volume\n\nSequences {} to {}, the same for every method; SDFM; shares are of the exhaustive \
             search (`all`) on the same grid, in this run.",
            arguments.sequences.first,
            arguments.sequences.last()
        );
        let [key, name] = option.names();
        let page = page.get_or_insert_with(|| comparison.page("pareto", &head));
        page.say(&format!(
            "\n## {name}\n\n{}",
            lines.table("proposals", &columns(true))
        ));
        grids.push(json!({ "name": name, "key": key, "lines": lines }));
    }
    let Some(mut page) = page else {
        return Ok(());
    };
    page.keep("grids", grids);
    page.publish(&arguments.comparison.runs.out)
}

/// The exhaustive search first.
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
