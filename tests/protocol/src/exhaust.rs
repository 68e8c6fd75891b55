//! Every order in which everything can happen, by stateright.

use std::collections::HashSet;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use stateright::{Checker, Model, Path, Property};

use crate::{Action, Configuration, World};

/// A world as a model of stateright.
#[derive(Debug)]
pub struct Exhaust {
    configuration: Configuration,
    /// The fingerprints of worlds that go on: what comes to one of them goes on, too.
    going_on: Mutex<HashSet<u64>>,
}

/// What came of it.
#[derive(Debug)]
pub struct Exhausted {
    /// Different worlds that were reached.
    pub worlds: usize,
    /// Steps that were tried.
    pub steps: usize,
    /// The longest way to any of them.
    pub depth: usize,
    /// Whether all were reached in the time that there was.
    pub is_complete: bool,
    /// The shortest way to a broken promise, where there is one.
    pub broken: Option<Vec<Action>>,
    /// Whether everything was packed in one of them.
    pub packs: bool,
}

const KEPT: &str = "every promise is kept";
const GOES_ON: &str = "it goes on when all faults have ended";
const PACKS: &str = "everything can be packed";

impl Model for Exhaust {
    type State = World;
    type Action = Action;

    fn init_states(&self) -> Vec<World> {
        vec![World::new(&self.configuration)]
    }

    fn actions(&self, world: &World, actions: &mut Vec<Action>) {
        // After a promise is broken, more of it says nothing new.
        if world.broken.is_none() {
            actions.extend(world.actions(&self.configuration));
        }
    }

    fn next_state(&self, world: &World, action: Action) -> Option<World> {
        world.after(action, &self.configuration)
    }

    fn properties(&self) -> Vec<Property<Self>> {
        vec![
            Property::always(KEPT, |_, world: &World| world.broken.is_none()),
            Property::always(GOES_ON, |model: &Self, world: &World| {
                let mut known = model
                    .going_on
                    .lock()
                    .unwrap_or_else(PoisonError::into_inner);
                world.broken.is_some() || world.goes_on(&model.configuration, &mut known)
            }),
            Property::sometimes(PACKS, |_, world: &World| world.is_packed()),
        ]
    }
}

/// Goes through all of it, for so long at most.
pub fn exhaust(configuration: &Configuration, limit: Duration) -> Exhausted {
    let model = Exhaust {
        configuration: configuration.clone(),
        going_on: Mutex::default(),
    };
    let checker = model.checker().timeout(limit).spawn_bfs().join();
    let broken = [KEPT, GOES_ON]
        .iter()
        .find_map(|name| checker.discovery(name));
    Exhausted {
        worlds: checker.unique_state_count(),
        steps: checker.state_count(),
        depth: checker.max_depth(),
        is_complete: checker.is_done(),
        broken: broken.map(Path::into_actions),
        packs: checker.discovery(PACKS).is_some(),
    }
}
