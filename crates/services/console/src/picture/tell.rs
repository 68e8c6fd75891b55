//! The changes that news make in the picture, and the events among them.

use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1::{self, ItemState, OutcomeKind};

use super::log::Level;
use super::session::{address, is_begun, object};
use super::status::{self, Doing};
use super::{Picture, SeenContainer, words};
use crate::shapes::Wanted;

impl Picture {
    /// Notes an event of a cell, or of the cell of a container.
    pub(super) fn note(&mut self, at_ms: u64, of: &Cell, level: Level, kind: &str, text: String) {
        let cell = self.owner(of);
        if let Some(known) = self.cell(&cell) {
            known.log.note(at_ms, level, kind, text);
        }
    }

    pub(super) fn hear_state(&mut self, at_ms: u64, container: &Cell, state: v1::CellState) {
        let cell = self.owner(container);
        let was_held = self.is_held(&cell);
        let before = self.places.get(container);
        let before = before.and_then(|place| place.state.as_ref());
        let removed = before.map_or(0, |before| removed(before, &state));
        let Some(place) = self.place(container) else {
            return;
        };
        place.hear_state(at_ms, state);
        let reason = place.held().map(str::to_owned);
        let is_held = self.is_held(&cell);
        let told = match reason {
            Some(reason) if !was_held => Some((Level::Warning, "held", format!("Held: {reason}"))),
            None if was_held && !is_held => {
                Some((Level::Info, "resumed", "The cell goes on.".to_owned()))
            }
            _ => None,
        };
        if let Some((level, kind, text)) = told {
            self.note(at_ms, &cell, level, kind, text);
        }
        if removed > 0 {
            let text = format!("{} left {container}.", words::items(removed));
            self.note(at_ms, &cell, Level::Info, "changed", text);
        }
    }

    fn is_held(&self, cell: &Cell) -> bool {
        let containers = self.containers_of(cell);
        let mut places = containers.iter().filter_map(|name| self.places.get(name));
        places.any(|place| place.held().is_some())
    }

    pub(super) fn hear_outcome(&mut self, at_ms: u64, container: &Cell, outcome: &v1::Outcome) {
        let cell = self.owner(container);
        let Some(known) = self.cell(&cell) else {
            return;
        };
        let Some(decision) = known.decisions.end(at_ms, outcome) else {
            return;
        };
        let item = words::item(&decision.object, &decision.item_id);
        let why = match outcome.failure.as_str() {
            "" => ".".to_owned(),
            failure => format!(": {failure}"),
        };
        let (level, text) = match outcome.kind() {
            OutcomeKind::Placed => (
                Level::Info,
                format!("{item} was placed into {container}{why}"),
            ),
            OutcomeKind::NotPlaced => (Level::Warning, format!("{item} was not placed{why}")),
            OutcomeKind::Lost => (Level::Error, format!("{item} was lost{why}")),
            OutcomeKind::Unknown | OutcomeKind::Unspecified => (
                Level::Error,
                format!("What became of {item} is not known{why}"),
            ),
        };
        let kind = words::short(outcome.kind().as_str_name(), "OUTCOME_KIND_");
        self.note(at_ms, &cell, level, &kind, text);
    }

    pub(super) fn see(&mut self, at_ms: u64, container: &Cell, seen: SeenContainer) {
        let doubt = seen.doubts.first().cloned();
        let Some(place) = self.place(container) else {
            return;
        };
        let before = place.seen.as_ref();
        let was_doubtful = before.is_some_and(|seen| !seen.doubts.is_empty());
        place.see(at_ms, seen);
        match (was_doubtful, doubt) {
            (false, Some(doubt)) => {
                let text = format!("The picture of {container} is doubtful: {doubt}");
                self.note(at_ms, container, Level::Warning, "doubtful", text);
            }
            (true, None) => {
                let text = format!("The picture of {container} is clear.");
                self.note(at_ms, container, Level::Info, "clear", text);
            }
            _ => {}
        }
    }

    pub(super) fn hear_decision(&mut self, at_ms: u64, cell: &Cell, decision: v1::Decision) {
        let item = words::item(&decision.object, &decision.item_id);
        let into = address(cell, &decision.container);
        let text = format!("Step {}: {item} goes into {into}.", decision.step + 1);
        let is_degraded = !decision.degraded.is_empty();
        let Some(known) = self.cell(cell) else {
            return;
        };
        if known.decisions.add(at_ms, decision) {
            let level = match is_degraded {
                true => Level::Warning,
                false => Level::Info,
            };
            known.log.note(at_ms, level, "decided", text);
        }
    }

