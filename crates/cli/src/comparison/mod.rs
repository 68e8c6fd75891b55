//! Two packings side by side: what differs in their settings and figures, and where their choices first part.

mod figures;
pub(crate) mod page;
mod parting;
mod run;
mod settings;

use serde::Serialize;

use crate::output;
use figures::Figure;
use parting::Parting;
pub(crate) use run::Run;
use settings::Difference;

/// What two runs have in common, and what not.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Comparison {
    /// The runs' folders.
    pub(crate) a: String,
    pub(crate) b: String,
    /// The settings that are not the same.
    pub(crate) settings: Vec<Difference>,
    pub(crate) figures: Vec<Figure>,
    /// Why each ended.
    pub(crate) endings: [String; 2],
    /// Where the choices first part; absent where all are the same.
    pub(crate) parting: Option<Parting>,
    /// How many steps are the same before that.
    pub(crate) steps_in_common: usize,
}

impl Comparison {
    /// Of two runs.
    pub(crate) fn of(a: &Run, b: &Run) -> Self {
        let (steps_in_common, parting) = parting::first(&a.placements, &b.placements);
        Self {
            a: a.folder.display().to_string(),
            b: b.folder.display().to_string(),
            settings: settings::differences(a.settings(), b.settings()),
            figures: figures::figures(&a.summary, &b.summary),
            endings: [a, b].map(Run::ending),
            parting,
            steps_in_common,
        }
    }

    /// What matters most, in a sentence.
    pub(crate) fn answer(&self) -> String {
        let settings = match self.settings.len() {
            0 => "The settings are the same".to_owned(),
            1 => "One setting differs".to_owned(),
            count => format!("{count} settings differ"),
        };
        let same = self.steps_in_common;
        let choices = match &self.parting {
            None => format!("all {same} choices are the same"),
            Some(parting) => format!("the choices part in step {}", parting.step + 1),
        };
        let filled = self.figures.iter().find(|figure| figure.is_filling());
        let filled = match filled.and_then(|figure| Some((figure, figure.difference?))) {
            None => String::new(),
            Some((_, 0.0)) => "; both containers are equally full".to_owned(),
            Some((figure, more)) => format!(
                "; the container of {} is fuller, by {} points",
                if more > 0.0 { "B" } else { "A" },
                figure.shown(more.abs())
            ),
        };
        format!("{settings}, and {choices}{filled}.")
    }

    /// Tables for the terminal.
    pub(crate) fn tables(&self) -> String {
        let mut figures = output::table();
        figures.set_header(["Figure", "A", "B", "Difference"]);
        for figure in &self.figures {
            let [a, b] = figure.values();
            figures.add_row([figure.head(), a, b, figure.change()]);
        }
        let [a, b] = self.endings.clone();
        figures.add_row(["Ended because".to_owned(), a, b, String::new()]);
        let mut settings = output::table();
        settings.set_header(["Setting", "A", "B"]);
        for Difference { setting, a, b } in &self.settings {
            settings.add_row([setting.clone(), settings::shown(a), settings::shown(b)]);
        }
        let settings = match self.settings.is_empty() {
            true => String::new(),
            false => format!("{settings}\n"),
        };
        let parting = self.parting.as_ref();
        let parting = parting.map_or_else(String::new, |parting| format!("\n{}", parting.told()));
        format!(
            "A: {}\nB: {}\n{settings}{figures}\n{}{parting}",
            self.a,
            self.b,
            self.answer()
        )
    }
}
