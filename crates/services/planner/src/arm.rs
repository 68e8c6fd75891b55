//! The arm of a cell: its check among those of a step, and the cycle that carries out a decision.
//!
//! The planner asks the arm itself, last, going through the placements by increasing value as a plan without services
//! does; so the choice is the same. A heuristic service would need the arm, what is around it and the meshes of the
//! items, and would have to be configured alike; it saves nothing, as the planner asks for a handful of placements.

use std::sync::Arc;
use std::time::Instant;

use ppnpack_packing::check::{Cost, ValidityCheck};
use ppnpack_packing::placement::RestingPlacement;
use ppnpack_packing::step::{Candidate, StageError, StepInput};
use ppnpack_robot::cycle::{Cycle, Leg};
use ppnpack_robot::station::ArmStation;
use ppnpack_robot::trajectory::Trajectory;
use ppnpack_wire::convert::cycle::{self, JointPoint, MAX_POINTS};
use ppnpack_wire::v1::{self, ArmLegKind};

use crate::remote::StepContext;

/// The distance of a trajectory's points, in seconds. Longer ones have [`MAX_POINTS`] at most.
const PERIOD_S: f64 = 0.01;

/// The shortest distance of two points, in seconds: nothing moves far within it.
const LEAST_S: f64 = 1e-6;

/// The arm's check, as long as there is time.
pub(crate) struct ArmInTime {
    station: ArmStation,
    context: Arc<StepContext>,
}

impl ArmInTime {
    pub(crate) fn new(station: &ArmStation, context: &Arc<StepContext>) -> Self {
        Self {
            station: station.clone(),
            context: Arc::clone(context),
        }
    }
}

impl ValidityCheck for ArmInTime {
    fn name(&self) -> &'static str {
        self.station.name()
    }

    fn cost(&self) -> Cost {
        self.station.cost()
    }

    fn rules_out(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
    ) -> Result<bool, StageError> {
        self.station.rules_out(input, candidate)
    }

    fn is_valid(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> Result<bool, StageError> {
        if Instant::now() >= self.context.deadline() {
            self.context.cut_checks();
            return Ok(false);
        }
        self.station.is_valid(input, candidate, resting)
    }
}

/// A cycle as a message.
pub(crate) fn write(station: &ArmStation, planned: &Cycle) -> v1::ArmCycle {
    let legs = planned.legs.iter();
    cycle::write(&cycle::Cycle {
        arm: station.parameters().name.clone(),
        cycle_s: planned.cycle_s,
        container_from_item_at_pick: planned.from.container_from_item,
        grasp_yaw_rad: planned.grasp_yaw_rad,
        grip_s: planned.grip_s,
        release_s: planned.release_s,
        legs: legs
            .map(|(leg, trajectory)| cycle::Leg {
                kind: kind(*leg),
                points: points(trajectory),
            })
            .collect(),
    })
}

fn kind(leg: Leg) -> ArmLegKind {
    match leg {
        Leg::Descend => ArmLegKind::Descend,
        Leg::Lift => ArmLegKind::Lift,
        Leg::Transfer => ArmLegKind::Transfer,
        Leg::Insert => ArmLegKind::Insert,
        Leg::Retreat => ArmLegKind::Retreat,
        Leg::Return => ArmLegKind::Return,
    }
}

/// Points of a trajectory, its end among them.
fn points(trajectory: &Trajectory) -> Vec<JointPoint> {
    let end_s = trajectory.duration_s();
    let longest = (MAX_POINTS - 1) as f64;
    let period_s = PERIOD_S.max(end_s / (longest - 1.0));
    let mut points: Vec<JointPoint> = Vec::new();
    for (time_s, joints) in trajectory.samples(period_s) {
        let position_rad = *joints.as_array();
        match points.last_mut() {
            // The end may come a hair after the point before it: it takes that one's place.
            Some(before) if time_s < before.time_s + LEAST_S => before.position_rad = position_rad,
            _ => points.push(JointPoint {
                time_s,
                position_rad,
            }),
        }
    }
    points
}

#[cfg(test)]
mod tests;
