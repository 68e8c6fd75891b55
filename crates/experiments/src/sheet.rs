//! Tables of results: a column is measured once of a line's runs, shown in the document and kept among the figures.

use serde::Serialize;
use serde_json::{Map, Value, json};

use crate::statistics::{Mean, percentage, quantiles};

/// What a column says of a line: in the document, and among the figures.
pub(crate) struct Cell {
    shown: String,
    kept: Value,
}

impl Cell {
    pub(crate) fn new(shown: impl Into<String>, kept: impl Serialize) -> Self {
        Self {
            shown: shown.into(),
            kept: serde_json::to_value(kept).unwrap_or_default(),
        }
    }

    pub(crate) fn mean(mean: Mean, decimals: usize) -> Self {
        Self::new(mean.shown(decimals), mean)
    }

    pub(crate) fn count(count: usize) -> Self {
        Self::new(count.to_string(), count)
    }

    /// A part of a whole, kept in percent.
    pub(crate) fn share([part, whole]: [usize; 2]) -> Self {
        let percent = percentage(part, whole);
        match whole {
            0 => Self::new("–", Value::Null),
            _ => Self::new(format!("{percent:.1} % ({part} of {whole})"), percent),
        }
    }
}

/// Says what a column has of the runs of a line, and of those that all lines are compared with.
type Measure<R> = Box<dyn Fn(&[R], &[R]) -> Cell>;

/// A column of a table.
pub(crate) struct Column<R> {
    /// What it is kept by; with a `/` it is a part of what is before it.
    key: &'static str,
    head: &'static str,
    is_shown: bool,
    measure: Measure<R>,
}

impl<R> Column<R> {
    /// A column of the runs of a line and of those that they are compared with.
    pub(crate) fn compared(
        key: &'static str,
        head: &'static str,
        measure: impl Fn(&[R], &[R]) -> Cell + 'static,
    ) -> Self {
        Self {
            key,
            head,
            is_shown: true,
            measure: Box::new(measure),
        }
    }

    /// A column of the runs of a line.
    pub(crate) fn new(
        key: &'static str,
        head: &'static str,
        measure: impl Fn(&[R]) -> Cell + 'static,
    ) -> Self {
        Self::compared(key, head, move |runs, _| measure(runs))
    }

    /// Kept among the figures, and not shown.
    pub(crate) fn hidden(self) -> Self {
        Self {
            is_shown: false,
            ..self
        }
    }

    /// The mean over the runs.
    pub(crate) fn mean(
        key: &'static str,
        head: &'static str,
        decimals: usize,
        value: impl Fn(&R) -> f64 + 'static,
    ) -> Self {
        Self::new(key, head, move |runs| {
            Cell::mean(Mean::of(runs.iter().map(&value)), decimals)
        })
    }

    /// The mean over the runs, kept in seconds and shown in milliseconds.
    pub(crate) fn mean_ms(
        key: &'static str,
        head: &'static str,
        seconds: impl Fn(&R) -> f64 + 'static,
    ) -> Self {
        Self::new(key, head, move |runs| {
            let mean = Mean::of(runs.iter().map(&seconds));
            Cell::new(format!("{} ms", mean.scaled(1e3).shown(3)), mean)
        })
    }

    /// The mean of the differences, run by run.
    pub(crate) fn difference(
        key: &'static str,
        head: &'static str,
        decimals: usize,
        value: impl Fn(&R) -> f64 + 'static,
    ) -> Self {
        Self::compared(key, head, move |runs, others| {
            Cell::mean(paired(runs, others, &value), decimals)
        })
    }

    /// That mean by the others' mean.
    pub(crate) fn change(key: &'static str, value: impl Fn(&R) -> f64 + 'static) -> Self {
        Self::compared(key, "", move |runs, others| {
            let compared = Mean::of(others.iter().map(&value)).mean;
            let percent = 100.0 * paired(runs, others, &value).mean / compared;
            Cell::new(format!("{percent:+.1} %"), percent)
        })
    }

    /// How many there are in all runs.
    pub(crate) fn sum(
        key: &'static str,
        head: &'static str,
        value: impl Fn(&R) -> usize + 'static,
    ) -> Self {
        Self::new(key, head, move |runs| {
            Cell::count(runs.iter().map(&value).sum())
        })
    }

    /// A part of a whole in all runs, kept in percent.
    pub(crate) fn share(
        key: &'static str,
        head: &'static str,
        of_run: impl Fn(&R) -> [usize; 2] + 'static,
    ) -> Self {
        Self::new(key, head, move |runs| {
            let counts = runs.iter().map(&of_run);
            Cell::share(counts.fold([0; 2], |[a, b], [c, d]| [a + c, b + d]))
        })
    }

    /// What a share of all times stays below, kept in seconds and shown in milliseconds.
    pub(crate) fn time(
        key: &'static str,
        head: &'static str,
        (share, decimals): (f64, usize),
        seconds: impl Fn(&R) -> &[f64] + 'static,
    ) -> Self {
        Self::new(key, head, move |runs| {
            let all = runs.iter().flat_map(|run| seconds(run).iter().copied());
            let [time_s] = quantiles(all, [share]);
            Cell::new(format!("{:.decimals$} ms", time_s * 1e3), time_s)
        })
    }
}

