//! Decisions, what came of them, and how long that took.

use std::collections::VecDeque;

use ppnpack_packing::kernel::grid::Grid;
use ppnpack_wire::v1;
use serde::Serialize;
use serde_json::{Value, json};

use super::known::KnownShapes;
use super::pose::{self, PosePart};
use super::words;

const MOST_DECISIONS: usize = 16;

const MOST_STEPS: usize = 256;

/// Maximum of explained items that are kept with a decision.
const MOST_EXPLAINED: usize = 64;

/// Shows the reason why an item is placed nowhere.
pub(super) fn reason_part(reason: &v1::ItemReason, object: &str) -> Value {
    json!({
        "item_id": reason.item_id,
        "object": object,
        "reason": words::short(reason.reason().as_str_name(), "REASON_"),
        "text": reason.text,
    })
}

/// Shows the load of an item, against what it may carry.
pub(super) fn load_part(load: &v1::Load) -> Value {
    json!({
        "item_id": load.item_id,
        "estimated_kg": load.estimated_kg,
        "carries_kg": load.carries_kg,
    })
}

/// Gives the yaw of a placement, and the lowest corner of its box, in the container frame.
fn corner(
    resting: Option<&v1::RestingPlacement>,
    grid: Option<&Grid>,
) -> (Option<f64>, Option<[f64; 3]>) {
    let Some((at, grid)) = resting.zip(grid) else {
        return (None, None);
    };
    let resolution = grid.resolution();
    let (cell_m, unit_m) = (resolution.cell_m(), resolution.height_unit_m());
    let yaw = usize::try_from(at.yaw).unwrap_or(usize::MAX);
    let corner_m = [
        f64::from(at.x) * cell_m,
        f64::from(at.y) * cell_m,
        f64::from(at.resting_height) * unit_m,
    ];
    let yaw_rad = resolution.yaws().radians().get(yaw).copied();
    (yaw_rad, Some(corner_m))
}

/// The knowledge that a decision is shown with.
pub(super) struct Context<'a> {
    pub(super) session: Option<&'a v1::Session>,
    pub(super) shapes: &'a KnownShapes,
    /// The grid of the decision's container.
    pub(super) grid: Option<&'a Grid>,
    pub(super) container: &'a str,
}

impl Context<'_> {
    /// Names the object that an item of the session is; empty where it is not known.
    pub(super) fn object(&self, item_id: &str) -> &str {
        let session = self.session;
        session.map_or("", |session| super::session::object(session, item_id))
    }

    /// Shows a placement of an item, which may be another than that of a decision.
    pub(super) fn placement(&self, item_id: &str, ranked: &v1::RankedPlacement) -> Value {
        let object = self.object(item_id);
        let session = self.session;
        let session_id = session.map_or("", |session| session.session_id.as_str());
        let shape = self.shapes.named(session_id, item_id, object, ranked.pose);
        let (yaw_rad, corner_m) = corner(ranked.placement.as_ref(), self.grid);
        json!({
            "item_id": item_id,
            "object": object,
            "pose": ranked.pose,
            "value": ranked.value,
            "shape": shape.map(|known| known.shape.to_string()),
            "yaw_rad": yaw_rad,
            "corner_m": corner_m,
        })
    }
}

/// A decision, and what became of it.
#[derive(Debug)]
pub(super) struct Decided {
    at_ms: u64,
    pub(super) decision: v1::Decision,
    /// The planned time of the arm, in seconds.
    cycle_s: Option<f64>,
    /// Its outcome, and when that was heard.
    outcome: Option<(u64, v1::Outcome)>,
    /// Whether it is not carried out, and nothing came of it.
    is_given_up: bool,
    /// The reasons that were explained for other items since.
    explained: Vec<v1::ItemReason>,
}

