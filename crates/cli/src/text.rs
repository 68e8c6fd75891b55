//! Text for people, by templates that see the same values as programs get in JSON.
//!
//! In text for the terminal, a table has a row a line with [`BAR`]s between its cells. `{% filter
//! columns %}` lays it out under the header in its first line, and `{% filter rows %}` without a
//! header.

use anyhow::Context;
use comfy_table::presets::UTF8_HORIZONTAL_ONLY;
use comfy_table::{ContentArrangement, LineStyle, Table, TableStyle};
use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use minijinja::{AutoEscape, Environment, Error, Output, State, UndefinedBehavior, Value, context};
use serde::Serialize;

/// A template: the name of its file, whose ending says what is escaped in it, and its text.
pub(crate) type Template = (&'static str, &'static str);

/// Includes the template in a file beside the one that names it.
macro_rules! template {
    ($file:literal) => {
        ($file, include_str!($file))
    };
}
pub(crate) use template;

/// Lines of a table: around it and below its header.
const STYLE: TableStyle = UTF8_HORIZONTAL_ONLY.row_separator(LineStyle::none());

/// Separator of the cells of a row.
pub(crate) const BAR: char = '│';

/// Maximum of several names that are told.
const MOST_NAMES: usize = 4;

/// Fills a value into a template, which knows it as `it`.
///
/// # Errors
/// The first thing that the template names and the value does not have.
pub(crate) fn render((name, text): Template, it: impl Serialize) -> anyhow::Result<String> {
    let mut templates = Environment::new();
    let mut lines = SyntaxConfig::builder();
    templates.set_syntax(lines.trim_blocks(true).lstrip_blocks(true).build()?);
    templates.set_undefined_behavior(UndefinedBehavior::SemiStrict);
    templates.set_formatter(fill_in);
    templates.add_filter("columns", |text: String| table(&text, true));
    templates.add_filter("rows", |text: String| table(&text, false));
    templates.add_filter("fixed", fixed);
    templates.add_filter("percent", |share: f64| fixed(share * 100.0, 1) + " %");
    templates.add_filter("duration", duration);
    templates.add_filter("utc", |at_ns: u64| {
        ppnpack_recording::utc(at_ns / 1_000_000_000)
    });
    templates.add_filter("centimetres", |lengths_m: Vec<f64>, between: String| {
        let lengths = lengths_m.iter().map(|length_m| fixed(length_m * 100.0, 1));
        lengths.collect::<Vec<_>>().join(&between)
    });
    templates.add_filter("listed", |names: Vec<String>| listed(&names));
    templates.add_filter("commonest", |all: Vec<String>| commonest(&all).cloned());
    let filled = templates.render_named_str(name, text, context!(it => Value::from(Serde(it))));
    filled.with_context(|| format!("{name} cannot be filled in"))
}

/// Writes what is filled in: in a page without markup, in other text as no other line and no other
/// cell.
fn fill_in(out: &mut Output<'_>, state: &mut State<'_, '_>, value: &Value) -> Result<(), Error> {
    match (state.auto_escape(), value.as_str()) {
        (AutoEscape::None, Some(text)) if !value.is_safe() => {
            let text = text.replace(char::is_control, " ").replace(BAR, "|");
            Ok(out.write_str(&text)?)
        }
        _ => minijinja::escape_formatter(out, state, value),
    }
}

/// Lays out rows for the terminal.
pub(crate) fn table(text: &str, has_header: bool) -> Value {
    let lines = text.lines().filter(|line| !line.trim().is_empty());
    let mut rows = lines.map(|line| line.split(BAR).map(str::trim));
    let mut table = Table::new();
    table.load_style(STYLE);
    // No wider than the terminal; in a file as wide as its content.
    if let Ok(terminal) = rustix::termios::tcgetwinsize(std::io::stdout())
        && terminal.ws_col > 0
    {
        table.set_content_arrangement(ContentArrangement::Dynamic);
        table.set_width(terminal.ws_col);
    }
    if has_header && let Some(header) = rows.next() {
        table.set_header(header);
    }
    table.add_rows(rows);
    Value::from_safe_string(table.to_string() + "\n")
}

fn fixed(number: f64, places: usize) -> String {
    let scale = 10_f64.powi(i32::try_from(places).unwrap_or(i32::MAX));
    // No minus before what rounds to 0.
    let is_zero = (number * scale).round() == 0.0;
    format!("{:.places$}", if is_zero { 0.0 } else { number })
}

/// Writes seconds for people.
fn duration(seconds: f64) -> String {
    match seconds {
        seconds if seconds < 1e-3 => format!("{:.0} µs", seconds * 1e6),
        seconds if seconds < 1.0 => format!("{:.2} ms", seconds * 1e3),
        seconds => format!("{seconds:.1} s"),
    }
}

/// Tells some names, and how many more there are.
fn listed(names: &[String]) -> String {
    let shown = names.get(..MOST_NAMES).unwrap_or(names);
    match (names.len() - shown.len(), shown.split_last()) {
        (0, Some((last, []))) => last.clone(),
        (0, Some((last, others))) => format!("{} and {last}", others.join(", ")),
        (more, _) => format!("{} and {more} more", shown.join(", ")),
    }
}

/// Gives what comes most often.
fn commonest(all: &[String]) -> Option<&String> {
    let times = |one: &String| all.iter().filter(|other| *other == one).count();
    all.iter().max_by_key(|one| times(one))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn names_are_listed_and_the_others_counted() {
        let told = |names: &str| {
            let names: Vec<String> = names.chars().map(String::from).collect();
            listed(&names)
        };
        assert_eq!(told("i"), "i");
        assert_eq!(told("gh"), "g and h");
        assert_eq!(told("abcdef"), "a, b, c, d and 2 more");
    }

    #[test]
    fn what_is_filled_in_is_no_line_no_cell_and_no_markup() {
        let value = json!({"name": "a│b\n<i>", "length": -0.001});
        let filled = |file| render((file, "{{ it.name }}: {{ it.length|fixed(2) }}"), &value);
        assert_eq!(filled("a.txt").unwrap(), "a|b <i>: 0.00");
        assert_eq!(filled("a.html").unwrap(), "a│b\n&lt;i&gt;: 0.00");
        assert!(render(("a.txt", "{{ it.nothing }}"), &value).is_err());
    }

    #[test]
    fn rows_are_laid_out_below_their_header() {
        let text = "{% filter columns %}\nName │ Count\n{% for one in it %}\n{{ one }} │ 1\n{% endfor %}\n{% endfilter %}\nEnd";
        let table = render(("a.txt", text), ["x", "y"]).unwrap();
        let lines: Vec<&str> = table.lines().map(str::trim).collect();
        let cells = |line: usize| lines[line].split_whitespace().collect::<Vec<_>>();
        assert_eq!(
            (cells(1), cells(3), cells(4)),
            (vec!["Name", "Count"], vec!["x", "1"], vec!["y", "1"])
        );
        assert_eq!(lines.last(), Some(&"End"));
    }
}
