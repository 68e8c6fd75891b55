//! Plans of steps.

use ppnpack_packing::planning::plan;
use ppnpack_packing::ranking::step::{Candidate, Evaluated};
use pyo3::prelude::*;

use crate::placement::Placement;

/// The outcome of planning one step.
///
/// choice: the best valid placement, None where no item of the buffer has one. alternatives: the
/// next best ones, as many as were asked for. reasons: per item of the buffer why no placement was
/// valid in its first pose, None where one was or that is not known. degraded: why the step was not
/// planned as was asked for, where it was not. is_widened: whether no proposal was valid, so that
/// all placements were searched. is_cut: whether the time was over before everything was looked at.
/// took_s: how long it took, in seconds, by stage.
#[pyclass(frozen, get_all, module = "ppnpack")]
pub(crate) struct Plan {
    choice: Option<Placement>,
    alternatives: Vec<Placement>,
    reasons: Vec<Option<String>>,
    degraded: Vec<String>,
    is_widened: bool,
    is_cut: bool,
    took_s: Took,
}

/// Time by stage, in seconds.
#[derive(Clone, Copy, IntoPyObject, IntoPyObjectRef)]
struct Took {
    propose: f64,
    evaluate: f64,
    check: f64,
}

impl Plan {
    /// Converts a plan for these candidates.
    pub(crate) fn of(plan: &plan::Plan, candidates: &[Candidate]) -> Self {
        let placement = |found: &Evaluated, lowered_m: f64| {
            let held = candidates.get(found.candidate)?;
            let at = found.resting.placement;
            Some(Placement {
                yaw: at.yaw,
                x: at.x,
                y: at.y,
                resting_height: found.resting.resting_height,
                slot: held.arrival,
                pose: held.pose,
                value: Some(found.value),
                lowered_m,
            })
        };
        let lowered_m = plan.evidence().map_or(0.0, |evidence| evidence.lowered_m);
        let first_poses = candidates.iter().zip(plan.candidates());
        let first_poses = first_poses.filter(|(held, _)| held.pose == 0);
        let reasons = first_poses.map(|(_, report)| report.reason.as_ref());
        let alternatives = plan.alternatives();
        let alternatives = alternatives.filter_map(|found| placement(found, 0.0));
        let timings = plan.timings();
        Self {
            choice: plan.choice().and_then(|found| placement(&found, lowered_m)),
            alternatives: alternatives.collect(),
            reasons: reasons
                .map(|reason| reason.map(ToString::to_string))
                .collect(),
            degraded: plan.degraded().to_vec(),
            is_widened: plan.is_widened(),
            is_cut: plan.is_cut(),
            took_s: Took {
                propose: timings.propose.as_secs_f64(),
                evaluate: timings.evaluate.as_secs_f64(),
                check: timings.check.as_secs_f64(),
            },
        }
    }
}

#[pymethods]
impl Plan {
    fn __repr__(&self) -> String {
        let others = self.alternatives.len();
        match &self.choice {
            Some(_) => format!("<ppnpack.Plan with a choice and {others} alternatives>"),
            None => "<ppnpack.Plan without a choice>".to_owned(),
        }
    }
}
