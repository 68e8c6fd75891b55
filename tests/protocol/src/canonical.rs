//! Equality of worlds: two are equal where the same can happen from now on.
//!
//! A name counts by where it comes first, a state by its place in the order of all: both are only
//! compared with others. People are alike, and so are controllers. Of a decision that nobody
//! pursues and that is of a past state counts only that its request may still arrive. A world keeps
//! all of it nevertheless, so that what is past is tried in each that is reached.

use std::hash::{DefaultHasher, Hash, Hasher};

use ppnpack_protocol::ledger::{BRIDGE, Ledger, Record};
use ppnpack_protocol::session::Session;
use ppnpack_wire::v1;
use prost::Message;

use crate::driver::{Answer, Ask, Call, Driver, Settled};
use crate::people::Person;
use crate::shared::Shared;
use crate::world::{Job, Motion, World};

impl Hash for World {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.fingerprint().hash(state);
    }
}

impl World {
    /// Gives the same number for worlds that are equal.
    pub(crate) fn fingerprint(&self) -> u64 {
        let orders = |count: usize| [false, true].into_iter().take(count.clamp(1, 2));
        let orders = orders(self.people.len())
            .flat_map(|people| orders(self.controllers.len()).map(move |others| (people, others)));
        let sketches = orders.map(|(people, controllers)| Sketch::of(self, people, controllers));
        sketches.min().unwrap_or_default()
    }
}

/// Gives what is in a slice, in its order or the opposite one.
fn ordered<T>(slice: &[T], is_reversed: bool) -> impl Iterator<Item = &T> {
    let at = move |index| match is_reversed {
        true => slice.len() - 1 - index,
        false => index,
    };
    (0..slice.len()).filter_map(move |index| slice.get(at(index)))
}

