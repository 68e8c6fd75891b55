//! The page of an experiment, in the style of a packing's report: its answer and a picture first, then all figures, where they come
//! from, and every setting.

use std::path::Path;

use ppnpack_cli::failure::{OrRun, Outcome};
use ppnpack_cli::report::html;
use pulldown_cmark::{CowStr, Event, HeadingLevel, Options, Parser, Tag, TagEnd};
use serde::Serialize;
use serde_json::Value;

use crate::document::Document;
use crate::origin::Origin;

/// One page that needs nothing else; pictures are those of the folder that the document's files are in.
///
/// # Errors
/// That the results are no JSON.
pub(crate) fn page<R: Serialize>(
    document: &Document<'_, R>,
    origin: &Origin,
    folder: &Path,
) -> Outcome<String> {
    let results = serde_json::to_value(document.results).or_run()?;
    let settings = serde_json::to_string_pretty(&settings(&results, document.measured)).or_run()?;
    let answer = &document.answer;
    let [question, said] = [answer.question, answer.text.as_str()].map(html::escape);
    let said = unbroken(&said);
    let picture = picture(folder, &answer.picture, answer.question).unwrap_or_default();
    let body = format!(
        "<main><div class=answer><div><h1>{question}</h1><p class=said>{said}</p></div>{picture}</div>{}\
         <h2>Where it comes from</h2><table>{}</table>\
         <section class=settings><h2>Settings</h2><details><summary>Everything that the results depend on</summary><pre>{}</pre></details>\
         <details><summary>All options of the command</summary><pre>{}</pre></details></section></main>",
        rendered(&document.markdown, folder, &answer.picture),
        rows(&origin.parts()),
        html::escape(&settings),
        html::escape(&format!("{:#?}", document.asked))
    );
    Ok(html::document(answer.question, &body))
}

fn rows(rows: &[(&str, &str)]) -> String {
    let rows = rows.iter().map(|(name, value)| {
        let value = html::escape(value);
        format!("<tr><th scope=row>{name}</th><td>{value}</td></tr>")
    });
    rows.collect()
}

/// Results without what was measured.
fn settings(results: &Value, measured: &[&str]) -> Value {
    match results {
        Value::Object(fields) => {
            let kept = fields
                .iter()
                .filter(|(name, _)| !measured.contains(&name.as_str()));
            let kept = kept.map(|(name, value)| (name.clone(), settings(value, measured)));
            Value::Object(kept.collect())
        }
        Value::Array(values) => {
            let values = values.iter().map(|value| settings(value, measured));
            Value::Array(values.collect())
        }
        other => other.clone(),
    }
}

/// A picture of the folder within the page; none where it is not there.
fn picture(folder: &Path, name: &str, what: &str) -> Option<String> {
    let path = folder.join(Path::new(name).file_name()?);
    if path.extension()? == "svg" {
        let svg = std::fs::read_to_string(path).ok()?;
        let what = html::escape(what);
        return Some(format!(
            "<span class=figure role=img aria-label=\"{what}\">{svg}</span>"
        ));
    }
    let mut image = String::new();
    html::image(&mut image, &std::fs::read(path).ok()?, what);
    Some(image)
}

