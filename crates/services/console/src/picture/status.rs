//! What a cell does now, in a sentence, and what of the picture is old.

use ppnpack_wire::keys::{Cell, Service};
use ppnpack_wire::v1::{self, ItemState, SessionEnd};
use serde::Serialize;

use super::place::Place;
use super::services::Services;
use super::session::{address, count, is_begun};
use super::words;

/// A state that was told longer ago, in milliseconds, is old: bridges tell theirs every few seconds, and are asked besides.
const STATE_AGE_MS: u64 = 25_000;

/// How long a heightmap may show an earlier state than the bridge tells, in milliseconds: robot and sensor take a moment.
const BEHIND_MS: u64 = 5_000;

/// What a cell does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum Doing {
    Placing,
    Planning,
    Waiting,
    Held,
    Ended,
    Failed,
    Manual,
    Idle,
    Unknown,
}

/// What a cell does, for the top of a page.
#[derive(Debug, Serialize)]
pub(super) struct StatusPart<'a> {
    doing: Doing,
    text: String,
    help: Option<&'static str>,
    stale: Vec<String>,
    held: Option<&'a str>,
    is_moving: bool,
}

/// What is known of a cell.
pub(super) struct Situation<'a> {
    pub(super) cell: &'a Cell,
    pub(super) session: Option<&'a v1::Session>,
    pub(super) places: Vec<(&'a Cell, &'a Place)>,
    pub(super) services: &'a Services,
    pub(super) now_ms: u64,
}

