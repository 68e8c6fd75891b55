//! The table of steps in the page: what compares between steps in columns, the rest where an item is opened.

use ppnpack_packing::episode::Step;

use super::html::escape;
use super::{Packing, Settled, Summary};

/// The section with all steps.
pub(super) fn section(packing: &Packing, summary: &Summary) -> String {
    let rows = packing.steps.iter().zip(&packing.settled);
    let rows: String = rows
        .map(|(step, settled)| row(packing, step, *settled))
        .collect();
    format!(
        "<h2>Steps</h2><p class=sub>{}</p><div class=scroll role=region tabindex=0 aria-label=\"Table of the steps\"><table>\
         <thead><tr><th scope=col>Step and item<th class=n scope=col>x (cm)<th class=n scope=col>y (cm)<th class=n scope=col>z (cm)\
         <th class=n scope=col>Yaw (°)<th class=n scope=col>Value<th class=n scope=col>Decision (ms)<th class=n scope=col>Slide (mm)\
         <th class=n scope=col>Tilt (°)<th scope=col>Result</tr></thead><tbody>{rows}</tbody></table></div>",
        legend(packing, summary)
    )
}

/// What the table's words mean.
fn legend(packing: &Packing, summary: &Summary) -> String {
    let poses = match summary.items_in_other_pose {
        _ if packing.settings.poses <= 1 => String::new(),
        turned => format!(
            " Packed in another pose than that in which it was offered: {turned} of {} items. That is pose 0, the others \
             are numbered by falling probability.",
            summary.items_placed
        ),
    };
    format!(
        "An item opens for more. Alternatives are the values of the next best valid placements; slide and tilt are what became of \
         it when it was let go.{poses}"
    )
}

fn row(packing: &Packing, step: &Step, settled: Settled) -> String {
    let resolution = packing.settings.grid.resolution();
    let cell_cm = resolution.cell_m() * 100.0;
    let unit_cm = resolution.height_unit_m() * 100.0;
    let at = step.choice.resting;
    let inside = packing.lies(step.candidate.arrival);
    let inside = inside.is_some_and(|body| body.inside);
    let result = match settled.unsteadiness() {
        Some(what) => what,
        None if !inside => "not inside at the end".to_owned(),
        None => "stayed".to_owned(),
    };
    let is_bad = settled.is_unsteady() || !inside;
    let class = if is_bad { " class=bad" } else { "" };
    let details = details(packing, step).into_iter();
    let details = details.map(|(name, value)| format!("<dt>{name}<dd>{}", escape(&value)));
    format!(
        "<tr{class}><th scope=row><details><summary>{} {}</summary><dl>{}</dl></details></th><td class=n>{:.1}<td class=n>{:.1}\
         <td class=n>{:.1}<td class=n>{:.0}<td class=n>{:.2}<td class=n>{}<td class=n>{:.1}<td class=n>{:.0}<td>{result}</tr>",
        step.step + 1,
        escape(step.candidate.item.name()),
        details.collect::<String>(),
        at.placement.x as f64 * cell_cm,
        at.placement.y as f64 * cell_cm,
        f64::from(at.resting_height) * unit_cm,
        packing.yaw_rad(step).unwrap_or_default().to_degrees(),
        step.choice.value,
        milliseconds(step.timings.total()),
        settled.slide_m * 1e3,
        settled.tilt_rad.to_degrees()
    )
}

/// What an item shows when it is opened.
fn details(packing: &Packing, step: &Step) -> Vec<(&'static str, String)> {
    let alternatives = step.alternatives.iter();
    let alternatives = alternatives.map(|other| format!("{:.2}", other.value));
    let alternatives: Vec<String> = alternatives.collect();
    let timings = step.timings;
    let none = || "none".to_owned();
    let mut details = vec![
        ("Arrival", step.candidate.arrival.to_string()),
        (
            "Alternatives",
            match alternatives.is_empty() {
                true => none(),
                false => alternatives.join(", "),
            },
        ),
        ("Propose (ms)", milliseconds(timings.propose)),
        ("Evaluate (ms)", milliseconds(timings.evaluate)),
        ("Check (ms)", milliseconds(timings.check)),
    ];
    if packing.settings.poses > 1 {
        details.push(("Pose", step.candidate.pose.to_string()));
    }
    if let Some(load) = &step.evidence.load {
        let text = format!(
            "{} ({:.2} of {:.2} kg)",
            load.item, load.estimated_kg, load.carries_kg
        );
        details.push(("Rests on (of what it may carry)", text));
    }
    if packing.arm.is_some() {
        let cycle = step.cycle_s();
        let cycle = cycle.map_or_else(none, |cycle_s| format!("{cycle_s:.2}"));
        details.push(("Cycle (s)", cycle));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_in_milliseconds_as_the_head_says() {
        assert_eq!(
            milliseconds(std::time::Duration::from_micros(1_234)),
            "1.23"
        );
        assert_eq!(milliseconds(std::time::Duration::from_secs(2)), "2000.00");
    }
}
