//! `report.html`: one page that needs nothing else.

use anyhow::Context;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use minijinja::Environment;
use minijinja::value::Serde;
use ppnpack_packing::episode::Step;
use ppnpack_packing::grid::ContainerSize;
use serde::Serialize;

use super::arm::ArmWork;
use super::playback::{self, Playback};
use super::summary::{EndingSummary, Unplaceable};
use super::table::{duration, figures, percent};
use super::{Packing, Settled, Summary, words};
use crate::quantity::centimetres;

/// What the page is made of. The name has markup escaped in all that is filled in.
const TEMPLATE: (&str, &str) = ("report.html", include_str!("report.html"));

/// A page that fits screens of all sizes, light and dark, and paper.
#[derive(Serialize)]
struct Page<'a> {
    style: &'static str,
    viewer: String,
    /// The answer in a sentence, with the picture beside it.
    answer: String,
    aside: Option<String>,
    subtitle: String,
    /// The figures that are asked for first.
    tiles: Vec<(&'static str, String)>,
    packed_png: String,
    heightmap_png: String,
    charts: [Chart; 2],
    /// JSON that cannot end the script element that holds it; none where there is nothing to play, or too much.
    playback: Option<String>,
    /// The last position of the viewer's slider: there are two a step, as planned and as everything lay after it.
    last: usize,
    figures: Vec<(&'static str, String)>,
    set_aside: &'a [Unplaceable],
    most_set_aside: usize,
    unplaceable: &'a [Unplaceable],
    /// What the arm refused: placements by reason.
    refused: Vec<(&'a str, u64)>,
    arm_set_aside: &'a [Unplaceable],
    /// How many items were packed in another pose than that in which they were offered, where there were several.
    turned: Option<usize>,
    steps: Vec<Row<'a>>,
    settings: String,
}

/// A line over the items, from zero to its greatest value.
#[derive(Serialize)]
struct Chart {
    title: &'static str,
    /// The greatest value, with its unit.
    top: String,
    /// Places in a picture of [`Chart::SIZE`], y downwards.
    points: String,
}

impl Chart {
    /// The width and the height of the line's picture.
    const SIZE: [f64; 2] = [640.0, 260.0];

    fn new(title: &'static str, values: &[f64], told: fn(f64) -> String) -> Self {
        let top = values.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let [width, height] = Self::SIZE;
        let step = width / values.len().saturating_sub(1).max(1) as f64;
        let points = values.iter().enumerate().map(|(index, value)| {
            let (x, y) = (step * index as f64, height * (1.0 - value / top));
            format!("{x:.1},{y:.1}")
        });
        Self {
            title,
            top: told(top),
            points: points.collect::<Vec<_>>().join(" "),
        }
    }
}

/// A step: what compares between steps in columns, the rest where the item is opened.
#[derive(Serialize)]
struct Row<'a> {
    number: u64,
    item: &'a str,
    is_bad: bool,
    numbers: [String; 8],
    result: String,
    details: Vec<(&'static str, String)>,
}

/// The whole page.
pub(super) fn page(
    packing: &Packing,
    summary: &Summary,
    [packed_png, heightmap_png]: [&[u8]; 2],
) -> anyhow::Result<String> {
    let settings = &packing.settings;
    let ContainerSize { x_m, y_m, z_m } = settings.grid.container();
    let steps = packing.steps.iter().zip(&packing.settled);
    let playback = Playback::of(packing).map(|played| played.to_json());
    let arm = summary.arm.as_ref();
    let page = Page {
        style: include_str!("style.css"),
        viewer: playback::viewer(),
        answer: words::answer(packing, summary),
        aside: words::aside(packing, summary),
        subtitle: format!(
            "{} into a container of {}, on {} x {} cells",
            settings.sequence.from,
            centimetres([x_m, y_m, z_m]),
            settings.grid.nx(),
            settings.grid.ny(),
        ),
        tiles: tiles(summary),
        packed_png: STANDARD.encode(packed_png),
        heightmap_png: STANDARD.encode(heightmap_png),
        charts: charts(packing),
        playback: playback.transpose()?,
        last: 2 * packing.steps.len(),
        figures: figures(packing, summary),
        set_aside: &summary.set_aside,
        most_set_aside: settings.set_aside,
        unplaceable: match &summary.ending {
            EndingSummary::NothingFits { items } => items,
            _ => &[],
        },
        refused: arm.into_iter().flat_map(ArmWork::refused).collect(),
        arm_set_aside: arm.map_or(&[], |arm| &arm.set_aside),
        turned: (settings.poses > 1).then_some(summary.items_in_other_pose),
        steps: steps
            .map(|(step, settled)| row(packing, step, *settled))
            .collect(),
        settings: serde_json::to_string_pretty(settings)?,
    };
    let mut templates = Environment::new();
    let (name, text) = TEMPLATE;
    templates.add_template(name, text)?;
    let rendered = templates.get_template(name)?.render(Serde(page));
    rendered.context("the page cannot be made")
}

/// How the container fills, by the items' meshes, and how long each step took to decide.
fn charts(packing: &Packing) -> [Chart; 2] {
    let ContainerSize { x_m, y_m, z_m } = packing.settings.grid.container();
    let mut filled = vec![0.0];
    for (step, settled) in packing.steps.iter().zip(&packing.settled) {
        let volume_m3 = f64::from(u8::from(settled.inside)) * step.candidate.item.mesh_volume_m3();
        filled.push(filled.last().copied().unwrap_or_default() + volume_m3 / (x_m * y_m * z_m));
    }
    let steps = packing.steps.iter();
    let decisions: Vec<f64> = steps
        .map(|step| step.timings.total().as_secs_f64())
        .collect();
    [
        Chart::new(
            "Container filled by meshes, over the items placed",
            &filled,
            percent,
        ),
        Chart::new("Decision time, over the items placed", &decisions, duration),
    ]
}

fn tiles(summary: &Summary) -> Vec<(&'static str, String)> {
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
    tiles
}

fn row<'a>(packing: &'a Packing, step: &'a Step, settled: Settled) -> Row<'a> {
    let [x_cm, y_cm, z_cm] = packing.planned_cm(step);
    let inside = packing.lies(step.candidate.arrival);
    let inside = inside.is_some_and(|body| body.inside);
    let result = match settled.unsteadiness() {
        Some(what) => what,
        None if !inside => "not inside at the end".to_owned(),
        None => "stayed".to_owned(),
    };
    Row {
        number: step.step + 1,
        item: step.candidate.item.name(),
        is_bad: settled.is_unsteady() || !inside,
        numbers: [
            format!("{x_cm:.1}"),
            format!("{y_cm:.1}"),
            format!("{z_cm:.1}"),
            format!(
                "{:.0}",
                packing.yaw_rad(step).unwrap_or_default().to_degrees()
            ),
            format!("{:.2}", step.choice.value),
            milliseconds(step.timings.total()),
            format!("{:.1}", settled.slide_m * 1e3),
            format!("{:.0}", settled.tilt_rad.to_degrees()),
        ],
        result,
        details: details(packing, step),
    }
}

/// What an item shows when it is opened.
fn details(packing: &Packing, step: &Step) -> Vec<(&'static str, String)> {
    let or_none = |text: String| {
        if text.is_empty() {
            "none".to_owned()
        } else {
            text
        }
    };
    let alternatives = step.alternatives.iter();
    let alternatives: Vec<String> = alternatives
        .map(|other| format!("{:.2}", other.value))
        .collect();
    let timings = step.timings;
    let mut details = vec![
        ("Arrival", step.candidate.arrival.to_string()),
        ("Alternatives", or_none(alternatives.join(", "))),
        ("Propose (ms)", milliseconds(timings.propose)),
        ("Evaluate (ms)", milliseconds(timings.evaluate)),
        ("Check (ms)", milliseconds(timings.check)),
    ];
    if packing.settings.poses > 1 {
        details.push(("Pose", step.candidate.pose.to_string()));
    }
    if let Some(load) = &step.evidence.load {
        let (item, estimated_kg, carries_kg) = (&load.item, load.estimated_kg, load.carries_kg);
        let text = format!("{item} ({estimated_kg:.2} of {carries_kg:.2} kg)");
        details.push(("Rests on (of what it may carry)", text));
    }
    if packing.arm.is_some() {
        let cycle = step.cycle_s().map(|cycle_s| format!("{cycle_s:.2}"));
        details.push(("Cycle (s)", or_none(cycle.unwrap_or_default())));
    }
    if !step.degraded.is_empty() {
        details.push(("Not as asked for", step.degraded.join("; ")));
    }
    details
}

/// To a hundredth.
fn milliseconds(time: std::time::Duration) -> String {
    format!("{:.2}", time.as_secs_f64() * 1e3)
}
