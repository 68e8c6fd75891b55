//! How a packing went, in words.

use super::summary::EndingSummary;
use super::table::percent;
use super::{Packing, Settled, Summary};

/// How many items of a kind are named at most.
pub(super) const MOST_NAMES: usize = 4;

/// How many items are packed, how full the container is, why it ended, and what did not stay: in one sentence.
pub(super) fn answer(packing: &Packing, summary: &Summary) -> String {
    let packed = summary.metrics.packed.items;
    format!(
        "{packed} of {} {} packed and the container is {} full; it ended {}; {}.",
        items(summary.items_in_sequence),
        if packed == 1 { "is" } else { "are" },
        percent(summary.metrics.utilisation),
        ended(&summary.ending),
        steadiness(packing)
    )
}

/// What was set aside, where something was.
pub(super) fn aside(packing: &Packing, summary: &Summary) -> Option<String> {
    match (packing.settings.set_aside, summary.set_aside.len()) {
        (0, _) | (_, 0) => None,
        (most, count) => Some(format!(
            "{} that had no place before, of at most {most}, {} set aside for the next container.",
            items(count),
            if count == 1 { "was" } else { "were" }
        )),
    }
}

/// Why it ended, after *it ended*.
fn ended(ending: &EndingSummary) -> String {
    match ending {
        EndingSummary::AllPacked => "with everything placed".to_owned(),
        EndingSummary::OthersSetAside => "with everything placed but what was set aside".to_owned(),
        EndingSummary::NothingFits { items: left } => {
            let same = |reason: &str| left.iter().filter(|item| item.reason == reason).count();
            let reasons = left.iter().map(|item| item.reason.as_str());
            let most = reasons
                .max_by_key(|reason| same(reason))
                .unwrap_or_default();
            match left.as_slice() {
                [item] => format!(
                    "as {}, the last that waited, had no place ({most})",
                    item.item
                ),
                several => format!(
                    "as none of the {} that waited had a place (mostly: {most})",
                    items(several.len())
                ),
            }
        }
    }
}

/// What did not stay where it was placed.
fn steadiness(packing: &Packing) -> String {
    let steps = || packing.steps.iter().zip(&packing.settled);
    let of = |kind: &str| -> Option<String> {
        let those = steps().filter(|(_, settled)| unsteadiness(settled) == Some(kind));
        let names: Vec<&str> = those
            .map(|(step, _)| step.candidate.item.name().as_ref())
            .collect();
        (!names.is_empty()).then(|| format!("{} {kind}", listed(&names)))
    };
    let told: Vec<String> = KINDS.into_iter().filter_map(of).collect();
    match (packing.steps.is_empty(), told.is_empty()) {
        (true, _) => "nothing was placed".to_owned(),
        (_, true) => "every item stayed where it was placed".to_owned(),
        (_, false) => told.join(", "),
    }
}

/// The ways not to stay, in the order in which they are told.
const KINDS: [&str; 3] = ["toppled", "slid by more than 2 cm", "fell out"];

fn unsteadiness(settled: &Settled) -> Option<&'static str> {
    let [toppled, slid, fell_out] = KINDS;
    match settled {
        _ if !settled.is_unsteady() => None,
        Settled { inside: false, .. } => Some(fell_out),
        Settled { toppled: true, .. } => Some(toppled),
        _ => Some(slid),
    }
}

/// Some names, and how many more there are.
fn listed(names: &[&str]) -> String {
    let shown = names.get(..MOST_NAMES).unwrap_or(names);
    match (names.len() - shown.len(), shown.split_last()) {
        (0, Some((last, []))) => (*last).to_owned(),
        (0, Some((last, others))) => format!("{} and {last}", others.join(", ")),
        (more, _) => format!("{} and {more} more", shown.join(", ")),
    }
}

fn items(count: usize) -> String {
    match count {
        1 => "1 item".to_owned(),
        count => format!("{count} items"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::summary::Unplaceable;

    #[test]
    fn names_are_listed_and_the_others_counted() {
        assert_eq!(listed(&["i"]), "i");
        assert_eq!(listed(&["g", "h"]), "g and h");
        assert_eq!(
            listed(&["a", "b", "c", "d", "e", "f"]),
            "a, b, c, d and 2 more"
        );
    }

    #[test]
    fn an_end_has_its_reason() {
        let left = |item: &str, reason: &str| Unplaceable {
            arrival: 8,
            item: item.to_owned(),
            reason: reason.to_owned(),
        };
        let all = [
            left("mug", "too large"),
            left("bowl", "too large"),
            left("bag", "too soft"),
        ];
        let told = |items: &[Unplaceable]| {
            ended(&EndingSummary::NothingFits {
                items: items.to_vec(),
            })
        };
        assert_eq!(
            told(&all),
            "as none of the 3 items that waited had a place (mostly: too large)"
        );
        assert_eq!(
            told(&all[..1]),
            "as mug, the last that waited, had no place (too large)"
        );
    }
}
