//! What the methods came to, beside what is published.

use serde::Serialize;

use super::Settings;
use super::look_ahead::{MARGIN, PLACEMENTS};
use super::methods::{Method, Run};
use super::published::{PUBLISHED, Published};
use super::rules::Setting;
use crate::statistics::{Mean, quantiles};

/// All that was found.
#[derive(Debug, Serialize)]
pub(super) struct Results<'a> {
    settings: &'a Settings,
    workers: usize,
    lines: Vec<Line>,
    /// Of others.
    published: Vec<Published>,
}

/// One method in one setting.
#[derive(Debug, Serialize)]
struct Line {
    setting: Setting,
    method: Method,
    utilisation_percent: Mean,
    /// The variance over the instances, in percent squared.
    utilisation_variance: f64,
    boxes: Mean,
    decision_median_s: f64,
    decision_longest_s: f64,
    decisions: usize,
}

impl Line {
    fn new(setting: Setting, method: Method, runs: &[Run]) -> Self {
        let utilisation = || runs.iter().map(Run::utilisation_percent);
        let utilisation_percent = Mean::of(utilisation());
        let from_mean = |value: f64| (value - utilisation_percent.mean).powi(2);
        let decisions = runs.iter().flat_map(|run| run.decision_s.iter().copied());
        let [decision_median_s, decision_longest_s] = quantiles(decisions.clone(), [0.5, 1.0]);
        Self {
            setting,
            method,
            utilisation_percent,
            utilisation_variance: Mean::of(utilisation().map(from_mean)).mean,
            boxes: Mean::of(runs.iter().map(|run| run.placed.len() as f64)),
            decision_median_s,
            decision_longest_s,
            decisions: decisions.count(),
        }
    }

    fn row(&self) -> String {
        format!(
            "| {} | {} | {} | {:.3} ms | {:.1} ms |\n",
            self.method.name(),
            self.utilisation_percent.shown(1),
            self.boxes.shown(1),
            self.decision_median_s * 1e3,
            self.decision_longest_s * 1e3,
        )
    }
}

impl<'a> Results<'a> {
    pub(super) fn new(settings: &'a Settings, workers: usize) -> Self {
        let asked = |published: &&Published| settings.settings.contains(&published.setting);
        Self {
            settings,
            workers,
            lines: Vec::new(),
            published: PUBLISHED.iter().filter(asked).copied().collect(),
        }
    }

    pub(super) fn add(&mut self, setting: Setting, method: Method, runs: &[Run]) {
        self.lines.push(Line::new(setting, method, runs));
    }

    pub(super) fn markdown(&self) -> String {
        let settings = self.settings;
        let mut text = format!(
            "# Online box packing\n\n\
             A bin of 10 x 10 x 10, boxes with whole sides drawn uniformly from 1 to 5, one known at a time; an episode ends \
             with the first box that fits nowhere. {} instances from {} on, seed {}; means with 95 % confidence \
             intervals. {} at once.\n\n\
             Rows in italics are of others, on other draws of the same distribution.\n",
            settings.instances, settings.first, settings.seed, self.workers,
        );
        for setting in &settings.settings {
            text += &self.table(*setting);
        }
        text += &self.explanation();
        text
    }

    fn table(&self, setting: Setting) -> String {
        let mut text = format!(
            "\n## Setting {}: {}\n\n\
             | method | utilisation (%) | boxes | decision, median | decision, longest |\n\
             |---|---|---|---|---|\n",
            setting.number(),
            setting.in_words(),
        );
        let lines = self.lines.iter().filter(|line| line.setting == setting);
        let published = self.published.iter();
        let published = published.filter(|published| published.setting == setting);
        text.extend(lines.map(Line::row));
        text.extend(published.map(Published::row));
        text
    }

    fn explanation(&self) -> String {
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
             same futures drawn from the known distribution, about {} roll-outs a decision by sequential halving. The \
             policy's own choice is left only where another one packs more by {MARGIN} standard errors of the mean difference.\n\
             - The boxes and the futures are different streams of one generator.\n",
            self.settings.rollouts,
        )
    }
}
