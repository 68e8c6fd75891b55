//! What the methods came to.

use ppnpack_chart::{PointSeries, Scatter};
use serde::Serialize;

use super::apart::{Apart, Physics};
use super::{FillingArguments, Run, Way};
use crate::comparison::{WIDENED, point};
use crate::statistics::{Mean, percentage, quantiles};

/// All that was found.
#[derive(Debug, Serialize)]
pub(super) struct Results<'a> {
    #[serde(skip)]
    title: &'static str,
    workers: usize,
    first_case: u32,
    cases: u32,
    ways: &'a [Way],
    pub(super) tables: Vec<Table>,
}

/// All methods in one kind of cell.
#[derive(Debug, Serialize)]
pub(super) struct Table {
    #[serde(skip)]
    cell: &'static str,
    apart: Apart,
    lines: Vec<Line>,
}

#[derive(Debug, Serialize)]
struct Line {
    name: String,
    items: Mean,
    meshes_cm3: Mean,
    /// To the first method, sequence by sequence.
    difference_cm3: Mean,
    difference_percent: f64,
    unsteady_percent: f64,
    placed: usize,
    unsteady: usize,
    set_aside: Mean,
    in_other_pose_percent: f64,
    /// Searched exhaustively, as none of their proposals was valid.
    steps_widened: usize,
    /// Half of the decisions, and 95 % of them, take no longer.
    decision_median_s: f64,
    decision_95_s: f64,
}

impl Table {
    pub(super) fn new(physics: Physics, ways: &[Way], runs: &[Vec<Run>]) -> Self {
        let first = runs.first().map_or(&[][..], Vec::as_slice);
        let lines = ways.iter().zip(runs);
        Self {
            cell: physics.cell(),
            apart: physics.apart(),
            lines: lines
                .map(|(way, runs)| Line::new(way, runs, first))
                .collect(),
        }
    }
}

impl Line {
    fn new(way: &Way, runs: &[Run], first: &[Run]) -> Self {
        let mean = |value: &dyn Fn(&Run) -> f64| Mean::of(runs.iter().map(value));
        let sum = |value: fn(&Run) -> usize| runs.iter().map(value).sum::<usize>();
        let cm3 = |run: &Run| run.meshes_m3 * 1e6;
        let pairs = runs.iter().zip(first);
        let difference_cm3 = Mean::of(pairs.map(|(run, first)| cm3(run) - cm3(first)));
        let compared = Mean::of(first.iter().map(cm3));
        let (placed, unsteady) = (sum(|run| run.placed), sum(|run| run.unsteady));
        let decisions = runs.iter().flat_map(|run| run.decision_s.iter().copied());
        let [decision_median_s, decision_95_s] = quantiles(decisions, [0.5, 0.95]);
        Self {
            name: way.name.clone(),
            items: mean(&|run| run.items as f64),
            meshes_cm3: mean(&cm3),
            difference_percent: 100.0 * difference_cm3.mean / compared.mean,
            difference_cm3,
            unsteady_percent: percentage(unsteady, placed),
            placed,
            unsteady,
            set_aside: mean(&|run| run.set_aside as f64),
            in_other_pose_percent: percentage(sum(|run| run.in_other_pose), placed),
            steps_widened: sum(|run| run.steps_widened),
            decision_median_s,
            decision_95_s,
        }
    }
}

impl<'a> Results<'a> {
    pub(super) fn new(title: &'static str, ways: &'a [Way], arguments: &FillingArguments) -> Self {
        Self {
            title,
            workers: arguments.runs.workers(),
            first_case: arguments.sequences.first,
            cases: arguments.sequences.cases,
            ways,
            tables: Vec::new(),
        }
    }

    pub(super) fn markdown(&self) -> String {
        let last = u64::from(self.first_case) + u64::from(self.cases) - 1;
        let mut text = format!(
            "# {}\n\n\
             Sequences {} to {last} in robot conditions: laid down from 1 cm, by an exact \
             scan where no camera is named. *Unsteady* is what toppled by \
             more than 30 degrees, slid by more than 2 cm or left the container when it was placed. Differences are to \
             the first method, sequence by sequence, with 95 % intervals by Student's t. {WIDENED} Decision times are of one step on \
             one thread, {} sequences at once.\n",
            self.title, self.first_case, self.workers
        );
        for table in &self.tables {
            text += &table.markdown();
        }
        text
    }
}

impl Results<'_> {
    /// Volume against the share of what did not stay.
    pub(super) fn steadiness(&self) -> Scatter {
        self.scatter("Unsteady of what was placed (%)", |line| {
            line.unsteady_percent
        })
    }

    /// Volume against the time of a decision.
    pub(super) fn times(&self) -> Scatter {
        self.scatter("Decision, 95 % take no longer (ms)", |line| {
            line.decision_95_s * 1e3
        })
    }

    fn scatter(&self, x_label: &str, x: impl Fn(&Line) -> f64) -> Scatter {
        let point = |line: &Line| {
            let x = Mean {
                mean: x(line),
                half_width: 0.0,
            };
            point(&line.name, &x, &line.meshes_cm3)
        };
        let series = self.tables.iter().map(|table| PointSeries {
            name: table.cell.to_owned(),
            reference: false,
            points: table.lines.iter().map(point).collect(),
        });
        Scatter {
            title: self.title.to_owned(),
            x_label: x_label.to_owned(),
            y_label: "Mesh volume (cm³)".to_owned(),
            series: series.collect(),
        }
    }
}

impl Table {
    fn markdown(&self) -> String {
        let mut text = self.apart.markdown();
        text += "\n| method | items | mesh volume (cm³) | difference (cm³) | | unsteady | set aside | in another pose | \
                 steps widened | decision, median | 95 % |\n|---|---|---|---|---|---|---|---|---|---|---|\n";
        for line in &self.lines {
            text += &format!(
                "| {} | {} | {} | {} | {:+.1} % | {:.1} % ({} of {}) | {:.1} | {:.0} % | {} | {:.1} ms | {:.1} ms |\n",
                line.name,
                line.items.shown(1),
                line.meshes_cm3.shown(0),
                line.difference_cm3.shown(0),
                line.difference_percent,
                line.unsteady_percent,
                line.unsteady,
                line.placed,
                line.set_aside.mean,
                line.in_other_pose_percent,
                line.steps_widened,
                line.decision_median_s * 1e3,
                line.decision_95_s * 1e3
            );
        }
        text
    }
}

impl Apart {
    /// The heading of its table, and how the cell differs from the twin.
    fn markdown(&self) -> String {
        if self.friction == 1.0 {
            return "\n## The cell is as the planner thinks it is\n".to_owned();
        }
        let is_far = self.mass > 1.0;
        let mut text = format!(
            "\n## The cell is {} than the twin\n\nFriction of items and of walls times {:.2} to {:.2}, drawn once a sequence; \
             the poses of what lies there are known with normal errors of {:.0} mm and {:.0} degree per axis",
            if is_far {
                "quite another one"
            } else {
                "another one"
            },
            1.0 / self.friction,
            self.friction,
            self.pose_error.position_m * 1e3,
            self.pose_error.rotation_rad.to_degrees()
        );
        if is_far {
            text += &format!(
                "; the mass of each item times {:.2} to {:.2}; restitution of 0 to {:.1}, drawn once a sequence",
                1.0 / self.mass,
                self.mass,
                self.restitution
            );
        }
        text + ".\n"
    }
}
