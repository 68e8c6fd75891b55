//! Accuracy: how often a network has the optimum among its best-scored placements.
//!
//! The answer depends on the question. A network scores every placement, also those that do not
//! fit, and the planner leaves these out before it takes the best-scored ones; the paper's accuracy
//! counts all of them. All questions are asked of every network, so that each figure can be
//! compared with one for the same question.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::settings::LossOver;

/// The shares `K` of the paper's Table III, in percent.
pub const SHARES_PERCENT: [f64; 5] = [1.0, 5.0, 8.0, 10.0, 20.0];

/// Among which placements the optimum is looked for, and what the share `K` is taken of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Question {
    /// Among the placements that fit, as many as `K` % of all placements `|P|`: what the planner
    /// proposes.
    Proposed,
    /// Among all placements, `K` % of `|P|`: the paper's question.
    OverAll,
    /// Among the placements that fit, `K` % of those: the hardest question where few fit.
    AmongFitting,
}

impl Question {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Proposed, Self::OverAll, Self::AmongFitting];

    /// Gives the question that a network was trained for: over all placements where its loss is
    /// over all.
    pub fn of_loss(over: LossOver) -> Self {
        match over {
            LossOver::All => Self::OverAll,
            LossOver::Fitting => Self::Proposed,
        }
    }
}

/// The rank of a candidate's optimum among its placements. Several equal optima count as one: the
/// best-scored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rank {
    /// `|P|`: yaws times the container's cells.
    pub placements: u64,
    /// Placements that fit.
    pub fitting: u64,
    /// Placements other than the optima that are scored at least as well as the optimum.
    pub before: u64,
    /// Placements among those before that fit.
    pub fitting_before: u64,
}

impl Rank {
    /// Whether the optimum is among the best-scored `percent`.
    pub fn is_found(&self, question: Question, percent: f64) -> bool {
        let (before, whole) = match question {
            Question::Proposed => (self.fitting_before, self.placements),
            Question::OverAll => (self.before, self.placements),
            Question::AmongFitting => (self.fitting_before, self.fitting),
        };
        (before as f64) < (whole as f64 * percent / 100.0).ceil()
    }
}

/// How often the optimum was among the best-scored share of the placements.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Accuracy {
    /// `K`, in percent.
    pub percent: f64,
    /// The part of the candidates whose optimum was among them, from 0 to 1.
    pub share: f64,
    /// The standard error of `share`, clustered by sequence, as candidates of one sequence are
    /// alike; none where a single sequence says nothing of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standard_error: Option<f64>,
}

/// Accuracies of a network on one split, by every question.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Accuracies {
    /// Sequences with candidates that have a valid placement.
    pub sequences: usize,
    /// Candidates that have a valid placement; only these are asked about.
    pub candidates: u64,
    /// The part of all placements that fits, from 0 to 1: the mean over the candidates.
    pub fitting_share: f64,
    /// [`Question::Proposed`], by increasing share.
    pub proposed: Vec<Accuracy>,
    /// [`Question::OverAll`], by increasing share.
    pub over_all: Vec<Accuracy>,
    /// [`Question::AmongFitting`], by increasing share.
    pub among_fitting: Vec<Accuracy>,
}

impl Accuracies {
    /// Gives the answers to a question, by increasing share.
    pub fn of(&self, question: Question) -> &[Accuracy] {
        match question {
            Question::Proposed => &self.proposed,
            Question::OverAll => &self.over_all,
            Question::AmongFitting => &self.among_fitting,
        }
    }

    /// Gives the answer that networks are chosen by: that at the smallest share, where they differ
    /// most.
    pub fn decisive(&self, question: Question) -> f64 {
        self.of(question).first().map_or(0.0, |first| first.share)
    }
}

/// Counts ranks by sequence.
#[derive(Debug, Clone, Default)]
pub struct Tally {
    sequences: BTreeMap<u32, Counts>,
}

/// Counts of a sequence.
#[derive(Debug, Clone, Default)]
struct Counts {
    candidates: u64,
    /// The sum of the candidates' shares of placements that fit.
    fitting: f64,
    /// Candidates whose optimum was found, by question, in the order of [`Question::ALL`], and
    /// share.
    found: [[u64; SHARES_PERCENT.len()]; Question::ALL.len()],
}

impl Tally {
    /// Counts a candidate of a sequence.
    pub fn add(&mut self, sequence: u32, rank: &Rank) {
        let counts = self.sequences.entry(sequence).or_default();
        counts.candidates += 1;
        counts.fitting += rank.fitting as f64 / rank.placements.max(1) as f64;
        for (question, found) in Question::ALL.into_iter().zip(&mut counts.found) {
            for (percent, found) in SHARES_PERCENT.into_iter().zip(found) {
                *found += u64::from(rank.is_found(question, percent));
            }
        }
    }

    /// Gives the shares of what was counted.
    pub fn accuracies(&self) -> Accuracies {
        let counts = || self.sequences.values();
        let candidates = counts().map(|counts| counts.candidates).sum();
        let fitting: f64 = counts().map(|counts| counts.fitting).sum();
        Accuracies {
            sequences: self.sequences.len(),
            candidates,
            fitting_share: fitting / (candidates as f64).max(1.0),
            proposed: self.answers(Question::Proposed),
            over_all: self.answers(Question::OverAll),
            among_fitting: self.answers(Question::AmongFitting),
        }
    }

