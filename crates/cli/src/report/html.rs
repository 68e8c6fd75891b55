//! `report.html`: one page that needs nothing else.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use ppnpack_packing::grid::ContainerSize;

use super::arm::ArmSummary;
use super::pictures::Pictures;
use super::playback::Playback;
use super::summary::{EndingSummary, Unplaceable};
use super::table::{duration, figures, percent};
use super::{Packing, Summary, steps, words};
use crate::length::centimetres;

const STYLE: &str = include_str!("style.css");

/// A whole page that fits screens of all sizes, light and dark, and paper.
fn document(title: &str, body: &str) -> String {
    format!(
        "<!doctype html><html lang=en><meta charset=utf-8>\
         <meta name=viewport content=\"width=device-width, initial-scale=1\">\
         <title>{}</title><style>{STYLE}</style><body>{body}</body></html>\n",
        escape(title)
    )
}

/// The whole page: the answer, the packing step by step, figures, and then all details.
pub(super) fn page(packing: &Packing, summary: &Summary, pictures: &Pictures) -> String {
    let mut body = String::new();
    answer(&mut body, packing, summary, pictures);
    tiles(&mut body, summary);
    match Playback::of(packing) {
        Some(playback) => body.push_str(&playback.section()),
        None if packing.steps.is_empty() => {}
        None => body.push_str(
            "<p class=sub>There are too many steps to play them here; the picture shows the end.</p>",
        ),
    }
    body.push_str("<h2>Figures</h2><div class=pair><table>");
    for (name, value) in figures(packing, summary) {
        body.push_str(&format!(
            "<tr><th scope=row>{name}</th><td>{}</td></tr>",
            escape(&value)
        ));
    }
    body.push_str("</table>");
    let heightmap = &pictures.heightmap_png;
    image(&mut body, heightmap, "The heightmap at the end");
    body.push_str(&format!(
        "</div><div class=pair><div>{}</div><div>{}</div></div>",
        pictures.utilisation_svg, pictures.decisions_svg
    ));
    set_aside(&mut body, packing, summary);
    if let EndingSummary::NothingFits { items } = &summary.ending {
        unplaceable(&mut body, "What could not be placed", items);
    }
    if let Some(arm) = &summary.arm {
        arm_refusals(&mut body, arm);
    }
    body.push_str(&steps::section(packing, summary));
    let shown = serde_json::to_string_pretty(&packing.settings).unwrap_or_default();
    body.push_str(&format!(
        "<section class=settings><h2>Settings</h2><details><summary>Everything this run depended on</summary><pre>{}</pre></details>\
         </section>",
        escape(&shown)
    ));
    document("Packing report", &body)
}

/// The answer in a sentence, with the picture beside it.
fn answer(body: &mut String, packing: &Packing, summary: &Summary, pictures: &Pictures) {
    let settings = &packing.settings;
    let ContainerSize { x_m, y_m, z_m } = settings.grid.container();
    let subtitle = format!(
        "{} into a container of {}, on {} x {} cells",
        settings.sequence.from,
        centimetres([x_m, y_m, z_m]),
        settings.grid.nx(),
        settings.grid.ny(),
    );
    let said = words::answer(packing, summary);
    let aside = words::aside(packing, summary);
    let aside = aside.map_or_else(String::new, |text| format!("<p>{}</p>", escape(&text)));
    body.push_str(&format!(
        "<div class=answer><div><h1>Packing report</h1><p class=said>{}</p>{aside}<p class=sub>{}</p></div>",
        escape(&said),
        escape(&subtitle)
    ));
    image(body, &pictures.packed_png, "The packed container");
    body.push_str("</div>");
}

/// The figures that are asked for first.
fn tiles(body: &mut String, summary: &Summary) {
    let metrics = &summary.metrics;
    let packed = format!("{} / {}", metrics.packed.items, summary.items_in_sequence);
    let mut tiles = vec![
        ("items packed", packed),
        ("container filled", percent(metrics.utilisation)),
        (
            "compactness by the floor (voxels)",
            percent(metrics.floor_compactness),
        ),
        ("decision per item", duration(summary.decision_s.mean)),
    ];
    if let Some(arm) = &summary.arm {
        tiles.push(("cycle per item", format!("{:.2} s", arm.cycle_s.mean)));
    }
    body.push_str("<div class=tiles>");
    for (name, value) in tiles {
        body.push_str(&format!(
            "<div class=tile><b>{}</b><span>{name}</span></div>",
            escape(&value)
        ));
    }
    body.push_str("</div>");
}

/// A picture within the page.
fn image(body: &mut String, png: &[u8], what: &str) {
    let data = STANDARD.encode(png);
    body.push_str(&format!(
        "<img alt=\"{}\" src=\"data:image/png;base64,{data}\">",
        escape(what)
    ));
}

/// What the arm refused: placements by reason, and items that it cannot pick.
fn arm_refusals(body: &mut String, arm: &ArmSummary) {
    let rows = arm.refused().map(|(why, count)| {
        let why = escape(why);
        format!("<tr><td class=n>{count}<td>{why}</tr>")
    });
    let rows: String = rows.collect();
    if !rows.is_empty() {
        body.push_str(&format!(
            "<h2>Placements that the arm refused</h2><table><tr><th class=n>Placements<th>Why</tr>{rows}</table>"
        ));
    }
    if !arm.set_aside.is_empty() {
        unplaceable(body, "Set aside: the arm cannot pick it up", &arm.set_aside);
    }
}

/// What was set aside for the next container, and why.
fn set_aside(body: &mut String, packing: &Packing, summary: &Summary) {
    let items = &summary.set_aside;
    if !items.is_empty() {
        unplaceable(body, "Set aside for the next container", items);
    }
    let (count, most) = (items.len(), packing.settings.set_aside);
    if most > 0 {
        body.push_str(&format!(
            "<p class=sub>Set aside for the next container: {count} of at most {most} items. Where none of the items in \
             the buffer had a valid placement, the largest of them was taken out.</p>"
        ));
    }
}

fn unplaceable(body: &mut String, title: &str, items: &[Unplaceable]) {
    body.push_str(&format!(
        "<h2>{title}</h2><table><tr><th class=n>Arrival<th>Item<th>Why</tr>"
    ));
    for item in items {
        body.push_str(&format!(
            "<tr><td class=n>{}<td>{}<td>{}</tr>",
            item.arrival,
            escape(&item.item),
            escape(&item.reason)
        ));
    }
    body.push_str("</table>");
}

/// Text that is no markup, also within quotes.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
        .replace('\'', "&#39;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_text_and_nothing_else() {
        let name = "<b onclick='a()'>\"x\" & y</b>";
        let shown = "&lt;b onclick=&#39;a()&#39;&gt;&quot;x&quot; &amp; y&lt;/b&gt;";
        assert_eq!(escape(name), shown);
        let items = [Unplaceable {
            arrival: 3,
            item: name.to_owned(),
            reason: "a < b".to_owned(),
        }];
        let mut body = String::new();
        unplaceable(&mut body, "Left", &items);
        assert!(body.contains(shown) && body.contains("a &lt; b"), "{body}");
        assert!(!body.contains("<b"), "{body}");
    }

    #[test]
    fn a_document_fits_dark_screens_and_paper_and_fetches_nothing() {
        let page = document("A & B", "<p>text</p>");
        assert!(page.contains("<title>A &amp; B</title>"));
        for part in ["prefers-color-scheme: dark", "@media print", "<p>text</p>"] {
            assert!(page.contains(part), "{part}");
        }
        assert!(!page.contains("http") && !page.contains("url("));
    }
}
