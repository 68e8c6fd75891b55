//! The status of a cell: what it does now, in a sentence, and which parts of the picture are old.

use std::collections::BTreeSet;

use ppnpack_wire::keys::{Cell, Service};
use ppnpack_wire::v1::{self, ItemState, SessionEnd};
use serde::Serialize;

use super::place::Place;
use super::services::Services;
use super::session::{address, count, is_begun};
use super::words;

/// Maximum age of a state, in milliseconds: bridges tell theirs every few seconds, and are asked
/// besides.
const STATE_AGE_MS: u64 = 25_000;

/// How long heightmaps may show an earlier state than the bridge tells, in milliseconds: robot and
/// sensor take a moment.
const BEHIND_MS: u64 = 5_000;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Doing {
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

/// The status of a cell, for the top of a page.
#[derive(Debug, Serialize)]
pub(super) struct StatusPart<'a> {
    doing: Doing,
    text: String,
    help: Option<&'static str>,
    stale: Vec<String>,
    /// The reasons of all `holds`: nothing is begun.
    held: Option<String>,
    holds: BTreeSet<&'a str>,
    /// The id of the failure that `text` tells of; empty where there is none.
    failure_id: &'a str,
    is_moving: bool,
}

/// The knowledge that the status of a cell is told from.
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
        let held = self.held();
        let is_moving = self.executing().is_some();
        let (doing, text, help) = self.doing(&stale, held.as_deref(), is_moving);
        let holds = self.places.iter().flat_map(|(_, place)| place.hold_ids());
        StatusPart {
            doing,
            text,
            help,
            stale,
            held,
            holds: holds.collect(),
            failure_id: self.session.map_or("", |session| &session.failure_id),
            is_moving,
        }
    }

    /// Gives the reasons why containers are held, each once.
    fn held(&self) -> Option<String> {
        let held = self.places.iter().filter_map(|(_, place)| place.held());
        let held: BTreeSet<&str> = held.collect();
        let held: Vec<&str> = held.into_iter().collect();
        (!held.is_empty()).then(|| held.join("; "))
    }

    fn executing(&self) -> Option<&'a str> {
        self.places.iter().find_map(|(_, place)| place.executing())
    }

    /// Gives the containers that are not held: robots of their own are held each.
    fn not_held(&self) -> Vec<&'a str> {
        let going = self.places.iter().filter(|(_, place)| {
            let state = place.state.as_ref();
            state.is_some_and(|state| state.hold.is_none())
        });
        going.map(|(name, _)| name.as_str()).collect()
    }

    /// Says what is away or old, a sentence each.
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

    fn doing(&self, stale: &[String], held: Option<&str>, is_moving: bool) -> Said {
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
            return said(Doing::Unknown, "Nothing is heard of this cell.");
        }
        if let Some(first) = stale.first() {
            let text = format!("What it does is not known. {first}");
            let help = "It goes on by itself as soon as that is back. What is shown is what was heard last.";
            return (Doing::Unknown, text, Some(help));
        }
        let Some(session) = self.session.filter(|session| is_begun(session)) else {
            return said(Doing::Idle, "Nothing is to be packed: there is no session.");
        };
        ended(session).unwrap_or_else(|| self.under_way(session, is_moving))
    }

    fn under_way(&self, session: &v1::Session, is_moving: bool) -> Said {
        let packed = count(session, ItemState::Packed);
        let waiting = count(session, ItemState::Waiting);
        let all = packed + waiting + count(session, ItemState::Decided);
        let step = format!("{} of {all}", (packed + 1).min(all));
        if let Some(decision) = &session.pending {
            let item = words::item(&decision.object, &decision.item_id);
            let container = address(self.cell, &decision.container);
            let verb = match is_moving {
                true => "Placing",
                false => "About to place",
            };
            let text = format!("{verb} {item} into {container} ({step}).");
            return said(Doing::Placing, text);
        }
        if is_moving {
            return said(Doing::Placing, "Placing an item.");
        }
        if waiting == 0 {
            return said(Doing::Waiting, "Waiting for items.");
        }
        if !session.containers.is_empty() && session.containers.iter().all(|it| !it.is_open) {
            return said(Doing::Waiting, "Waiting for an empty container.");
        }
        let seen = self.places.iter().filter_map(|it| it.1.seen.as_ref());
        if let Some(doubt) = seen.flat_map(|seen| &seen.doubts).next() {
            let text = format!("Waiting for a picture without doubt: {doubt}");
            let help = "Nothing is planned on a doubtful picture.";
            return (Doing::Waiting, text, Some(help));
        }
        if !session.is_automatic {
            let text =
                format!("A controller decides when to go on ({step}): the automatic mode is off.");
            return said(Doing::Manual, text);
        }
        let text = format!("Planning the next placement ({step}).");
        said(Doing::Planning, text)
    }
}