    pub(super) fn learn(&mut self, cell: &Cell, record: &v1::PlanningRecord) -> Option<Wanted> {
        let known = self.cell(cell)?;
        let shapes = known.shapes.learn(record).into_iter().collect();
        Some(Wanted {
            cell: cell.clone(),
            shapes,
        })
    }

    pub(super) fn hear_session(&mut self, at_ms: u64, cell: &Cell, session: v1::Session) {
        let Some(known) = self.cell(cell) else {
            return;
        };
        let before = known.session.take().unwrap_or_default();
        let is_new = before.session_id != session.session_id;
        if is_new {
            known.decisions.begin(&session.session_id);
        }
        for (level, kind, text) in events(cell, &before, &session) {
            known.log.note(at_ms, level, kind, text);
        }
        let given_up = given_up(&before, &session);
        if let Some(decision) = given_up.and_then(|id| known.decisions.give_up(id)) {
            let item = words::item(&decision.object, &decision.item_id);
            let step = decision.step + 1;
            let text = format!("Step {step} was given up: {item} waits again.");
            known.log.note(at_ms, Level::Warning, "given_up", text);
        }
        // A decision of before this was heard of, or whose message was lost.
        let pending = session.pending.clone();
        known.session = Some(session);
        if let Some(pending) = pending {
            self.hear_decision(at_ms, cell, pending);
        }
        if is_new {
            for container in self.containers_of(cell) {
                if let Some(place) = self.places.get_mut(&container) {
                    place.begin();
                }
            }
        }
    }
}

/// Gives the id of the decision that a session has given up, so that its item waits again.
fn given_up<'a>(before: &'a v1::Session, now: &v1::Session) -> Option<&'a str> {
    let pending = before.pending.as_ref()?;
    let is_pending = |it: &v1::Decision| it.decision_id == pending.decision_id;
    let mut items = now.items.iter();
    let item = items.find(|item| item.item_id == pending.item_id)?;
    let waits = item.state() == ItemState::Waiting;
    let is_given_up = before.session_id == now.session_id
        && waits
        && !now.pending.as_ref().is_some_and(is_pending);
    is_given_up.then_some(&pending.decision_id)
}

/// Counts the items that lie in a container no more.
fn removed(before: &v1::CellState, now: &v1::CellState) -> usize {
    let is_there = |item_id: &String| now.bodies.iter().any(|body| body.item_id == *item_id);
    let before = before.bodies.iter();
    before.filter(|body| !is_there(&body.item_id)).count()
}

type NewEvent = (Level, &'static str, String);

/// Gives the events between two states of a cell's session.
fn events(cell: &Cell, before: &v1::Session, now: &v1::Session) -> Vec<NewEvent> {
    let is_other = before.session_id != now.session_id;
    let mut told = Vec::new();
    if is_other && is_begun(now) {
        let items = words::items(now.items.len());
        let text = format!("Session {} is under way, with {items}.", now.session_id);
        told.push((Level::Info, "session", text));
    } else if !is_other {
        changes(cell, before, now, &mut told);
    }
    if is_other || before.end() != now.end() {
        told.extend(ended(now));
    }
    told
}

/// Tells what was set aside, closed and opened between two states of the same session.
fn changes(cell: &Cell, before: &v1::Session, now: &v1::Session, told: &mut Vec<NewEvent>) {
    for v1::ItemReason { item_id, text, .. } in &now.set_aside {
        if !before.set_aside.iter().any(|it| it.item_id == *item_id) {
            let item = words::item(object(now, item_id), item_id);
            let text = format!("{item} is set aside: {text}");
            told.push((Level::Warning, "set_aside", text));
        }
    }
    for closed in &now.closed {
        if !before.closed.contains(closed) {
            let name = address(cell, &closed.container);
            let items = words::items(usize::try_from(closed.items).unwrap_or(usize::MAX));
            let text = format!("{name} is closed with {items}: {}", closed.text);
            told.push((Level::Info, "closed", text));
        }
    }
    for container in now.containers.iter().filter(|it| it.is_open) {
        let key = |it: &v1::SessionContainer| (it.container.clone(), it.sequence);
        let mut before = before.containers.iter().filter(|it| it.is_open);
        if !before.any(|it| key(it) == key(container)) {
            let name = address(cell, &container.container);
            let text = format!("An empty container stands at {name}.");
            told.push((Level::Info, "opened", text));
        }
    }
}

fn ended(now: &v1::Session) -> Option<NewEvent> {
    let (doing, text, _) = status::ended(now)?;
    Some(match doing {
        Doing::Failed => (Level::Error, "failed", text),
        _ => (Level::Info, "ended", text),
    })
}
