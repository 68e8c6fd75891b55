//! What the methods came to, beside what is published.

use serde::Serialize;

use super::Settings;
use super::look_ahead::{MARGIN, PLACEMENTS};
use super::methods::{Method, Run};
use super::published::{PUBLISHED, Published};
use super::rules::Setting;
use crate::sheet::{Cell, Column, Lines};
use crate::statistics::Mean;

/// A column of this experiment's tables.
type Measured<'a> = Column<'a, Run>;

/// All that was found.
#[derive(Debug, Serialize)]
pub(super) struct Results<'a> {
    settings: &'a Settings,
    workers: usize,
    lines: Lines<Run>,
    /// Of others.
    published: Vec<Published>,
    #[serde(skip)]
    pub(super) text: String,
}

fn columns() -> [Measured<'static>; 6] {
    [
        Measured::mean(
            "utilisation_percent",
            "utilisation (%)",
            1,
            Run::utilisation_percent,
        ),
        Measured::new("utilisation_variance", "", |runs: &[Run], _| {
            let mean = Mean::of(runs.iter().map(Run::utilisation_percent)).mean;
            let squares = runs
                .iter()
                .map(|run| (run.utilisation_percent() - mean).powi(2));
            Cell::mean(Mean::of(squares), 1)
        })
        .shown_if(false),
        Measured::mean("boxes", "boxes", 1, |run| run.placed.len() as f64),
        Measured::time("decision_median_s", "decision, median", (0.5, 3), |run| {
            &run.decision_s
        }),
        Measured::time("decision_longest_s", "decision, longest", (1.0, 1), |run| {
            &run.decision_s
        }),
        Measured::sum("decisions", "", |run: &Run| run.decision_s.len()).shown_if(false),
    ]
}

impl<'a> Results<'a> {
    /// Of the runs of each method in each setting.
    pub(super) fn new(
        settings: &'a Settings,
        workers: usize,
        packed: &[(Setting, Method, Vec<Run>)],
    ) -> Self {
        let mut text = format!(
            "# Online box packing\n\n\
             A bin of 10 x 10 x 10, boxes with whole sides drawn uniformly from 1 to 5, one known at a time; an episode ends \
             with the first box that fits nowhere. {} instances from {} on, seed {}; means with 95 % confidence \
             intervals. {workers} at once.\n\n\
             Rows in italics are of others, on other draws of the same distribution.\n",
            settings.instances, settings.first, settings.seed,
        );
        let mut lines = Lines::new("name", Vec::new());
        for setting in &settings.settings {
            let of_setting = packed.iter().filter(|(of, ..)| of == setting);
            let methods = of_setting.clone().map(|(_, method, _)| method);
            let runs = of_setting.clone();
            let runs = runs.map(|(_, method, runs)| (method.name().to_owned(), runs.clone()));
            let mut table = Lines::new("name", runs.collect());
            table.keep("method", methods);
            table.keep("setting", std::iter::repeat(setting));
            text += &format!(
                "\n## Setting {}: {}\n\n{}",
                setting.number(),
                setting.in_words(),
                table.table("method", &columns())
            );
            let published = PUBLISHED.iter().filter(|one| one.setting == *setting);
            text.extend(published.map(Published::row));
            lines.append(table);
        }
        let asked = |published: &&Published| settings.settings.contains(&published.setting);
        Self {
            settings,
            workers,
            lines,
            published: PUBLISHED.iter().filter(asked).copied().collect(),
            text: text + &explanation(settings),
        }
    }
}

/// What is compared.
fn explanation(settings: &Settings) -> String {
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
        settings.rollouts,
    )
}
