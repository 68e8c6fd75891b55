//! `compare.html`: two runs side by side, on one page that needs nothing else.

use super::settings::{Difference, shown};
use super::{Comparison, Run};
use crate::report::html::{document, escape, image};

/// The whole page.
pub(crate) fn page(comparison: &Comparison, a: &Run, b: &Run) -> String {
    let mut body = format!(
        "<h1>Two packings compared</h1><p class=said>{}</p>",
        escape(&comparison.answer())
    );
    body += "<div class=pair>";
    picture(&mut body, "A", &comparison.a, a);
    picture(&mut body, "B", &comparison.b, b);
    body += "</div>";
    figures(&mut body, comparison);
    settings(&mut body, comparison);
    choices(&mut body, comparison);
    document("Two packings compared", &body)
}

fn picture(body: &mut String, name: &str, folder: &str, run: &Run) {
    *body += &format!("<div><p><b>{name}</b>: {}</p>", escape(folder));
    match &run.picture_png {
        Some(png) => image(body, png, &format!("The packed container of {name}")),
        None => *body += "<p class=sub>Its packed.png is not there.</p>",
    }
    *body += "</div>";
}

fn figures(body: &mut String, comparison: &Comparison) {
    *body += "<h2>Figures</h2><div class=scroll><table><thead><tr><th scope=col>Figure<th class=n scope=col>A<th class=n scope=col>B\
              <th class=n scope=col>B − A</tr></thead><tbody>";
    for figure in &comparison.figures {
        let [a, b] = figure.values();
        *body += &format!(
            "<tr><th scope=row>{}<td class=n>{a}<td class=n>{b}<td class=n>{}</tr>",
            escape(&figure.head()),
            figure.change()
        );
    }
    let [a, b] = &comparison.endings;
    *body += &format!(
        "</tbody></table></div><p>A ended: {}. B ended: {}.</p>",
        escape(a),
        escape(b)
    );
}

fn settings(body: &mut String, comparison: &Comparison) {
    *body += "<h2>Settings that differ</h2>";
    if comparison.settings.is_empty() {
        *body += "<p>None.</p>";
        return;
    }
    *body += "<div class=scroll><table><thead><tr><th scope=col>Setting<th scope=col>A<th scope=col>B</tr></thead><tbody>";
    for Difference { setting, a, b } in &comparison.settings {
        *body += &format!(
            "<tr><th scope=row>{}<td>{}<td>{}</tr>",
            escape(setting),
            escape(&shown(a)),
            escape(&shown(b))
        );
    }
    *body += "</tbody></table></div>";
}

fn choices(body: &mut String, comparison: &Comparison) {
    let same = comparison.steps_in_common;
    *body += "<h2>Where the choices part</h2>";
    match &comparison.parting {
        None => *body += &format!("<p>Nowhere: all {same} are the same.</p>"),
        Some(parting) => {
            let [a, b] = parting.choices();
            *body += &format!(
                "<p>In step {}, after {same} that are the same.</p><p><b>A</b> placed {}.</p><p><b>B</b> placed {}.</p>",
                parting.step + 1,
                escape(&a),
                escape(&b)
            );
        }
    }
}