impl<'a> Situation<'a> {
    pub(super) fn part(&self) -> StatusPart<'a> {
        let stale = self.stale();
        let held = self.places.iter().find_map(|(_, place)| place.held());
        let is_moving = self.executing().is_some();
        let (doing, text, help) = self.doing(&stale, held, is_moving);
        StatusPart {
            doing,
            text,
            help,
            stale,
            held,
            is_moving,
        }
    }

    /// The placement that is being made.
    fn executing(&self) -> Option<&'a str> {
        self.places.iter().find_map(|(_, place)| place.executing())
    }

    /// The containers that are not held: robots of their own are held each.
    fn not_held(&self) -> Vec<&'a str> {
        let going = self.places.iter().filter(|(_, place)| {
            let state = place.state.as_ref();
            state.is_some_and(|state| state.hold.is_none())
        });
        going.map(|(name, _)| name.as_str()).collect()
    }

    /// What is away or old, a sentence each.
    fn stale(&self) -> Vec<String> {
        let now_ms = self.now_ms;
        let mut stale: Vec<String> = Vec::new();
        let mut say = |sentence: String| {
            if !stale.contains(&sentence) {
                stale.push(sentence);
            }
        };
        let planner = self.services.trouble(Service::Planner, self.cell, now_ms);
        planner.into_iter().for_each(&mut say);
        for (name, place) in &self.places {
            for service in [Service::Bridge, Service::Perception] {
                let trouble = self.services.trouble(service, name, now_ms);
                trouble.into_iter().for_each(&mut say);
            }
            if place.state.is_some() && now_ms.saturating_sub(place.state_at_ms) > STATE_AGE_MS {
                let age = words::seconds(place.state_at_ms, now_ms);
                say(format!("The state of {name} was told {age} ago."));
            }
            if let Some(since_ms) = place.behind_since_ms
                && now_ms.saturating_sub(since_ms) > BEHIND_MS
                && place.executing().is_none()
            {
                let age = words::seconds(since_ms, now_ms);
                say(format!(
                    "The picture of {name} shows what was there {age} ago."
                ));
            }
        }
        stale
    }

    fn doing(
        &self,
        stale: &[String],
        held: Option<&str>,
        is_moving: bool,
    ) -> (Doing, String, Option<&'static str>) {
        if let Some(reason) = held {
            let going = self.not_held();
            let text = match (going.is_empty(), is_moving) {
                (false, _) => format!("Held, but for {}: {reason}", going.join(", ")),
                (true, true) => format!("Held, once what is under way has ended: {reason}"),
                (true, false) => format!("Held: {reason}"),
            };
            let help = "Say what was changed in the cell, then resume when nobody is in it.";
            return (Doing::Held, text, Some(help));
        }
        let is_heard =
            self.session.is_some() || self.places.iter().any(|(_, place)| place.state.is_some());
        if !is_heard {
            return (
                Doing::Unknown,
                "Nothing is heard of this cell.".to_owned(),
                None,
            );
        }
        if let Some(first) = stale.first() {
            let help = "It goes on by itself as soon as that is back. What is shown is what was heard last.";
            return (
                Doing::Unknown,
                format!("What it does is not known. {first}"),
                Some(help),
            );
        }
        let Some(session) = self.session.filter(|session| is_begun(session)) else {
            return (
                Doing::Idle,
                "Nothing is to be packed: there is no session.".to_owned(),
                None,
            );
        };
        self.ended(session)
            .unwrap_or_else(|| self.under_way(session, is_moving))
    }

    fn ended(&self, session: &v1::Session) -> Option<(Doing, String, Option<&'static str>)> {
        let packed = words::items(count(session, ItemState::Packed));
        Some(match session.end() {
            SessionEnd::Unspecified => return None,
            SessionEnd::AllPacked => (
                Doing::Ended,
                format!("Done: everything is packed, {packed}."),
                None,
            ),
            SessionEnd::OthersSetAside => {
                let aside = words::items(count(session, ItemState::SetAside));
                let text =
                    format!("Done: {packed} packed, {aside} set aside for the next container.");
                (
                    Doing::Ended,
                    text,
                    Some("A new container takes what is set aside."),
                )
            }
            SessionEnd::NothingFits => {
                let text =
                    format!("Done: {packed} packed, and nothing that waits has a place any more.");
                (
                    Doing::Ended,
                    text,
                    Some("A new container takes what waits."),
                )
            }
            SessionEnd::Failed => {
                let text = format!("Stopped: {}", session.failure);
                let help = "Look into the cell, say what was changed there, then switch the automatic mode on.";
                (Doing::Failed, text, Some(help))
            }
        })
    }

    fn under_way(
        &self,
        session: &v1::Session,
        is_moving: bool,
    ) -> (Doing, String, Option<&'static str>) {
        let packed = count(session, ItemState::Packed);
        let all = packed + count(session, ItemState::Waiting) + count(session, ItemState::Decided);
        let step = format!("{} of {all}", (packed + 1).min(all));
        if let Some(decision) = &session.pending {
            let item = words::item(&decision.object, &decision.item_id);
            let container = address(self.cell, &decision.container);
            let verb = if is_moving {
                "Placing"
            } else {
                "About to place"
            };
            return (
                Doing::Placing,
                format!("{verb} {item} into {container} ({step})."),
                None,
            );
        }
        if is_moving {
            return (Doing::Placing, "Placing an item.".to_owned(), None);
        }
        if count(session, ItemState::Waiting) == 0 {
            return (Doing::Waiting, "Waiting for items.".to_owned(), None);
        }
        if !session.containers.is_empty() && session.containers.iter().all(|it| !it.is_open) {
            return (
                Doing::Waiting,
                "Waiting for an empty container.".to_owned(),
                None,
            );
        }
        let doubts = self
            .places
            .iter()
            .filter_map(|(_, place)| place.seen.as_ref());
        if let Some(doubt) = doubts.flat_map(|seen| &seen.doubts).next() {
            let help = "Nothing is planned on a doubtful picture.";
            return (
                Doing::Waiting,
                format!("Waiting for a picture without doubt: {doubt}"),
                Some(help),
            );
        }
        if !session.is_automatic {
            let text =
                format!("A controller decides when to go on ({step}): the automatic mode is off.");
            return (Doing::Manual, text, None);
        }
        (
            Doing::Planning,
            format!("Planning the next placement ({step})."),
            None,
        )
    }
}

#[cfg(test)]
mod tests {
    use ppnpack_wire::keys::Instance;

    use super::super::services::{FoundService, Health};
    use super::*;

