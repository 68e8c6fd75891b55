//! Tables of results: a column is measured once of a line's runs, shown in the document and kept among the figures.

use ppnpack_chart::{PlotPoint, PointSeries, Scatter};
use serde::Serialize;
use serde_json::{Map, Value, json};

use crate::comparison::point;
use crate::statistics::{Mean, percentage, quantiles};

/// What a column says of a line: in the document, and among the figures.
pub(crate) struct Cell {
    shown: String,
    kept: Value,
}

impl Cell {
    pub(crate) fn new(shown: String, kept: impl Serialize) -> Self {
        Self {
            shown,
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
    pub(crate) fn percent(part: usize, whole: usize) -> Self {
        let percent = percentage(part, whole);
        Self::new(format!("{percent:.1} %"), percent)
    }
}

/// Says what a column has of the runs of a line, and of those that all lines are compared with.
type Measure<'a, R> = Box<dyn Fn(&[R], &[R]) -> Cell + 'a>;

/// A column of a table.
pub(crate) struct Column<'a, R> {
    /// What it is kept by; with a `/` it is a part of what is before it.
    key: &'static str,
    head: &'static str,
    is_shown: bool,
    measure: Measure<'a, R>,
}

impl<'a, R> Column<'a, R> {
    pub(crate) fn new(
        key: &'static str,
        head: &'static str,
        measure: impl Fn(&[R], &[R]) -> Cell + 'a,
    ) -> Self {
        Self {
            key,
            head,
            is_shown: true,
            measure: Box::new(measure),
        }
    }

    /// Kept among the figures, and shown only where that is asked for.
    pub(crate) fn shown_if(self, is_shown: bool) -> Self {
        Self { is_shown, ..self }
    }

    /// The mean over the runs.
    pub(crate) fn mean(
        key: &'static str,
        head: &'static str,
        decimals: usize,
        value: impl Fn(&R) -> f64 + 'a,
    ) -> Self {
        Self::new(key, head, move |runs, _| {
            Cell::mean(Mean::of(runs.iter().map(&value)), decimals)
        })
    }

    /// The mean over the runs, kept in seconds and shown in milliseconds.
    pub(crate) fn mean_ms(
        key: &'static str,
        head: &'static str,
        seconds: impl Fn(&R) -> f64 + 'a,
    ) -> Self {
        Self::new(key, head, move |runs, _| {
            let mean = Mean::of(runs.iter().map(&seconds));
            Cell::new(format!("{} ms", mean.scaled(1e3).shown(3)), mean)
        })
    }

    /// The mean of the differences, run by run.
    pub(crate) fn difference(
        key: &'static str,
        head: &'static str,
        decimals: usize,
        value: impl Fn(&R) -> f64 + 'a,
    ) -> Self {
        Self::new(key, head, move |runs, others| {
            Cell::mean(paired(runs, others, &value), decimals)
        })
    }

    /// That mean by the others' mean.
    pub(crate) fn change(key: &'static str, value: impl Fn(&R) -> f64 + 'a) -> Self {
        Self::new(key, "", move |runs, others| {
            let compared = Mean::of(others.iter().map(&value)).mean;
            let percent = 100.0 * paired(runs, others, &value).mean / compared;
            Cell::new(format!("{percent:+.1} %"), percent)
        })
    }

    /// How many there are in all runs.
    pub(crate) fn sum(
        key: &'static str,
        head: &'static str,
        value: impl Fn(&R) -> usize + 'a,
    ) -> Self {
        Self::new(key, head, move |runs, _| {
            Cell::count(runs.iter().map(&value).sum())
        })
    }

    /// A part of a whole in all runs, kept in percent.
    pub(crate) fn share(
        key: &'static str,
        head: &'static str,
        of_run: impl Fn(&R) -> [usize; 2] + 'a,
    ) -> Self {
        Self::new(key, head, move |runs, _| {
            let counts = runs.iter().map(&of_run);
            let [part, whole] = counts.fold([0; 2], |[a, b], [c, d]| [a + c, b + d]);
            let percent = percentage(part, whole);
            Cell::new(format!("{percent:.1} % ({part} of {whole})"), percent)
        })
    }