/// The activity of a cell, in words, and what people can do about it.
pub(super) type Said = (Doing, String, Option<&'static str>);

fn said(doing: Doing, text: impl Into<String>) -> Said {
    (doing, text.into(), None)
}

/// Says how a session ended, if it has.
pub(super) fn ended(session: &v1::Session) -> Option<Said> {
    let packed = words::items(count(session, ItemState::Packed));
    let (text, help) = match session.end() {
        SessionEnd::Unspecified => return None,
        SessionEnd::Failed => {
            let text = format!("Stopped: {}", session.failure);
            let help = "Look into the cell, say what was changed there, then switch the automatic mode on.";
            return Some((Doing::Failed, text, Some(help)));
        }
        SessionEnd::AllPacked => (format!("everything is packed, {packed}."), None),
        SessionEnd::OthersSetAside => {
            let aside = words::items(count(session, ItemState::SetAside));
            let text = format!("{packed} packed, {aside} set aside for the next container.");
            (text, Some("A new container takes what is set aside."))
        }
        SessionEnd::NothingFits => {
            let text = format!("{packed} packed, and nothing that waits has a place any more.");
            (text, Some("A new container takes what waits."))
        }
    };
    Some((Doing::Ended, format!("Done: {text}"), help))
}

#[cfg(test)]
mod tests {
    use super::super::tests;
    use super::Doing::{Failed, Idle, Manual, Placing, Planning, Waiting};
    use super::*;

    fn all_ready() -> Services {
        let mut services = Services::default();
        let found = [Service::Planner, Service::Bridge, Service::Perception].map(|service| {
            let health = v1::HealthReply {
                is_ready: true,
                ..v1::HealthReply::default()
            };
            (tests::found(service, &[]), health)
        });
        services.look(0, found.into());
        services
    }

    fn session(states: &[ItemState]) -> v1::Session {
        let items = states.iter().map(|state| tests::item("i", "mug", *state));
        tests::session(items.collect())
    }

    fn held(reason: Option<&str>) -> Place {
        let mut place = Place::default();
        place.hear_state(0, tests::state(&[], reason));
        place
    }

    /// Gives the status of a cell with these containers after 12 seconds.
    fn told(
        session: Option<&v1::Session>,
        places: &[(&str, Place)],
        services: &Services,
    ) -> (Doing, String) {
        let names: Vec<Cell> = places.iter().map(|it| tests::cell(it.0)).collect();
        let situation = Situation {
            cell: &tests::cell("c1"),
            session,
            places: names.iter().zip(places.iter().map(|it| &it.1)).collect(),
            services,
            now_ms: 12_000,
        };
        let part = situation.part();
        (part.doing, part.text)
    }

    #[test]
    fn a_cell_says_what_it_does() {
        let packing = session(&[ItemState::Packed, ItemState::Waiting]);
        let placing = v1::Session {
            pending: Some(v1::Decision {
                object: "mug".to_owned(),
                ..v1::Decision::default()
            }),
            ..packing.clone()
        };
        let failed = v1::Session {
            end: SessionEnd::Failed.into(),
            failure: "it was lost".to_owned(),
            ..session(&[ItemState::Waiting])
        };
        let manual = v1::Session {
            is_automatic: false,
            ..session(&[ItemState::Waiting])
        };
        let (empty, none) = (session(&[ItemState::Packed]), v1::Session::default());
        for (session, expected, text) in [
            (packing, Planning, "Planning the next placement (2 of 2)."),
            (placing, Placing, "About to place mug into c1 (2 of 2)."),
            (failed, Failed, "Stopped: it was lost"),
            (empty, Waiting, "Waiting for items."),
            (none, Idle, "Nothing is to be packed"),
            (
                manual,
                Manual,
                "A controller decides when to go on (1 of 1)",
            ),
        ] {
            let (doing, said) = told(Some(&session), &[("c1", held(None))], &all_ready());
            assert_eq!(doing, expected);
            assert!(said.starts_with(text), "{said}");
        }
    }

    #[test]
    fn a_held_cell_says_so_before_anything_else_and_names_what_is_not_held() {
        let (services, door) = (Services::default(), || held(Some("a door is open")));
        let said = told(Some(&session(&[])), &[("c1", door())], &services);
        assert_eq!(said, (Doing::Held, "Held: a door is open".to_owned()));
        let places = [("c1-a", door()), ("c1-b", held(None))];
        let (_, text) = told(None, &places, &services);
        assert_eq!(text, "Held, but for c1-b: a door is open");
    }

    #[test]
    fn without_a_planner_nothing_is_said_to_be_going_on() {
        let mut services = all_ready();
        services.look(1_000, vec![]);
        let session = session(&[ItemState::Waiting]);
        let (doing, text) = told(Some(&session), &[("c1", held(None))], &services);
        assert_eq!(doing, Doing::Unknown);
        let away = "The planner has been away for 11 s.";
        assert!(text.contains(away), "{text}");
    }
}