fn paired<R>(runs: &[R], others: &[R], value: impl Fn(&R) -> f64) -> Mean {
    let pairs = runs.iter().zip(others);
    Mean::of(pairs.map(|(run, other)| value(run) - value(other)))
}

/// The lines of a table, with what is kept of each.
#[derive(Debug, Serialize)]
#[serde(transparent)]
pub(crate) struct Lines<R> {
    kept: Vec<Map<String, Value>>,
    #[serde(skip)]
    runs: Vec<(String, Vec<R>)>,
    /// Those that all are compared with.
    #[serde(skip)]
    compared: Vec<R>,
}

impl<R: Clone> Lines<R> {
    /// Lines by their names, which are kept as `key`; they are compared with the first of them.
    pub(crate) fn new(key: &str, runs: Vec<(String, Vec<R>)>) -> Self {
        let first = runs.first().map(|(_, runs)| runs.clone());
        Self::compared_with(first.unwrap_or_default(), key, runs)
    }

    /// Lines that are compared with other runs.
    pub(crate) fn compared_with(compared: Vec<R>, key: &str, runs: Vec<(String, Vec<R>)>) -> Self {
        let names = runs.iter().map(|(name, _)| json!(name));
        Self {
            kept: names
                .map(|name| Map::from_iter([(key.to_owned(), name)]))
                .collect(),
            runs,
            compared,
        }
    }

    /// Keeps something of each line beside its columns.
    pub(crate) fn keep(&mut self, key: &str, values: impl IntoIterator<Item = impl Serialize>) {
        for (line, value) in self.kept.iter_mut().zip(values) {
            let value = serde_json::to_value(value).unwrap_or_default();
            line.insert(key.to_owned(), value);
        }
    }

    /// The runs that all lines are compared with.
    pub(crate) fn compared(&self) -> &[R] {
        &self.compared
    }

    /// Takes over the lines of another table.
    pub(crate) fn append(&mut self, other: Self) {
        self.kept.extend(other.kept);
        self.runs.extend(other.runs);
    }

    /// Measures columns of each line, and gives the table of those that are shown.
    pub(crate) fn table(&mut self, head: &str, columns: &[Column<R>]) -> String {
        markdown(&self.measured(head, columns))
    }

    /// The heads of what is shown, then the cells of each line, which are kept, too.
    fn measured(&mut self, head: &str, columns: &[Column<R>]) -> Vec<Vec<String>> {
        let shown = columns.iter().filter(|column| column.is_shown);
        let heads = shown.map(|column| column.head.to_owned());
        let mut rows = vec![std::iter::once(head.to_owned()).chain(heads).collect()];
        for ((name, runs), kept) in self.runs.iter().zip(&mut self.kept) {
            let mut row = vec![name.clone()];
            for column in columns {
                let cell = (column.measure)(runs, &self.compared);
                if column.is_shown {
                    row.push(cell.shown);
                }
                let place = match column.key.split_once('/') {
                    None => kept.entry(column.key),
                    Some((group, key)) => match kept.entry(group).or_insert_with(|| json!({})) {
                        Value::Object(group) => group.entry(key),
                        _ => continue,
                    },
                };
                *place.or_insert(Value::Null) = cell.kept;
            }
            rows.push(row);
        }
        rows
    }
}

/// A table whose first row is its head.
fn markdown(rows: &[Vec<String>]) -> String {
    let mut text = String::new();
    for (index, row) in rows.iter().enumerate() {
        text += &format!("| {} |\n", row.join(" | "));
        if index == 0 {
            text += &format!("|{}\n", "---|".repeat(row.len()));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_is_shown_and_kept_of_each_line() {
        let runs = vec![
            ("one".to_owned(), vec![1.0, 3.0]),
            ("other".to_owned(), vec![2.0, 4.0]),
        ];
        let mut lines = Lines::new("name", runs);
        let value = |run: &f64| *run;
        let columns = [
            Column::mean("mean", "mean", 1, value),
            Column::difference("difference/mean", "", 1, value).hidden(),
            Column::change("change", value),
            Column::share("share", "above 2", |run| [usize::from(*run > 2.0), 1]),
            Column::share("none", "of nothing", |_| [0, 0]).hidden(),
        ];
        let text = lines.table("line", &columns);
        assert_eq!(
            text,
            "| line | mean |  | above 2 |\n|---|---|---|---|\n| one | 2.0 ± 12.7 | +0.0 % | 50.0 % (1 of 2) |\n\
             | other | 3.0 ± 12.7 | +50.0 % | 50.0 % (1 of 2) |\n"
        );
        let kept = serde_json::to_value(&lines).unwrap();
        assert_eq!(kept[1]["name"], "other");
        assert_eq!(kept[1]["difference"]["mean"]["mean"], 1.0);
        assert_eq!(kept[1]["share"], 50.0);
        assert!(kept[1]["none"].is_null());
    }
}