    /// What a share of all times stays below, kept in seconds and shown in milliseconds.
    pub(crate) fn time(
        key: &'static str,
        head: &'static str,
        (share, decimals): (f64, usize),
        seconds: impl Fn(&R) -> &[f64] + 'a,
    ) -> Self {
        Self::new(key, head, move |runs, _| {
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
        let kept = runs
            .iter()
            .map(|(name, _)| Map::from_iter([(key.to_owned(), json!(name))]));
        Self {
            kept: kept.collect(),
            runs,
            compared,
        }
    }

    /// Keeps something of each line beside its columns.
    pub(crate) fn keep(&mut self, key: &str, values: impl IntoIterator<Item = impl Serialize>) {
        for (line, value) in self.kept.iter_mut().zip(values) {
            line.insert(
                key.to_owned(),
                serde_json::to_value(value).unwrap_or_default(),
            );
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
    pub(crate) fn table(&mut self, head: &str, columns: &[Column<'_, R>]) -> String {
        let shown = columns.iter().filter(|column| column.is_shown);
        let heads = shown.map(|column| column.head);
        let heads: Vec<&str> = std::iter::once(head).chain(heads).collect();
        let mut text = format!(
            "| {} |\n{}|\n",
            heads.join(" | "),
            "|---".repeat(heads.len())
        );
        for ((name, runs), kept) in self.runs.iter().zip(&mut self.kept) {
            text += &format!("| {name} |");
            for column in columns {
                let cell = (column.measure)(runs, &self.compared);
                if column.is_shown {
                    text += &format!(" {} |", cell.shown);
                }
                match column.key.split_once('/') {
                    None => {
                        kept.insert(column.key.to_owned(), cell.kept);
                    }
                    Some((group, key)) => {
                        let group = kept.entry(group).or_insert_with(|| json!({}));
                        if let Value::Object(group) = group {
                            group.insert(key.to_owned(), cell.kept);
                        }
                    }
                }
            }
            text.push('\n');
        }
        text
    }

    /// Points by what was kept of each line.
    fn points(&self, [x, y]: [&str; 2], factor: f64) -> Vec<PlotPoint> {
        let mean = |kept: &Map<String, Value>, key: &str| match kept.get(key) {
            Some(Value::Number(number)) => Mean {
                mean: number.as_f64().unwrap_or_default(),
                half_width: 0.0,
            },
            Some(value) => serde_json::from_value(value.clone()).unwrap_or_default(),
            None => Mean::default(),
        };
        let lines = self.runs.iter().zip(&self.kept);
        let points = lines
            .map(|((name, _), kept)| point(name, &mean(kept, x).scaled(factor), &mean(kept, y)));
        points.collect()
    }
}

/// A chart of several tables: of each line a point, by what was kept of it as `keys`; x is shown so many times.
pub(crate) fn scatter<'a, R: Clone + 'a>(
    title: &str,
    labels: [&str; 2],
    (keys, factor): ([&str; 2], f64),
    tables: impl IntoIterator<Item = (&'a str, &'a Lines<R>)>,
) -> Scatter {
    let series = tables.into_iter().map(|(name, lines)| PointSeries {
        name: name.to_owned(),
        reference: false,
        points: lines.points(keys, factor),
    });
    let [x_label, y_label] = labels.map(str::to_owned);
    Scatter {
        title: title.to_owned(),
        x_label,
        y_label,
        series: series.collect(),
    }
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
            Column::difference("difference/mean", "", 1, value).shown_if(false),
            Column::change("change", value),
            Column::share("share", "above 2", |run| [usize::from(*run > 2.0), 1]),
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
    }
}
