//! How a packing went, in words.

use super::summary::{EndingSummary, Unplaceable};
use super::table::percent;
use super::{Packing, Summary};

/// How full the container is, how steadily the items lie, and why it ended.
pub(super) fn in_words(packing: &Packing, summary: &Summary) -> String {
    let (placed, unsteady) = (summary.items_placed, summary.items_unsteady);
    let full = format!(
        "The container is {} full, by the volume of the {} that lie in it.",
        percent(summary.metrics.utilisation),
        items(summary.metrics.packed.items)
    );
    let steady = match (placed, unsteady) {
        (0, _) => "Nothing was placed.".to_owned(),
        (_, 0) => "Every item stayed where it was placed.".to_owned(),
        _ => format!(
            "Of {placed} placed, {unsteady} toppled, slid by more than 2 cm or fell out as {} let go.",
            if unsteady == 1 { "it was" } else { "they were" }
        ),
    };
    let ended = match &summary.ending {
        EndingSummary::AllPacked => "It ended with everything packed.".to_owned(),
        EndingSummary::OthersSetAside => {
            "It ended with everything packed but what was set aside.".to_owned()
        }
        EndingSummary::NothingFits { items: left } => nothing_fits(left),
        EndingSummary::Closed { why } => format!("It was closed: {why}."),
    };
    let aside = match (packing.settings.set_aside, summary.set_aside.len()) {
        (0, _) | (_, 0) => String::new(),
        (most, count) => format!(
            " {} that had no place before, of at most {most}, {} set aside for the next container.",
            items(count),
            if count == 1 { "was" } else { "were" }
        ),
    };
    format!("{full} {steady} {ended}{aside}")
}

fn nothing_fits(left: &[Unplaceable]) -> String {
    let reasons = left.iter().map(|item| item.reason.as_str());
    let same = |reason: &str| left.iter().filter(|item| item.reason == reason).count();
    let most = reasons.max_by_key(|reason| same(reason));
    match (left.len(), most) {
        (0, _) | (_, None) => "It ended as no item that waited had a place.".to_owned(),
        (count, Some(most)) => format!(
            "It ended as none of the {} that waited had a place; the most frequent reason: {most}.",
            items(count)
        ),
    }
}

fn items(count: usize) -> String {
    match count {
        1 => "1 item".to_owned(),
        count => format!("{count} items"),
    }
}
