//! How a packing went, in words.

use super::summary::{EndingSummary, Unplaceable};
use super::table::percent;
use super::{Packing, Settled, Summary};

/// So many items are named of each kind at most.
const MOST_NAMES: usize = 4;

/// What a packing came to.
#[derive(Debug, Clone)]
struct Answer<'a> {
    /// How many items lie in the container, and how many there were to pack.
    packed: usize,
    in_sequence: usize,
    /// The share of the container's volume that they fill.
    utilisation: f64,
    ending: &'a EndingSummary,
    toppled: Vec<&'a str>,
    slid: Vec<&'a str>,
    fell_out: Vec<&'a str>,
    placed: usize,
}

/// How many items are packed, how full the container is, why it ended, and what did not stay: in one sentence.
pub(super) fn answer(packing: &Packing, summary: &Summary) -> String {
    let unsteady = |is_so: fn(&Settled) -> bool| -> Vec<&str> {
        let steps = packing.steps.iter().zip(&packing.settled);
        let steps = steps.filter(|(_, settled)| settled.is_unsteady() && is_so(settled));
        steps
            .map(|(step, _)| step.candidate.item.name().as_ref())
            .collect()
    };
    let answer = Answer {
        packed: summary.metrics.packed.items,
        in_sequence: summary.items_in_sequence,
        utilisation: summary.metrics.utilisation,
        ending: &summary.ending,
        toppled: unsteady(|settled| settled.inside && settled.toppled),
        slid: unsteady(|settled| settled.inside && !settled.toppled),
        fell_out: unsteady(|settled| !settled.inside),
        placed: summary.items_placed,
    };
    answer.in_one_sentence()
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

impl Answer<'_> {
    fn in_one_sentence(&self) -> String {
        let Self {
            packed,
            in_sequence,
            ..
        } = self;
        format!(
            "{packed} of {} {} packed and the container is {} full; {}; {}.",
            items(*in_sequence),
            if *packed == 1 { "is" } else { "are" },
            percent(self.utilisation),
            self.ended(),
            self.steadiness()
        )
    }

    fn ended(&self) -> String {
        match self.ending {
            EndingSummary::AllPacked => "it ended with everything placed".to_owned(),
            EndingSummary::OthersSetAside => {
                "it ended with everything placed but what was set aside".to_owned()
            }
            EndingSummary::NothingFits { items } => nothing_fits(items),
        }
    }

    fn steadiness(&self) -> String {
        let kinds = [
            (&self.toppled, "toppled"),
            (&self.slid, "slid by more than 2 cm"),
            (&self.fell_out, "fell out"),
        ];
        let some = kinds.into_iter().filter(|(names, _)| !names.is_empty());
        let told: Vec<String> = some
            .map(|(names, what)| format!("{} {what}", listed(names)))
            .collect();
        match (self.placed, told.is_empty()) {
            (0, _) => "nothing was placed".to_owned(),
            (_, true) => "every item stayed where it was placed".to_owned(),
            (_, false) => told.join(", "),
        }
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

fn nothing_fits(left: &[Unplaceable]) -> String {
    let reasons = left.iter().map(|item| item.reason.as_str());
    let same = |reason: &str| left.iter().filter(|item| item.reason == reason).count();
    let most = reasons.max_by_key(|reason| same(reason));
    match (left, most) {
        ([], _) | (_, None) => "it ended as no item that waited had a place".to_owned(),
        ([item], Some(reason)) => format!(
            "it ended as {}, the last that waited, had no place ({reason})",
            item.item
        ),
        (several, Some(most)) => format!(
            "it ended as none of the {} that waited had a place (mostly: {most})",
            items(several.len())
        ),
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

    fn answer(ending: &EndingSummary) -> Answer<'_> {
        Answer {
            packed: 7,
            in_sequence: 12,
            utilisation: 0.3152,
            ending,
            toppled: Vec::new(),
            slid: Vec::new(),
            fell_out: Vec::new(),
            placed: 8,
        }
    }

    #[test]
    fn one_sentence_says_how_many_how_full_why_and_what_stayed() {
        assert_eq!(
            answer(&EndingSummary::AllPacked).in_one_sentence(),
            "7 of 12 items are packed and the container is 31.5 % full; it ended with everything placed; every item stayed \
             where it was placed."
        );
        let left = |item: &str, reason: &str| Unplaceable {
            arrival: 8,
            item: item.to_owned(),
            reason: reason.to_owned(),
        };
        let items = vec![left("mug", "too large"), left("bowl", "too large")];
        let ending = EndingSummary::NothingFits { items };
        let unsteady = Answer {
            toppled: vec!["a", "b", "c", "d", "e", "f"],
            slid: vec!["g", "h"],
            fell_out: vec!["i"],
            ..answer(&ending)
        };
        let sentence = unsteady.in_one_sentence();
        let parts = [
            "none of the 2 items that waited had a place (mostly: too large)",
            "a, b, c, d and 2 more toppled, g and h slid by more than 2 cm, i fell out.",
        ];
        for part in parts {
            assert!(sentence.contains(part), "{part}: {sentence}");
        }
    }

    #[test]
    fn where_nothing_was_placed_nothing_stayed() {
        let items = vec![Unplaceable {
            arrival: 0,
            item: "mug".to_owned(),
            reason: "too large".to_owned(),
        }];
        let ending = EndingSummary::NothingFits { items };
        let nothing = Answer {
            packed: 0,
            placed: 0,
            ..answer(&ending)
        };
        let sentence = nothing.in_one_sentence();
        assert!(sentence.ends_with("; nothing was placed."), "{sentence}");
        assert!(
            sentence.contains("as mug, the last that waited"),
            "{sentence}"
        );
    }
}