impl Decided {
    pub(super) fn part(&self, context: &Context<'_>) -> Value {
        let decision = &self.decision;
        let object = decision.object.as_str();
        let (session_id, item_id) = (&decision.session_id, &decision.item_id);
        let known = context
            .shapes
            .named(session_id, item_id, object, decision.pose);
        let placed = pose::read(decision.container_from_item.as_ref());
        let placed = known.zip(placed).map(|(known, at)| known.placed(&at));
        let (yaw_rad, corner_m) = corner(decision.placement.as_ref(), context.grid);
        let alternatives = decision.alternatives.iter().filter_map(|ranked| {
            let index = usize::try_from(ranked.candidate).ok()?;
            Some(context.placement(decision.buffer.get(index)?, ranked))
        });
        let others = decision.set_aside.iter().chain(&self.explained);
        let others = others.map(|reason| reason_part(reason, context.object(&reason.item_id)));
        json!({
            "decision_id": decision.decision_id,
            "at_ms": self.at_ms,
            "step": decision.step,
            "item_id": decision.item_id,
            "object": object,
            "container": context.container,
            "pose": decision.pose,
            "value": decision.value,
            "shape": known.map(|known| known.shape.to_string()),
            "container_from_shape": placed.as_ref().map(PosePart::from),
            "yaw_rad": yaw_rad,
            "corner_m": corner_m,
            "alternatives": alternatives.collect::<Vec<_>>(),
            "others": others.collect::<Vec<_>>(),
            "degraded": decision.degraded,
            "is_widened": decision.is_widened,
            "stages": decision.stages.iter().map(stage).collect::<Vec<_>>(),
            "plan_ms": plan_ms(decision),
            "cycle_s": self.cycle_s,
            "settling": decision.settling.as_ref().map(settling),
            "load": decision.load.as_deref().map(load_part),
            "outcome": self.outcome.as_ref().map(outcome),
            "is_given_up": self.is_given_up,
        })
    }
}

fn stage(timing: &v1::StageTiming) -> Value {
    json!({"stage": timing.stage, "ms": timing.duration_ns as f64 / 1e6})
}

fn plan_ms(decision: &v1::Decision) -> f64 {
    let stages = decision.stages.iter();
    stages.map(|stage| stage.duration_ns as f64).sum::<f64>() / 1e6
}

fn settling(settling: &v1::Settling) -> Value {
    json!({
        "tilt_rad": settling.tilt_rad,
        "slide_m": settling.slide_m,
        "disturbance_m": settling.disturbance_m,
        "is_still": settling.is_still,
        "above_rim_m": settling.above_rim_m,
    })
}

fn outcome((at_ms, outcome): &(u64, v1::Outcome)) -> Value {
    json!({
        "kind": words::short(outcome.kind().as_str_name(), "OUTCOME_KIND_"),
        "text": outcome.failure,
        "slide_m": outcome.slide_m,
        "tilt_rad": outcome.tilt_rad,
        "at_ms": at_ms,
    })
}

#[derive(Debug, Serialize)]
struct StepPart {
    #[serde(skip)]
    decision_id: String,
    #[serde(skip)]
    session_id: String,
    step: u64,
    at_ms: u64,
    plan_ms: f64,
    took_s: Option<f64>,
    cycle_s: Option<f64>,
}

/// The last decisions, newest first, and the times of the session's steps.
#[derive(Debug, Default)]
pub(super) struct Decisions {
    decisions: VecDeque<Decided>,
    steps: VecDeque<StepPart>,
}

impl Decisions {
    /// Takes in a decision; says whether it is a new one.
    pub(super) fn add(&mut self, at_ms: u64, mut decision: v1::Decision) -> bool {
        if self.find(&decision.decision_id).is_some() {
            return false;
        }
        // The motion of the arm is long, and nobody looks at it here.
        let cycle_s = decision.cycle.take().map(|cycle| cycle.cycle_s);
        self.steps.push_back(StepPart {
            decision_id: decision.decision_id.clone(),
            session_id: decision.session_id.clone(),
            step: decision.step,
            at_ms,
            plan_ms: plan_ms(&decision),
            took_s: None,
            cycle_s,
        });
        self.decisions.push_front(Decided {
            at_ms,
            decision,
            cycle_s,
            outcome: None,
            is_given_up: false,
            explained: Vec::new(),
        });
        self.decisions.truncate(MOST_DECISIONS);
        if self.steps.len() > MOST_STEPS {
            self.steps.pop_front();
        }
        true
    }

    /// Takes in the outcome of a decision; gives that, where it is known and had not ended yet.
    pub(super) fn end(&mut self, at_ms: u64, outcome: &v1::Outcome) -> Option<&v1::Decision> {
        let id = &outcome.placement_id;
        let mut steps = self.steps.iter_mut();
        if let Some(step) = steps.find(|step| step.decision_id == *id) {
            let took_ms = at_ms.saturating_sub(step.at_ms);
            step.took_s.get_or_insert(took_ms as f64 / 1e3);
        }
        let mut decisions = self.decisions.iter_mut();
        let decided = decisions.find(|decided| decided.decision.decision_id == *id)?;
        if decided.outcome.is_some() {
            return None;
        }
        decided.outcome = Some((at_ms, outcome.clone()));
        Some(&decided.decision)
    }

    /// Notes that a decision is not carried out; gives it, where it is known and had not ended.
    pub(super) fn give_up(&mut self, decision_id: &str) -> Option<&v1::Decision> {
        let mut decisions = self.decisions.iter_mut();
        let decided = decisions.find(|decided| decided.decision.decision_id == decision_id)?;
        decided.is_given_up = decided.outcome.is_none();
        decided.is_given_up.then_some(&decided.decision)
    }

