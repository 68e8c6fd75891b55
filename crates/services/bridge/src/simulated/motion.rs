//! The simulated robot on its way: it follows the cycles that come with placements.

use std::time::{Duration, Instant};

use ppnpack_packing::motion::{JOINTS, Leg, LegKind};
use ppnpack_service::Shutdown;

/// How often the joints are where the motion says, in seconds of the motion.
const PERIOD_S: f64 = 0.01;

/// Where the joints of the robot are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointState {
    /// What the robot is doing.
    pub leg: LegKind,
    /// Since the leg's start, in seconds of the motion.
    pub time_s: f64,
    /// J1 to J6, in radians.
    pub joints_rad: [f64; JOINTS],
}

/// Is told where the joints are as they move.
pub type JointWatch = Box<dyn FnMut(JointState) + Send>;

/// Moves joints.
pub(super) struct Motion {
    /// Motion seconds per second; 0 for no wait.
    speed: f64,
    pub(super) watch: Option<JointWatch>,
}

impl Motion {
    pub(super) fn new(speed: f64) -> Self {
        Self { speed, watch: None }
    }

    /// Follows a leg from its first point to its last, in time. Says whether the end was asked for on the way: then the
    /// rest is not waited for.
    pub(super) fn follow(&mut self, leg: &Leg, end: &Shutdown) -> bool {
        let started = Instant::now();
        let duration_s = leg.duration_s();
        let steps = (duration_s / PERIOD_S).ceil() as u32;
        let mut is_ended = end.is_requested();
        for step in 0..=steps {
            let time_s = (f64::from(step) * PERIOD_S).min(duration_s);
            let due = started + self.span(time_s);
            is_ended |= end.wait_timeout(due.saturating_duration_since(Instant::now()));
            if let (Some(watch), Some(joints_rad)) = (&mut self.watch, leg.joints_rad(time_s)) {
                watch(JointState {
                    leg: leg.kind,
                    time_s,
                    joints_rad,
                });
            }
        }
        is_ended
    }

    /// Stands still, in seconds of the motion. Says whether the end was asked for meanwhile.
    pub(super) fn wait(&self, wait_s: f64, end: &Shutdown) -> bool {
        end.wait_timeout(self.span(wait_s))
    }

    fn span(&self, motion_s: f64) -> Duration {
        if self.speed > 0.0 {
            Duration::try_from_secs_f64(motion_s / self.speed).unwrap_or(Duration::MAX)
        } else {
            Duration::ZERO
        }
    }
}
