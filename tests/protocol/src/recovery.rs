//! Whether it goes on when all faults have ended.

use std::collections::HashSet;

use ppnpack_protocol::placing::Ending;
use ppnpack_wire::v1::ItemState;

use crate::action::Who;
use crate::{Action, Broken, Configuration, World};

/// Steps in which a decision comes to its end at the latest, once nothing fails any more.
const MOST_STEPS: usize = 400;

impl World {
    /// Whether everything was packed, and the session says so.
    pub fn is_packed(&self) -> bool {
        let session = &self.planner.session;
        let mut items = session.items().iter();
        !session.items().is_empty() && items.all(|item| item.state() == ItemState::Packed)
    }

    /// The promise that was broken; also that it goes on when all faults have ended.
    pub fn end(&self, configuration: &Configuration) -> Option<Broken> {
        match self.broken {
            None if !self.goes_on(configuration, &mut HashSet::new()) => Some(Broken::Stuck),
            broken => broken,
        }
    }

    /// Says whether what is pending comes to its end, and an item that waits is decided on, once
    /// nothing fails any more and people do what is asked of them. `known` are the fingerprints of
    /// worlds of which that is known; those on the way become known.
    pub(crate) fn goes_on(&self, configuration: &Configuration, known: &mut HashSet<u64>) -> bool {
        let mut world = self.clone();
        let mut way = Vec::new();
        for _ in 0..MOST_STEPS {
            let fingerprint = world.fingerprint();
            if world.is_at_rest(configuration) || known.contains(&fingerprint) {
                known.extend(way);
                return true;
            }
            way.push(fingerprint);
            let next = world.mended();
            let mut next = next.into_iter();
            let Some(after) = next.find_map(|action| world.after(action, configuration)) else {
                return false;
            };
            if after.broken.is_some() {
                known.extend(way);
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
    fn mended(&self) -> Vec<Action> {
        use Action::*;
        let mut actions = vec![
            StartBridge,
            StartPlanner,
            Write,
            Stop(Ending::Placed, true),
            Move,
        ];
        let people = || 0..self.people.len() as u8;
        actions.extend(people().flat_map(|person| [Resumed(person), Acknowledged(person)]));
        actions.extend(people().flat_map(|person| [Resume(person), Acknowledge(person)]));
        actions.push(BeginAnew);
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
        actions.push(Finish);
        actions
    }
}
