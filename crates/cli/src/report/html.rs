//! `report.html`: one page that needs nothing else.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;
use serde_json::json;

use super::csv::Line;
use super::playback::{self, Playback};
use super::{Packing, Summary};
use crate::text::{BAR, render, template};

/// A page that fits screens of all sizes, light and dark, and paper.
#[derive(Serialize)]
struct Page<'a> {
    summary: &'a Summary,
    steps: Vec<Row<'a>>,
    /// The share of the container that the items' meshes fill, before the first step and after
    /// each.
    filled: Vec<f64>,
    /// The outcome, in a sentence.
    answer: String,
    figures: Vec<(&'a str, &'a str)>,
    /// Everything that the packing depended on, as JSON.
    settings: String,
    style: &'static str,
    viewer: String,
    /// JSON that cannot end the script element that holds it; none where there is nothing to play,
    /// or too much.
    playback: Option<String>,
    packed_png: String,
    heightmap_png: String,
}

/// A step: its line in `placements.csv`, and what is too long for that.
#[derive(Serialize)]
struct Row<'a> {
    #[serde(flatten)]
    line: Line<'a>,
    planned_cm: [f64; 3],
    /// The values of the next best placements.
    alternatives: Vec<f64>,
    degraded: &'a [String],
    /// Words for how it did not stay, and the kind of that.
    unsteadiness: Option<String>,
    unsteady: Option<&'static str>,
}

/// Renders the whole page.
pub(super) fn page(
    packing: &Packing,
    summary: &Summary,
    [packed_png, heightmap_png]: [&[u8]; 2],
) -> anyhow::Result<String> {
    let figures = summary.figures()?;
    let figures = figures.lines().filter_map(|line| line.split_once(BAR));
    let playback = Playback::of(packing).map(|played| played.to_json());
    let steps: Vec<Row<'_>> = rows(packing).collect();
    let told = json!({"summary": summary, "steps": steps});
    let page = Page {
        summary,
        steps,
        filled: filled(packing),
        answer: render(template!("answer.html"), told)?,
        figures: figures.collect(),
        settings: serde_json::to_string_pretty(&packing.settings)?,
        style: include_str!("style.css"),
        viewer: playback::viewer(),
        playback: playback.transpose()?,
        packed_png: STANDARD.encode(packed_png),
        heightmap_png: STANDARD.encode(heightmap_png),
    };
    render(template!("report.html"), page)
}

fn rows(packing: &Packing) -> impl Iterator<Item = Row<'_>> {
    let steps = packing.steps.iter().zip(&packing.settled);
    steps.map(move |(step, settled)| Row {
        line: Line::of(packing, step, *settled),
        planned_cm: packing.planned_cm(step),
        alternatives: step.alternatives.iter().map(|other| other.value).collect(),
        degraded: &step.degraded,
        unsteadiness: settled.unsteadiness(),
        unsteady: settled.kind_of_unsteadiness(),
    })
}

fn filled(packing: &Packing) -> Vec<f64> {
    let volume_m3 = packing.settings.grid.container().volume_m3();
    let mut filled = vec![0.0];
    let mut inside_m3 = 0.0;
    for (step, settled) in packing.steps.iter().zip(&packing.settled) {
        if settled.inside {
            inside_m3 += step.candidate.item.mesh_volume_m3();
        }
        filled.push(inside_m3 / volume_m3);
    }
    filled
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::*;

    /// Renders the answer of a packing that ended so, with these steps.
    fn answer(ending: &Value, steps: &Value) -> String {
        let summary = json!({
            "packed": {"items": 1},
            "items_in_sequence": 2,
            "utilisation": 0.5,
            "ending": ending,
            "set_aside": [],
            "settings": {"set_aside": 2},
        });
        let it = json!({"summary": summary, "steps": steps});
        render(template!("answer.html"), it).unwrap()
    }

    #[test]
    fn an_end_has_its_reason() {
        let left = |item: &str, reason: &str| json!({"item": item, "reason": reason});
        let [mug, bowl] = ["mug", "bowl"].map(|item| left(item, "too large"));
        let all = [mug, bowl, left("bag", "too soft")];
        let begin = "1 of 2 items is packed and the container is 50.0 % full; it ended as";
        let none = "none of the 3 items that waited had a place (mostly: too large)";
        let last = "mug, the last that waited, had no place (too large)";
        for (items, end) in [(&all[..], none), (&all[..1], last)] {
            let told = answer(&json!({"kind": "nothing-fits", "items": items}), &json!([]));
            let expected = format!("{begin} {end}; nothing was placed.");
            assert!(told.contains(&expected), "{told}");
        }
    }

    #[test]
    fn what_did_not_stay_is_told_by_its_kind() {
        let step = |item: &str, kind: Value| json!({"item": item, "unsteady": kind});
        let told = |steps: &[Value]| answer(&json!({"kind": "all-packed"}), &json!(steps));
        let steady = [step("mug", Value::Null)];
        let end = "with everything placed; every item stayed where it was placed.";
        assert!(told(&steady).contains(end), "{}", told(&steady));
        let steps = ["can", "cup", "box"].map(|item| step(item, json!("toppled")));
        let told = told(&[steps.as_slice(), &[step("jar", json!("fell out"))]].concat());
        let end = "; jar fell out, can, cup and box toppled.";
        assert!(told.contains(end), "{told}");
    }
}
