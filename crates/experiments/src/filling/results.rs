//! What the methods came to.

use ppnpack_chart::Scatter;
use serde::Serialize;

use super::apart::{Apart, Physics};
use super::{FillingArguments, Run, Way};
use crate::comparison::WIDENED;
use crate::sheet::{Column, Lines, scatter};

/// A column of this experiment's tables.
type Measured<'a> = Column<'a, Run>;

const TITLE: &str = "How full, how steady";

/// All that was found.
#[derive(Debug, Serialize)]
pub(super) struct Results<'a> {
    workers: usize,
    first_case: u32,
    cases: u32,
    ways: &'a [Way],
    tables: Vec<Table>,
    #[serde(skip)]
    pub(super) text: String,
}

/// All methods in one kind of cell.
#[derive(Debug, Serialize)]
struct Table {
    #[serde(skip)]
    cell: &'static str,
    apart: Apart,
    lines: Lines<Run>,
}

fn columns() -> [Measured<'static>; 12] {
    let cm3 = |run: &Run| run.meshes_m3 * 1e6;
    [
        Measured::mean("items", "items", 1, |run| run.items as f64),
        Measured::mean("meshes_cm3", "mesh volume (cm³)", 0, cm3),
        Measured::difference("difference_cm3", "difference (cm³)", 0, cm3),
        Measured::change("difference_percent", cm3),
        Measured::share("unsteady_percent", "unsteady", |run| {
            [run.unsteady, run.placed]
        }),
        Measured::sum("placed", "", |run| run.placed).shown_if(false),
        Measured::sum("unsteady", "", |run| run.unsteady).shown_if(false),
        Measured::mean("set_aside", "set aside", 1, |run| run.set_aside as f64),
        Measured::share("in_other_pose_percent", "in another pose", |run| {
            [run.in_other_pose, run.placed]
        }),
        Measured::sum("steps_widened", "steps widened", |run| run.steps_widened),
        Measured::time("decision_median_s", "decision, median", (0.5, 1), |run| {
            &run.decision_s
        }),
        Measured::time("decision_95_s", "95 %", (0.95, 1), |run| &run.decision_s),
    ]
}

impl<'a> Results<'a> {
    pub(super) fn new(ways: &'a [Way], arguments: &FillingArguments) -> Self {
        let (sequences, workers) = (&arguments.sequences, arguments.runs.workers());
        Self {
            workers,
            first_case: sequences.first,
            cases: sequences.cases,
            ways,
            tables: Vec::new(),
            text: format!(
                "# {TITLE}\n\n\
                 Sequences {} to {} in robot conditions: laid down from 1 cm, by an exact scan where no camera is named. *Unsteady* is what \
                 toppled by more than 30 degrees, slid by more than 2 cm or left the container when it was placed. Differences are to \
                 the first method, sequence by sequence, with 95 % intervals by Student's t. {WIDENED} Decision times are of one step on \
                 one thread, {workers} sequences at once.\n",
                sequences.first,
                sequences.last(),
            ),
        }
    }

    /// Adds the runs in one kind of cell.
    pub(super) fn add(&mut self, physics: Physics, runs: Vec<Vec<Run>>) {
        let names = self.ways.iter().map(|way| way.name.clone());
        let mut lines = Lines::new("name", names.zip(runs).collect());
        let apart = physics.apart();
        self.text += &apart.markdown();
        self.text.push('\n');
        self.text += &lines.table("method", &columns());
        self.tables.push(Table {
            cell: physics.cell(),
            apart,
            lines,
        });
    }

    /// Volume against the share of what did not stay.
    pub(super) fn steadiness(&self) -> Scatter {
        self.scatter("Unsteady of what was placed (%)", ("unsteady_percent", 1.0))
    }

    /// Volume against the time of a decision.
    pub(super) fn times(&self) -> Scatter {
        let label = "Decision, 95 % take no longer (ms)";
        self.scatter(label, ("decision_95_s", 1e3))
    }

    fn scatter(&self, x_label: &str, (x, factor): (&str, f64)) -> Scatter {
        let tables = self.tables.iter().map(|table| (table.cell, &table.lines));
        let labels = [x_label, "Mesh volume (cm³)"];
        scatter(TITLE, labels, ([x, "meshes_cm3"], factor), tables)
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
