//! `report.html`: one page that needs nothing else.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use ppnpack_packing::grid::ContainerSize;

use super::arm::ArmSummary;
use super::pictures::Pictures;
use super::summary::{EndingSummary, Unplaceable};
use super::table::{duration, figures, percent};
use super::words::in_words;
use super::{Packing, Summary};
use crate::length::centimetres;

pub(super) const STYLE: &str = "
:root { color-scheme: light; --ink: #1f2933; --soft: #616e7c; --line: #e4e7eb; }
body { font: 15px/1.5 system-ui, sans-serif; color: var(--ink); max-width: 72rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; margin-bottom: 0; } h2 { font-size: 1.15rem; margin-top: 2.2rem; }
p.sub { color: var(--soft); margin-top: .2rem; }
.tiles { display: grid; grid-template-columns: repeat(auto-fit, minmax(11rem, 1fr)); gap: .8rem; margin: 1.4rem 0; }
.tile { border: 1px solid var(--line); border-radius: .6rem; padding: .7rem .9rem; }
.tile b { display: block; font-size: 1.35rem; } .tile span { color: var(--soft); }
img, svg { max-width: 100%; height: auto; } .pair { display: grid; grid-template-columns: 1fr 1fr; gap: 1rem; align-items: start; }
table { border-collapse: collapse; width: 100%; } .scroll { overflow-x: auto; }
th, td { text-align: left; padding: .25rem .6rem; border-bottom: 1px solid var(--line); white-space: nowrap; }
th { color: var(--soft); font-weight: 600; } td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; }
tr.bad td { background: #fff4e5; } pre { background: #f5f7fa; padding: 1rem; border-radius: .6rem; overflow-x: auto; }
@media (max-width: 50rem) { .pair { grid-template-columns: 1fr; } }
";

/// The whole page.
pub(super) fn page(packing: &Packing, summary: &Summary, pictures: &Pictures) -> String {
    let settings = &packing.settings;
    let ContainerSize { x_m, y_m, z_m } = settings.grid.container();
    let mut body = String::new();
    let metrics = &summary.metrics;
    let packed = format!("{} / {}", metrics.packed.items, summary.items_in_sequence);
    let mut tiles = vec![
        ("items packed", packed),
        (
            "compactness by the floor (voxels)",
            percent(metrics.floor_compactness),
        ),
        ("container filled", percent(metrics.utilisation)),
        ("decision per item", duration(summary.decision_s.mean)),
    ];
    if let Some(arm) = &summary.arm {
        tiles.push(("cycle per item", format!("{:.2} s", arm.cycle_s.mean)));
    }
    let subtitle = format!(
        "{} into a container of {}, on {} x {} cells",
        settings.sequence.from,
        centimetres([x_m, y_m, z_m]),
        settings.grid.nx(),
        settings.grid.ny(),
    );
    body.push_str(&format!(
        "<h1>Packing report</h1><p class=sub>{}</p>",
        escape(&subtitle)
    ));
    let words = in_words(packing, summary);
    body.push_str(&format!("<p>{}</p>", escape(&words)));
    body.push_str("<div class=tiles>");
    for (name, value) in tiles {
        body.push_str(&format!(
            "<div class=tile><b>{}</b><span>{name}</span></div>",
            escape(&value)
        ));
    }
    body.push_str("</div>");
    image(&mut body, &pictures.packed_png, "The packed container");
    body.push_str(&format!(
        "<div class=pair><div>{}</div><div>{}</div></div>",
        pictures.utilisation_svg, pictures.decisions_svg
    ));
    body.push_str("<h2>Figures</h2><div class=pair><table>");
    for (name, value) in figures(packing, summary) {
        body.push_str(&format!(
            "<tr><th>{name}</th><td>{}</td></tr>",
            escape(&value)
        ));
    }
    body.push_str("</table>");
    let heightmap = &pictures.heightmap_png;
    image(&mut body, heightmap, "The heightmap at the end");
    body.push_str("</div>");
    set_aside(&mut body, packing, summary);
    if let EndingSummary::NothingFits { items } = &summary.ending {
        unplaceable(&mut body, "What could not be placed", items);
    }
    if let Some(arm) = &summary.arm {
        arm_refusals(&mut body, arm);
    }
    steps(&mut body, packing, summary);
    let shown = serde_json::to_string_pretty(settings).unwrap_or_default();
    body.push_str(&format!("<h2>Settings</h2><details><summary>Everything this run depended on</summary><pre>{}</pre></details>",
        escape(&shown)));
    format!(
        "<!doctype html><html lang=en><meta charset=utf-8>\
         <meta name=viewport content=\"width=device-width, initial-scale=1\">\
         <title>Packing report</title><style>{STYLE}</style><body>{body}</body></html>\n"
    )
}

fn image(body: &mut String, png: &[u8], what: &str) {
    let data = STANDARD.encode(png);
    body.push_str(&format!(
        "<img alt=\"{what}\" src=\"data:image/png;base64,{data}\">"
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

fn steps(body: &mut String, packing: &Packing, summary: &Summary) {
    let resolution = packing.settings.grid.resolution();
    let (cell_m, unit_m) = (resolution.cell_m(), resolution.height_unit_m());
    let cycle_head = packing.arm.as_ref();
    let cycle_head = cycle_head.map_or("", |_| "<th class=n>Cycle (s)");
    let load_head = summary.greatest_load.as_ref();
    let load_head = load_head.map_or("", |_| "<th class=n>Load (N)");
    let limit_head = summary.nearest_limit.as_ref();
    let limit_head = limit_head.map_or("", |_| "<th>Rests on (of what it may carry)");
    let has_poses = packing.settings.poses > 1;
    let pose_head = if has_poses { "<th class=n>Pose" } else { "" };
    let poses = match summary.items_in_other_pose {
        _ if !has_poses => String::new(),
        turned => format!(
            " Packed in another pose than that in which it was offered: {turned} of {} items. That is pose 0, the others \
             are numbered by falling probability.",
            summary.items_placed
        ),
    };
    let loads = match summary.greatest_load {
        Some(_) => " The load is what the item presses with on any one other, as the tries tell.",
        None => "",
    };
    body.push_str(&format!(
        "<h2>Steps</h2><p class=sub>Highlighted: toppled, or not inside the container at the end. \
         Alternatives are the values of the next best valid placements.{poses}{loads}</p>\
         <div class=scroll><table><tr><th class=n>Step<th class=n>Arrival<th>Item{pose_head}<th class=n>Yaw (°)\
         <th class=n>x (cm)<th class=n>y (cm)<th class=n>z (cm)<th class=n>Value<th>Alternatives\
         <th class=n>Propose<th class=n>Evaluate<th class=n>Check<th class=n>Slide (mm)<th class=n>Tilt (°){load_head}{limit_head}{cycle_head}</tr>",
    ));
    for (step, settled) in packing.steps.iter().zip(&packing.settled) {
        let arrival = step.candidate.arrival;
        let inside = packing.lies(arrival).is_some_and(|body| body.inside);
        let at = step.choice.resting;
        let alternatives = step.alternatives.iter();
        let alternatives = alternatives.map(|other| format!("{:.2}", other.value));
        let cycle = match step.cycle_s() {
            _ if packing.arm.is_none() => String::new(),
            Some(cycle_s) => format!("<td class=n>{cycle_s:.2}"),
            None => "<td>".to_owned(),
        };
        let load = match step.evidence.settling {
            _ if summary.greatest_load.is_none() => String::new(),
            Some(settling) => format!("<td class=n>{:.1}", settling.load_n),
            None => "<td>".to_owned(),
        };
        let limit = match &step.evidence.load {
            _ if summary.nearest_limit.is_none() => String::new(),
            Some(load) => format!(
                "<td>{} ({:.2} of {:.2} kg)",
                escape(&load.item),
                load.estimated_kg,
                load.carries_kg
            ),
            None => "<td>".to_owned(),
        };
        let pose = match step.candidate.pose {
            _ if !has_poses => String::new(),
            pose => format!("<td class=n>{pose}"),
        };
        let is_bad = settled.toppled || !inside;
        let class = if is_bad { " class=bad" } else { "" };
        body.push_str(&format!(
            "<tr{class}><td class=n>{}<td class=n>{arrival}<td>{}{pose}<td class=n>{:.0}<td class=n>{:.1}\
             <td class=n>{:.1}<td class=n>{:.1}<td class=n>{:.2}<td>{}<td class=n>{}<td class=n>{}\
             <td class=n>{}<td class=n>{:.1}<td class=n>{:.0}{load}{limit}{cycle}</tr>",
            step.step + 1,
            escape(step.candidate.item.name()),
            packing.yaw_rad(step).unwrap_or_default().to_degrees(),
            at.placement.x as f64 * cell_m * 100.0,
            at.placement.y as f64 * cell_m * 100.0,
            f64::from(at.resting_height) * unit_m * 100.0,
            step.choice.value,
            alternatives.collect::<Vec<_>>().join(", "),
            duration(step.timings.propose.as_secs_f64()),
            duration(step.timings.evaluate.as_secs_f64()),
            duration(step.timings.check.as_secs_f64()),
            settled.slide_m * 1e3,
            settled.tilt_rad.to_degrees()
        ));
    }
    body.push_str("</table></div>");
}

pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