    fn answers(&self, question: Question) -> Vec<Accuracy> {
        let shares = SHARES_PERCENT.into_iter().enumerate();
        let answers = shares.map(|(at, percent)| {
            let found = |counts: &Counts| {
                let found = counts.found.get(question as usize);
                let found = found.and_then(|found| found.get(at));
                (found.copied().unwrap_or(0), counts.candidates)
            };
            let (share, standard_error) = share(self.sequences.values().map(found));
            Accuracy {
                percent,
                share,
                standard_error,
            }
        });
        answers.collect()
    }
}

/// Gives the share of what was found of a total, from pairs of both by sequence, and its standard
/// error by clusters: that of a ratio of two sums over independent sequences (Cochran, Sampling
/// Techniques, 1977, equation 2.46).
fn share(sequences: impl Iterator<Item = (u64, u64)> + Clone) -> (f64, Option<f64>) {
    let clusters = sequences.clone().count() as f64;
    let sums = sequences.clone();
    let (found, total) = sums.fold((0, 0), |sums, (found, total)| {
        (sums.0 + found, sums.1 + total)
    });
    let total = (total as f64).max(1.0);
    let share = found as f64 / total;
    let residuals = sequences.map(|(found, of)| (found as f64 - share * of as f64).powi(2));
    let variance = clusters / (clusters - 1.0) * residuals.sum::<f64>() / (total * total);
    (share, (clusters > 1.0).then(|| variance.sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 1,000 placements, of which 100 fit.
    fn rank(before: u64, fitting_before: u64) -> Rank {
        Rank {
            placements: 1000,
            fitting: 100,
            before,
            fitting_before,
        }
    }

    #[test]
    fn the_questions_differ_in_what_is_ranked_and_of_what_the_share_is() {
        let found = |rank: Rank| Question::ALL.map(|question| rank.is_found(question, 1.0));
        assert_eq!(found(rank(0, 0)), [true, true, true]);
        // 10 placements are 1 % of all, 1 is 1 % of those that fit.
        assert_eq!(found(rank(9, 9)), [true, true, false]);
        assert_eq!(found(rank(10, 9)), [true, false, false]);
        assert_eq!(found(rank(500, 0)), [true, false, true]);
        assert_eq!(found(rank(10, 10)), [false, false, false]);
    }

    #[test]
    fn a_share_is_rounded_up_to_at_least_one_placement() {
        let few = Rank {
            placements: 120,
            fitting: 3,
            before: 1,
            fitting_before: 0,
        };
        assert!(few.is_found(Question::OverAll, 1.0));
        assert!(few.is_found(Question::AmongFitting, 1.0));
    }

    #[test]
    fn the_shares_are_those_of_all_candidates() {
        let mut tally = Tally::default();
        tally.add(3, &rank(0, 0));
        tally.add(3, &rank(30, 5));
        tally.add(9, &rank(999, 99));
        let accuracies = tally.accuracies();
        assert_eq!((accuracies.sequences, accuracies.candidates), (2, 3));
        assert!((accuracies.fitting_share - 0.1).abs() < 1e-12);
        let shares = |question| {
            let answers = accuracies.of(question).iter();
            answers.map(|answer| (answer.share * 3.0).round()).collect()
        };
        let (proposed, over_all): (Vec<f64>, Vec<f64>) =
            (shares(Question::Proposed), shares(Question::OverAll));
        assert_eq!(proposed, [2.0, 2.0, 2.0, 3.0, 3.0]);
        assert_eq!(over_all, [1.0, 2.0, 2.0, 2.0, 2.0]);
        assert!((accuracies.decisive(Question::OverAll) - 1.0 / 3.0).abs() < 1e-12);
        let nothing = Tally::default().accuracies();
        assert_eq!((nothing.candidates, nothing.fitting_share), (0, 0.0));
    }

    #[test]
    fn sequences_of_equal_length_give_the_error_of_their_means() {
        let sequences = [(1, 4), (3, 4), (4, 4), (2, 4)];
        let (share, error) = share(sequences.into_iter());
        let means = sequences.map(|(found, of)| found as f64 / of as f64);
        let squares: f64 = means.iter().map(|mean| (mean - share).powi(2)).sum();
        assert!((share - 0.625).abs() < 1e-12);
        assert!((error.unwrap_or(0.0) - (squares / 3.0 / 4.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn candidates_that_agree_within_a_sequence_count_as_one() {
        // Ten candidates that are all found or all missed say as much as one.
        let (_, alike) = share([(10, 10), (0, 10), (10, 10)].into_iter());
        let (_, single) = share([(1, 1), (0, 1), (1, 1)].into_iter());
        assert!((alike.unwrap_or(0.0) - single.unwrap_or(1.0)).abs() < 1e-12);
        assert_eq!(share(std::iter::once((3, 10))), (0.3, None));
        assert_eq!(share(std::iter::empty()), (0.0, None));
    }
}
