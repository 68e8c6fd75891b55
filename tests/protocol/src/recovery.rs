//! Whether it goes on when all faults have ended.

use ppnpack_protocol::placing::Ending;

use crate::action::Who;
use crate::{Action, Configuration, World};

/// Steps in which a decision comes to its end at the latest, once nothing fails any more.
const MOST_STEPS: usize = 60;

impl World {
    /// Whether everything was packed, and the session says so.
    pub fn is_packed(&self) -> bool {
        let session = &self.planner.session;
        let packed = session.items().iter();
        let mut packed = packed.map(|item| {
            matches!(
                item.state,
                ppnpack_protocol::session::ItemState::Packed { .. }
            )
        });
        !session.items().is_empty() && packed.all(|is_packed| is_packed)
    }

    /// Whether what is pending comes to its end, and an item that waits is decided on, once nothing fails any more and people do what
    /// is asked of them.
    pub fn goes_on(&self, configuration: &Configuration) -> bool {
        let mut world = self.clone();
        for _ in 0..MOST_STEPS {
            if world.is_at_rest(configuration) {
                return true;
            }
            let next = world.mended(configuration);
            let mut next = next.into_iter();
            let Some(after) = next.find_map(|action| world.after(action, configuration)) else {
                return false;
            };
            if after.broken().is_some() {
                return true;
            }
            world = after;
        }
        false
    }

    fn is_at_rest(&self, configuration: &Configuration) -> bool {
        let session = &self.planner.session;
        let is_settled = session.pending().is_none() && self.motion.is_none();
        let is_up = self.planner.is_up && self.bridge.is_up && self.bridge.job.is_none();
        let has_decided = self.decided.len() >= usize::from(configuration.decisions);
        let waits = session.buffer(1).next().is_some();
        let is_lost = session.id().is_empty();
        is_up && is_settled && !is_lost && (has_decided || !waits)
    }

    /// What happens next where nothing fails, in the order in which it is tried.
    fn mended(&self, configuration: &Configuration) -> Vec<Action> {
        use Action::*;
        let mut actions = vec![
            StartBridge,
            StartPlanner,
            Write,
            Stop(Ending::Placed, true),
            Move,
            Resume,
            Acknowledge,
            BeginAnew,
        ];
        for who in self.drivers() {
            actions.extend([Receive(who), Arrive(who)]);
            if let Who::Controller(controller) = who {
                actions.extend([Report(controller), TakeUp(controller)]);
            }
            actions.push(Ask(who));
        }
        // The newest picture, which shows the cell as it is.
        let newest = (self.bridge.ledger.head().state_number, self.content());
        if self.pictures.contains(&newest) {
            let (state, content) = newest;
            actions.extend(
                self.drivers()
                    .into_iter()
                    .map(|who| Decide(who, state, content)),
            );
        }
        let _ = configuration;
        actions.push(Finish);
        actions
    }
}
