//! Tables for the terminal.

use ppnpack_packing::grid::Grid;

use super::arm::ArmWork;
use super::summary::{EndingSummary, NearestLimit, Spread, Unplaceable};
use super::words::MOST_NAMES;
use super::{Packing, Summary};
use crate::output;

/// Seconds for people.
pub(crate) fn duration(seconds: f64) -> String {
    match seconds {
        seconds if seconds < 1e-3 => format!("{:.0} µs", seconds * 1e6),
        seconds if seconds < 1.0 => format!("{:.2} ms", seconds * 1e3),
        seconds => format!("{seconds:.1} s"),
    }
}

/// A share for people.
pub(super) fn percent(share: f64) -> String {
    format!("{:.1} %", share * 100.0)
}

/// The summary of a packing.
pub(crate) fn summary(packing: &Packing, summary: &Summary) -> String {
    let mut rows = figures(packing, summary);
    rows.extend(summary.arm.iter().flat_map(ArmWork::refusals));
    rows.extend(summary.degraded.iter().map(|degraded| {
        let text = format!("{} steps: {}", degraded.steps, degraded.reason);
        ("not as asked for", text)
    }));
    let named = |what, items| by_reason(items).into_iter().map(move |text| (what, text));
    rows.extend(named("set aside", &summary.set_aside));
    if let EndingSummary::NothingFits { items } = &summary.ending {
        rows.extend(named("could not be placed", items));
    }
    output::rows(rows)
}

/// The items with the same reason together, in the order in which the reasons first come.
fn by_reason(items: &[Unplaceable]) -> Vec<String> {
    let mut groups: Vec<(&str, Vec<&str>)> = Vec::new();
    for item in items {
        match groups.iter_mut().find(|(reason, _)| *reason == item.reason) {
            Some((_, names)) => names.push(&item.item),
            None => groups.push((&item.reason, vec![&item.item])),
        }
    }
    let text = |(reason, names): (&str, Vec<&str>)| {
        let others = names.len().saturating_sub(MOST_NAMES);
        let shown = names.get(..MOST_NAMES).unwrap_or(&names).join(", ");
        match others {
            0 => format!("{shown}: {reason}"),
            others => format!("{shown} and {others} more: {reason}"),
        }
    };
    groups.into_iter().map(text).collect()
}

/// The figures of a packing, named, for people.
pub(crate) fn figures(packing: &Packing, summary: &Summary) -> Vec<(&'static str, String)> {
    let metrics = &summary.metrics;
    let cm3 = |volume_m3: f64| format!("{:.0} cm³", volume_m3 * 1e6);
    let sequence = &packing.settings.sequence;
    let fallen = match summary.items_fallen_out {
        0 => String::new(),
        count => format!(", {count} more fell out"),
    };
    let packed = format!(
        "{} of {} items{fallen}",
        metrics.packed.items,
        sequence.objects.len()
    );
    let Spread { mean, median, max } = summary.decision_s;
    let [mean, median, max] = [mean, median, max].map(duration);
    let ending = match &summary.ending {
        EndingSummary::AllPacked => "everything is packed".to_owned(),
        EndingSummary::OthersSetAside => "everything that was not set aside is packed".to_owned(),
        EndingSummary::NothingFits { items } => {
            let count = items.len();
            format!("none of the {count} items in the buffer has a valid placement")
        }
    };
    let mut figures = vec![
        ("Sequence", sequence.from.clone()),
        (
            "Proposals",
            packing.settings.method.method.proposals.to_string(),
        ),
        ("Packed", packed),
        ("Volume of the meshes", cm3(metrics.packed.meshes_m3)),
        ("Volume of the voxels", cm3(metrics.packed.voxels_m3)),
        (
            "Compactness by the floor (voxels)",
            percent(metrics.floor_compactness),
        ),
        (
            "Compactness by the bounding box (voxels)",
            percent(metrics.box_compactness),
        ),
        (
            "Compactness by the floor (meshes)",
            percent(metrics.mesh_floor_compactness),
        ),
        ("Container filled (meshes)", percent(metrics.utilisation)),
        (
            "Unsteady when placed",
            format!(
                "{} of {} items",
                summary.items_unsteady, summary.items_placed
            ),
        ),
        ("Height", height(&packing.settings.grid, summary.height_m)),
        (
            "Decision per item",
            format!("{mean} mean, {median} median, {max} at most"),
        ),
        ("Whole run", duration(summary.took_s)),
        ("Ended because", ending),
    ];
    if summary.steps_widened > 0 {
        let text = format!("{} of {} steps", summary.steps_widened, packing.steps.len());
        figures.push(("Searched exhaustively, as nothing proposed was valid", text));
    }
    if let Some(NearestLimit {
        step,
        item,
        estimated_kg,
        carries_kg,
    }) = &summary.nearest_limit
    {
        let step = step + 1;
        let text =
            format!("{item} with {estimated_kg:.2} of {carries_kg:.2} kg, since step {step}");
        figures.push(("Nearest to what it may carry", text));
    }
    let settings = &packing.settings;
    if settings.set_aside > 0 {
        let count = summary.set_aside.len();
        let text = format!("{count} of at most {} items", settings.set_aside);
        figures.push(("Set aside", text));
    }
    if settings.poses > 1 {
        let (turned, placed) = (summary.items_in_other_pose, summary.items_placed);
        let text = format!("{turned} of {placed} items");
        figures.push(("In another pose than offered", text));
    }
    figures.extend(summary.arm.iter().flat_map(ArmWork::figures));
    figures
}

/// How high the content reaches, and how far above the rim; heightmaps round up to a whole unit.
fn height(grid: &Grid, height_m: f64) -> String {
    let above_m = height_m - grid.container().z_m;
    let text = format!("{:.1} cm", height_m * 100.0);
    match above_m > 1.5 * grid.resolution().height_unit_m() {
        true => format!("{text}, {:.1} cm above the rim", above_m * 100.0),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_sticks_out_above_the_rim_is_told_but_for_the_rounding() {
        let grid = Grid::reference();
        assert_eq!(height(&grid, 0.298), "29.8 cm");
        assert_eq!(height(&grid, 0.302), "30.2 cm");
        assert_eq!(height(&grid, 0.304), "30.4 cm, 0.4 cm above the rim");
        assert_eq!(height(&grid, 0.326), "32.6 cm, 2.6 cm above the rim");
    }
}