/// A world on its way into a hash: all but names and states is hashed at once.
struct Sketch<'a> {
    world: &'a World,
    plain: DefaultHasher,
    states: Vec<u64>,
    names: Vec<&'a str>,
    /// The sessions on the planner's disk and in its backup.
    sessions: [Option<&'a Shared<Session>>; 2],
    /// The ledgers on the bridge's disk and in its backup.
    ledgers: [Option<&'a Shared<Ledger>>; 2],
    /// The decisions that these sessions await.
    pending: [Option<usize>; 2],
    /// The decisions that somebody pursues, or of which the state is not past.
    live: Vec<usize>,
}

impl<'a> Sketch<'a> {
    fn of(world: &'a World, reverses_people: bool, reverses_controllers: bool) -> u64 {
        let (planner, bridge) = (&world.planner, &world.bridge);
        let sessions = [Some(&planner.session), planner.backup.as_ref()];
        let pending = sessions.map(|session| {
            let id = &session?.pending()?.decision_id;
            world.decision_no(id)
        });
        let mut sketch = Self {
            world,
            plain: DefaultHasher::new(),
            states: Vec::new(),
            names: Vec::new(),
            sessions,
            ledgers: [Some(&bridge.ledger), bridge.backup.as_ref()],
            pending,
            live: Vec::new(),
        };
        let numbers = 0..world.decided.len();
        sketch.live = numbers.filter(|number| sketch.is_live(*number)).collect();
        sketch.plain((planner.is_up, bridge.is_up, &world.items, world.must_look));
        sketch.plain((world.happened, world.broken, world.decided.len()));
        sketch.robot();
        sketch.sessions();
        for person in ordered(&world.people, reverses_people) {
            sketch.person(person);
        }
        sketch.ledgers();
        for number in 0..world.decided.len() {
            sketch.decision(number);
        }
        sketch.driver(&planner.driver);
        for driver in ordered(&world.controllers, reverses_controllers) {
            sketch.driver(driver);
        }
        sketch.pictures();
        sketch.finish()
    }

    fn plain(&mut self, value: impl Hash) {
        value.hash(&mut self.plain);
    }

    fn is_live(&self, number: usize) -> bool {
        let Self { world, pending, .. } = self;
        let mut drivers = world.controllers.iter().chain([&world.planner.driver]);
        let head = world.bridge.ledger.head();
        let ended = self.ends_in(0, number);
        pending.contains(&Some(number))
            || drivers.any(|driver| driver.decision == Some(number))
            || world.motion == Some(Motion::Place(number))
            || world.bridge.job == Some(Job::Place(number))
            || ended == Some(None)
            || self.state_of(number) >= head.state_number
    }

    fn state_of(&self, number: usize) -> u64 {
        let decided = self.world.decided.get(number);
        decided.map_or(0, |decided| decided.decision.state_number)
    }

    /// Gives what a ledger knows of a decision: nothing, that it was begun, or how it ended and in
    /// which state.
    fn ends_in(&self, ledger: usize, number: usize) -> Option<Option<(u8, u64)>> {
        let ledger = self.ledgers.get(ledger).copied().flatten()?;
        let decided = self.world.decided.get(number)?;
        let (_, outcome) = ledger.placement(&decided.decision.decision_id)?;
        Some(outcome.map(|ended| (ended.finding.ending as u8, ended.state_number)))
    }

    /// Enters a decision by its place among those that live.
    fn number(&mut self, number: Option<usize>) {
        let place = number.map(|number| self.live.iter().position(|live| *live == number));
        self.plain(place);
    }

    fn robot(&mut self) {
        let World { motion, bridge, .. } = self.world;
        self.number(match motion {
            Some(Motion::Place(number)) => Some(*number),
            Some(Motion::Renew) | None => None,
        });
        let (kind, number) = match &bridge.job {
            None => (0, None),
            Some(Job::Place(number)) => (1, Some(*number)),
            Some(Job::Placed(finding)) => (2 + finding.ending as u8, None),
            Some(Job::Renew) => (6, None),
            Some(Job::Renewed) => (7, None),
        };
        self.plain((kind, motion.is_some()));
        self.number(number);
    }

    fn sessions(&mut self) {
        for (session, pending) in self.sessions.into_iter().zip(self.pending) {
            self.plain(session.map(|session| session.hash_by(hash_session)));
            self.states
                .extend(session.map(|session| session.least_state_number("")));
            self.number(pending);
        }
    }

    fn person(&mut self, person: &'a Person) {
        let Person {
            holds,
            hold,
            ended,
            failure,
        } = person;
        let fails = self
            .sessions
            .map(|session| session.and_then(|session| session.failure_id()));
        let fails = fails.map(|own| own.as_ref() == Some(failure));
        self.plain((holds, hold.is_empty(), failure.is_empty(), fails));
        self.names.push(hold);
        // What holds no more and nobody can hold again is the same whatever it was.
        let ledgers = self.ledgers.into_iter().flatten();
        let held = ledgers.flat_map(|ledger| ledger.head().holds.iter().map(|hold| &hold.id));
        let held: Vec<&String> = held
            .chain(self.world.people.iter().map(|person| &person.hold))
            .collect();
        let (live, past): (Vec<_>, Vec<_>) = ended.iter().partition(|name| held.contains(name));
        self.plain((live.len(), past.is_empty()));
        self.names.extend(live.into_iter().map(String::as_str));
    }

    fn ledgers(&mut self) {
        for ledger in self.ledgers {
            self.plain(ledger.map(|ledger| ledger.hash_by(hash_ledger)));
            let Some(ledger) = ledger else { continue };
            let mut holds: Vec<_> = ledger.head().holds.iter().collect();
            let place = |id: &str| self.names.iter().position(|name| *name == id);
            holds.sort_by_cached_key(|hold| {
                (place(&hold.id).unwrap_or(usize::MAX), hold.holder == BRIDGE)
            });
            self.plain(holds.len());
            for hold in holds {
                self.plain(hold.holder == BRIDGE);
                self.names.push(&hold.id);
            }
            self.states
                .extend(ledger.records().filter_map(|(_, record)| match record {
                    Record::Renewal { state_number, .. } => *state_number,
                    Record::Placement { .. } => None,
                }));
        }
        // A backup is of a state that none has, once it is put back.
        let head = self.world.bridge.ledger.head();
        self.states
            .extend([head.first_state_number, head.state_number]);
    }

    fn decision(&mut self, number: usize) {
        let Some(decided) = self.world.decided.get(number) else {
            return;
        };
        let ends = [0, 1].map(|ledger| self.ends_in(ledger, number));
        if !self.live.contains(&number) {
            self.plain((0_u8, decided.is_sent, ends.map(|known| known.is_some())));
            return;
        }
        self.plain((
            1_u8,
            decided.item,
            decided.shown,
            decided.is_sent,
            decided.begun,
            decided.settled,
        ));
        self.states.push(self.state_of(number));
        for known in ends {
            self.plain(known.map(|ended| ended.map(|(kind, _)| kind)));
            if let Some(Some((_, state))) = known {
                self.ends_at(number, state);
            }
        }
        let mut published = self.world.published.iter();
        let heard = published.find(|outcome| outcome.placement_id == decided.decision.decision_id);
        self.plain(heard.map(|outcome| outcome.kind));
        if let Some(outcome) = heard {
            self.ends_at(number, outcome.state_number);
        }
    }

    /// Enters the state in which a decision ended, where a session still takes it.
    fn ends_at(&mut self, number: usize, state: u64) {
        if self.pending.contains(&Some(number)) {
            self.states.push(state);
        }
    }

    fn driver(&mut self, driver: &Driver) {
        let Driver {
            decision,
            call,
            is_accepted,
            settling,
            is_held,
            outcome,
        } = driver;
        self.number(*decision);
        self.plain((is_accepted, settling, is_held));
        let number = decision.unwrap_or(usize::MAX);
        self.plain(outcome.as_ref().map(|Settled(outcome)| outcome.kind));
        if let Some(Settled(outcome)) = outcome {
            self.ends_at(number, outcome.state_number);
        }
        let Some(Call { ask, answer }) = call else {
            self.plain(0_u8);
            return;
        };
        self.plain(match ask {
            Ask::Place(_) => 1_u8,
            Ask::Outcome(_) => 2,
            Ask::State => 3,
        });
        match answer {
            None => self.plain(0_u8),
            Some(Answer::Refused(status)) => self.plain((1_u8, status)),
            Some(Answer::Execution(execution)) => {
                let outcome = execution.outcome.as_ref();
                self.plain((2_u8, outcome.map(|outcome| outcome.kind)));
                if let Some(outcome) = outcome {
                    self.ends_at(number, outcome.state_number);
                }
            }
            // It is read as what a decision is settled by, or as whether the cell is held.
            Some(Answer::State {
                first_state_number,
                state_number,
                ..
            }) if settling.is_some() => {
                self.plain((3_u8, *first_state_number <= self.state_of(number)));
                self.ends_at(number, *state_number);
            }
            Some(Answer::State { is_held, .. }) => self.plain((4_u8, is_held)),
        }
    }

    /// Enters the pictures that a session may still plan on; one that was lost begins anew at the
    /// present state.
    fn pictures(&mut self) {
        let present = self.world.bridge.ledger.head().state_number;
        let least = self
            .sessions
            .into_iter()
            .flatten()
            .map(|session| match session.id() {
                "" => present,
                _ => session.least_state_number(""),
            });
        let least = least.min().unwrap_or_default();
        let pictures = self.world.pictures.range((least, 0)..);
        self.plain(pictures.clone().count());
        for (state, content) in pictures {
            self.plain(content);
            self.states.push(*state);
        }
    }

    fn finish(mut self) -> u64 {
        let mut order = self.states.clone();
        order.sort_unstable();
        order.dedup();
        for state in std::mem::take(&mut self.states) {
            self.plain(order.binary_search(&state));
        }
        let names = std::mem::take(&mut self.names);
        for name in &names {
            self.plain(names.iter().position(|first| first == name));
        }
        self.plain.finish()
    }
}

/// Hashes a session without its names, its states, its decision, and what was settled, which is
/// nobody's any more.
fn hash_session(session: &Session, state: &mut DefaultHasher) {
    let mut message = v1::Session {
        pending: None,
        step: 0,
        failure: String::new(),
        least_state_number: 0,
        settled: Vec::new(),
        past_session_ids: Vec::new(),
        failure_id: String::new(),
        failures: 0,
        ..session.to_message(0)
    };
    message.session_id.truncate(1);
    for container in &mut message.containers {
        container.least_state_number = 0;
    }
    message.encode_to_vec().hash(state);
}

/// Hashes a ledger without its names, its states and its placements.
fn hash_ledger(ledger: &Ledger, state: &mut DefaultHasher) {
    let head = ledger.head();
    // Whether anything was ever begun is asked of it, and not how often.
    (head.next == 1, head.placements_left).hash(state);
    for body in &head.bodies {
        body.item_id.hash(state);
    }
    for (_, record) in ledger.records() {
        if let Record::Renewal {
            request_id,
            state_number,
        } = record
        {
            (request_id, state_number.is_some()).hash(state);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::action::Who;
    use crate::configuration::Fault;
    use crate::{Action, Configuration, World};

    #[test]
    fn it_makes_no_difference_who_of_several_does_something_but_what_is_done() {
        let world = Configuration::automatic("alike").by_controllers(2);
        let world = world.by_people(2).with(&[(Fault::Hold, 2)]);
        let after = |actions: &[Action]| {
            let begun = World::new(&world);
            let mut actions = actions.iter();
            let ended = actions.try_fold(begun, |now, action| now.after(*action, &world));
            ended.unwrap().fingerprint()
        };
        let decide = |who| Action::Decide(Who::Controller(who), 1_000, 0);
        assert_eq!(after(&[decide(0)]), after(&[decide(1)]));
        let [one, other] = [[0, 1], [1, 0]].map(|people| people.map(Action::Hold));
        assert_eq!(after(&one), after(&other));
        assert_eq!(after(&one[..1]), after(&other[..1]));
        let different = [&[][..], &[decide(0)], &one[..1], &one].map(after);
        for (index, print) in different.iter().enumerate() {
            assert!(!different[..index].contains(print), "{index}");
        }
    }
}
