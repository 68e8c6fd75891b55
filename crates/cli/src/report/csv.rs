//! `placements.csv`: a line per placed item.

use ppnpack_packing::streams::episode::Step;
use serde::Serialize;

use super::{Packing, Settled};

/// A placed item. What is said of the end is where the item's own frame is in the container frame.
#[derive(Debug, Serialize)]
pub(super) struct Line<'a> {
    step: u64,
    arrival: usize,
    item: &'a str,
    /// 0: as it was offered.
    pose: usize,
    yaw_rad: f64,
    cell_x: usize,
    cell_y: usize,
    resting_height_m: f64,
    value: f64,
    decision_s: f64,
    propose_s: f64,
    evaluate_s: f64,
    check_s: f64,
    slide_m: f64,
    tilt_rad: f64,
    /// The item below that it brought nearest to what that may carry, what rests on it as
    /// estimated, and what may.
    loaded_item: Option<&'a str>,
    loaded_kg: Option<f64>,
    loaded_limit_kg: Option<f64>,
    toppled: bool,
    inside_at_the_end: bool,
    end_x_m: Option<f64>,
    end_y_m: Option<f64>,
    end_z_m: Option<f64>,
    end_qw: Option<f64>,
    end_qx: Option<f64>,
    end_qy: Option<f64>,
    end_qz: Option<f64>,
    /// The planned time of the arm's cycle; a column only where there is an arm.
    #[serde(skip_serializing_if = "Option::is_none")]
    cycle_s: Option<Option<f64>>,
}

impl<'a> Line<'a> {
    pub(super) fn of(packing: &Packing, step: &'a Step, settled: Settled) -> Self {
        let arrival = step.candidate.arrival;
        let body = packing.lies(arrival);
        let pose = body.map(|body| body.container_from_item);
        let resting = step.choice.resting;
        let height_unit_m = packing.settings.grid.resolution().height_unit_m();
        let load = step.evidence.load.as_ref();
        Self {
            step: step.step,
            arrival,
            item: step.candidate.item.name(),
            pose: step.candidate.pose,
            yaw_rad: packing.yaw_rad(step).unwrap_or(f64::NAN),
            cell_x: resting.placement.x,
            cell_y: resting.placement.y,
            resting_height_m: f64::from(resting.resting_height) * height_unit_m,
            value: step.choice.value,
            decision_s: step.timings.total().as_secs_f64(),
            propose_s: step.timings.propose.as_secs_f64(),
            evaluate_s: step.timings.evaluate.as_secs_f64(),
            check_s: step.timings.check.as_secs_f64(),
            slide_m: settled.slide_m,
            tilt_rad: settled.tilt_rad,
            loaded_item: load.map(|load| load.item.as_str()),
            loaded_kg: load.map(|load| load.estimated_kg),
            loaded_limit_kg: load.map(|load| load.carries_kg),
            toppled: settled.toppled,
            inside_at_the_end: body.is_some_and(|body| body.inside),
            end_x_m: pose.map(|pose| pose.translation.x),
            end_y_m: pose.map(|pose| pose.translation.y),
            end_z_m: pose.map(|pose| pose.translation.z),
            end_qw: pose.map(|pose| pose.rotation.w),
            end_qx: pose.map(|pose| pose.rotation.i),
            end_qy: pose.map(|pose| pose.rotation.j),
            end_qz: pose.map(|pose| pose.rotation.k),
            cycle_s: packing.arm.as_ref().map(|_| step.cycle_s()),
        }
    }
}

/// The lines of all placed items.
pub(super) fn placements(packing: &Packing) -> anyhow::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for (step, settled) in packing.steps.iter().zip(&packing.settled) {
        writer.serialize(Line::of(packing, step, *settled))?;
    }
    Ok(writer.into_inner()?)
}