    /// Takes in the reason why an item has no place.
    pub(super) fn explain(&mut self, reason: v1::ItemReason) {
        let Some(newest) = self.decisions.front_mut() else {
            return;
        };
        let explained = &mut newest.explained;
        explained.retain(|known| known.item_id != reason.item_id);
        explained.push(reason);
        let surplus = explained.len().saturating_sub(MOST_EXPLAINED);
        explained.drain(..surplus);
    }

    /// Forgets the times of other sessions' steps; this one's first decision may be known already.
    pub(super) fn begin(&mut self, session_id: &str) {
        self.steps.retain(|step| step.session_id == session_id);
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Decided> {
        self.decisions.iter()
    }

    pub(super) fn find(&self, decision_id: &str) -> Option<&Decided> {
        self.iter()
            .find(|decided| decided.decision.decision_id == decision_id)
    }

    /// Shows how long the steps of the session took.
    pub(super) fn cycles(&self) -> Value {
        let mean = |times: &dyn Fn(&StepPart) -> Option<f64>| {
            let times: Vec<f64> = self.steps.iter().filter_map(times).collect();
            (!times.is_empty()).then(|| times.iter().sum::<f64>() / times.len() as f64)
        };
        json!({
            "steps": self.steps,
            "mean_took_s": mean(&|step| step.took_s),
            "mean_cycle_s": mean(&|step| step.cycle_s),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decision(number: usize) -> v1::Decision {
        v1::Decision {
            decision_id: number.to_string(),
            step: number as u64,
            item_id: "i-1".to_owned(),
            buffer: vec!["i-1".to_owned(), "i-2".to_owned()],
            alternatives: vec![v1::RankedPlacement {
                candidate: 1,
                value: 2.5,
                placement: Some(v1::RestingPlacement {
                    yaw: 1,
                    x: 3,
                    y: 4,
                    resting_height: 10,
                }),
                ..v1::RankedPlacement::default()
            }],
            ..v1::Decision::default()
        }
    }

    #[test]
    fn the_last_decisions_are_kept_each_once_with_their_outcome() {
        let mut decisions = Decisions::default();
        for number in 0..300 {
            assert!(decisions.add(number as u64, decision(number)));
            assert!(!decisions.add(number as u64, decision(number)));
        }
        assert_eq!(decisions.decisions.len(), MOST_DECISIONS);
        assert_eq!(decisions.steps.len(), MOST_STEPS);
        let outcome = v1::Outcome {
            placement_id: "299".to_owned(),
            kind: v1::OutcomeKind::Placed.into(),
            ..v1::Outcome::default()
        };
        assert!(decisions.end(2_299, &outcome).is_some());
        assert!(decisions.end(9_999, &outcome).is_none(), "it has ended");
        let cycles = decisions.cycles();
        assert_eq!(cycles["mean_took_s"], json!(2.0));
        assert_eq!(cycles["mean_cycle_s"], json!(null));
        assert_eq!(cycles["steps"][255]["step"], json!(299));
    }

    #[test]
    fn a_decision_is_shown_with_its_alternatives_on_the_grid_of_its_container() {
        let mut decisions = Decisions::default();
        decisions.add(5, decision(0));
        let shapes = KnownShapes::default();
        let grid = Grid::reference();
        let context = Context {
            session: None,
            shapes: &shapes,
            grid: Some(&grid),
            container: "cell-1",
        };
        let part = decisions.iter().next().unwrap().part(&context);
        let alternative = &part["alternatives"][0];
        assert_eq!(alternative["item_id"], json!("i-2"));
        let corner: Vec<f64> = serde_json::from_value(alternative["corner_m"].clone()).unwrap();
        let mut pairs = corner.iter().zip([0.03, 0.04, 0.02]);
        assert!(pairs.all(|(a, b)| (a - b).abs() < 1e-12));
        assert_eq!(alternative["shape"], json!(null));
        assert_eq!(part["outcome"], json!(null));
        assert_eq!(part["corner_m"], json!(null), "it has no placement");
    }

    #[test]
    fn what_is_explained_stands_with_the_last_decision() {
        let mut decisions = Decisions::default();
        let reason = |text: &str| v1::ItemReason {
            item_id: "i-2".to_owned(),
            reason: v1::Reason::NoFit.into(),
            text: text.to_owned(),
        };
        decisions.explain(reason("nothing was decided"));
        decisions.add(5, decision(0));
        decisions.explain(reason("first"));
        decisions.explain(reason("second"));
        let explained = &decisions.decisions[0].explained;
        assert_eq!(explained, &[reason("second")]);
    }
}