    fn all_ready() -> Services {
        let mut services = Services::default();
        let found =
            [Service::Planner, Service::Bridge, Service::Perception].map(|service| FoundService {
                service,
                instance: Instance::new("x").unwrap(),
                cells: vec![],
                health: Ok(Health {
                    is_ready: true,
                    ..Health::default()
                }),
            });
        services.look(0, found.into());
        services
    }

    fn session(states: &[ItemState]) -> v1::Session {
        let item = |state: &ItemState| v1::SessionItem {
            state: (*state).into(),
            ..v1::SessionItem::default()
        };
        v1::Session {
            session_id: "s".to_owned(),
            is_automatic: true,
            items: states.iter().map(item).collect(),
            ..v1::Session::default()
        }
    }

    fn told(
        session: Option<&v1::Session>,
        state: v1::CellState,
        services: &Services,
    ) -> (Doing, String) {
        let cell = Cell::new("c1").unwrap();
        let mut place = Place::default();
        place.hear_state(0, state);
        let situation = Situation {
            cell: &cell,
            session,
            places: vec![(&cell, &place)],
            services,
            now_ms: 12_000,
        };
        let part = situation.part();
        (part.doing, part.text)
    }

    #[test]
    fn a_cell_says_what_it_does() {
        let services = all_ready();
        let says = |session: &v1::Session| told(Some(session), v1::CellState::default(), &services);
        let mut packing = session(&[ItemState::Packed, ItemState::Waiting]);
        assert_eq!(
            says(&packing),
            (
                Doing::Planning,
                "Planning the next placement (2 of 2).".to_owned()
            )
        );
        packing.pending = Some(v1::Decision {
            object: "mug".to_owned(),
            ..v1::Decision::default()
        });
        assert_eq!(
            says(&packing),
            (
                Doing::Placing,
                "About to place mug into c1 (2 of 2).".to_owned()
            )
        );
        let mut failed = session(&[ItemState::Waiting]);
        failed.set_end(SessionEnd::Failed);
        failed.failure = "it was lost".to_owned();
        assert_eq!(
            says(&failed),
            (Doing::Failed, "Stopped: it was lost".to_owned())
        );
        assert_eq!(says(&session(&[ItemState::Packed])).0, Doing::Waiting);
        assert_eq!(says(&v1::Session::default()).0, Doing::Idle);
        let manual = v1::Session {
            is_automatic: false,
            ..session(&[ItemState::Waiting])
        };
        assert_eq!(says(&manual).0, Doing::Manual);
    }

    #[test]
    fn a_held_cell_says_so_before_anything_else() {
        let hold = v1::Hold {
            reason: "a door is open".to_owned(),
        };
        let state = v1::CellState {
            hold: Some(hold),
            ..v1::CellState::default()
        };
        let services = Services::default();
        let (doing, text) = told(Some(&session(&[])), state, &services);
        assert_eq!(
            (doing, text.as_str()),
            (Doing::Held, "Held: a door is open")
        );
    }

    #[test]
    fn what_is_not_held_of_a_held_cell_is_named() {
        let [cell, one, other] = ["c1", "c1-a", "c1-b"].map(|name| Cell::new(name).unwrap());
        let (mut held, mut going) = (Place::default(), Place::default());
        let hold = v1::Hold {
            reason: "a door is open".to_owned(),
        };
        held.hear_state(
            0,
            v1::CellState {
                hold: Some(hold),
                ..v1::CellState::default()
            },
        );
        going.hear_state(0, v1::CellState::default());
        let situation = Situation {
            cell: &cell,
            session: None,
            places: vec![(&one, &held), (&other, &going)],
            services: &Services::default(),
            now_ms: 0,
        };
        assert_eq!(situation.part().text, "Held, but for c1-b: a door is open");
    }

    #[test]
    fn without_a_planner_nothing_is_said_to_be_going_on() {
        let mut services = all_ready();
        services.look(1_000, vec![]);
        let (doing, text) = told(
            Some(&session(&[ItemState::Waiting])),
            v1::CellState::default(),
            &services,
        );
        assert_eq!(doing, Doing::Unknown);
        assert!(
            text.contains("The planner has been away for 11 s."),
            "{text}"
        );
    }
}