/// A document as HTML, one heading lower, with its pictures in it, but for one that is shown already. What would be HTML in it is text,
/// and it links to nothing.
fn rendered(markdown: &str, folder: &Path, shown: &str) -> String {
    let mut image: Option<(CowStr<'_>, String)> = None;
    let events = Parser::new_ext(markdown, Options::ENABLE_TABLES);
    let events = events.filter_map(|event| match event {
        Event::Start(Tag::Image { dest_url, .. }) => {
            image = Some((dest_url, String::new()));
            None
        }
        Event::End(TagEnd::Image) => {
            let (name, what) = image.take()?;
            let is_new = &*name != shown;
            let picture = is_new.then(|| picture(folder, &name, &what)).flatten()?;
            Some(Event::InlineHtml(picture.into()))
        }
        event => match &mut image {
            Some((_, what)) => {
                if let Event::Text(text) = event {
                    what.push_str(&text);
                }
                None
            }
            None => harmless(event),
        },
    });
    let mut page = String::new();
    pulldown_cmark::html::push_html(&mut page, events);
    let table = "<div class=\"scroll results\" role=region tabindex=0 aria-label=Figures><table>";
    let page = page.replace("<table>", table);
    unbroken(&page.replace("</table>", "</table></div>"))
}

/// Figures with their intervals and percentages stay on a line.
fn unbroken(text: &str) -> String {
    text.replace(" ± ", "\u{a0}±\u{a0}")
        .replace(" %", "\u{a0}%")
}

/// What is rendered of an event outside of images.
fn harmless(event: Event<'_>) -> Option<Event<'_>> {
    match event {
        Event::Start(Tag::Link { .. }) | Event::End(TagEnd::Link) => None,
        Event::Html(text) | Event::InlineHtml(text) => Some(Event::Text(text)),
        Event::Start(Tag::Heading { level, .. }) => Some(Event::Start(Tag::Heading {
            level: lower(level),
            id: None,
            classes: Vec::new(),
            attrs: Vec::new(),
        })),
        Event::End(TagEnd::Heading(level)) => Some(Event::End(TagEnd::Heading(lower(level)))),
        event => Some(event),
    }
}

/// The heading below this one.
fn lower(level: HeadingLevel) -> HeadingLevel {
    match level {
        HeadingLevel::H1 => HeadingLevel::H2,
        HeadingLevel::H2 => HeadingLevel::H3,
        _ => HeadingLevel::H4,
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::document::Answer;

    const MARKDOWN: &str = "# A title\n\nSome <b onclick='a()'>text</b> and [a link](http://away).\n\n\
        | method | volume |\n|---|---|\n| <script>x</script> | 1 |\n\n## Pictures\n\n![First](one.svg)\n\n![Second & third](two.svg)\n\n\
        ![Lost](three.svg)\n";

    fn page_of(folder: &Path) -> String {
        for (name, content) in [("one.svg", "<svg>1</svg>"), ("two.svg", "<svg>2</svg>")] {
            std::fs::write(folder.join(name), content).unwrap();
        }
        let results = json!({ "seed": 7, "ways": [{ "name": "<i>", "mean": 3 }], "mean": 1 });
        let document = Document {
            name: "a",
            answer: Answer {
                question: "Is a < b?",
                text: "Yes, by 3 & more.".to_owned(),
                picture: "one.svg".to_owned(),
            },
            results: &results,
            asked: &("--seed", 7),
            measured: &["mean"],
            markdown: MARKDOWN.to_owned(),
        };
        page(&document, &Origin::now().unwrap(), folder).unwrap()
    }

    #[test]
    fn the_answer_comes_first_and_everything_is_there_once() {
        let folder = tempfile::tempdir().unwrap();
        let page = page_of(folder.path());
        let at = |part: &str| page.find(part).unwrap_or_else(|| panic!("{part}: {page}"));
        let order = [
            "<h1>Is a &lt; b?</h1>",
            "Yes, by 3 &amp; more.",
            "<svg>1</svg>",
            "<h2>A title</h2>",
            "<table>",
            "<h3>Pictures</h3>",
            "aria-label=\"Second &amp; third\"><svg>2</svg>",
            "<th scope=row>Command</th>",
            "&quot;seed&quot;: 7",
            "&quot;--seed&quot;,",
        ];
        assert!(order.map(at).is_sorted(), "{page}");
        assert_eq!(page.matches("<svg>").count(), 2);
        assert!(page.contains("&quot;name&quot;: &quot;&lt;i&gt;&quot;"));
        assert!(
            !page.contains("&quot;mean&quot;"),
            "what was measured is no setting"
        );
    }

    #[test]
    fn what_would_be_markup_is_text_and_nothing_is_fetched() {
        let folder = tempfile::tempdir().unwrap();
        let page = page_of(folder.path());
        for part in ["<b ", "<script", "<i>", "http", "href", "three.svg"] {
            assert!(!page.contains(part), "{part}: {page}");
        }
        assert!(
            page.contains("a link") && page.contains("&lt;script&gt;"),
            "{page}"
        );
    }
}
