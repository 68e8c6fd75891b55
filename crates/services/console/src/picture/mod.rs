//! The picture of the cells: a fold over what is heard of them, without any reading or sending.
//!
//! All of it is bounded: the last decisions and events are kept, histories are thinned out, and
//! cells beyond a number are left out.

mod decision;
mod history;
mod known;
mod log;
mod place;
mod pose;
mod services;
mod session;
mod show;
mod status;
mod tell;
mod words;

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use nalgebra::Isometry3;
use ppnpack_service::alive::Found;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1::{self, ItemState};

use crate::directory::Entry;
use crate::shapes::{ShapeId, Wanted};
use decision::Decisions;
use known::KnownShapes;
use log::{Level, Log};
pub(crate) use place::SeenContainer;
use place::{Content, LyingItem, Place};
use services::Services;

const MOST_CELLS: usize = 256;

/// Maximum of volumes that are kept before all are forgotten and told anew.
const MOST_VOLUMES: usize = 10_000;

/// News of a cell, or of a container.
#[derive(Debug)]
pub(crate) enum News {
    Session(Box<v1::Session>),
    Decision(Box<v1::Decision>),
    /// The input that a cell's step was planned on.
    Record(Box<v1::PlanningRecord>),
    /// A control that an operator used on a cell, in words.
    Control(String),
    State(Box<v1::CellState>),
    /// The outcome of a placement into a container.
    Outcome(Box<v1::Outcome>),
    /// The content of a container as it is seen.
    Seen(Box<SeenContainer>),
}

#[derive(Debug, Default)]
struct CellPicture {
    session: Option<v1::Session>,
    decisions: Decisions,
    shapes: KnownShapes,
    log: Log,
}

#[derive(Debug, Default)]
pub(crate) struct Picture {
    cells: BTreeMap<Cell, CellPicture>,
    /// The containers, by the names under which bridge and perception serve them.
    places: BTreeMap<Cell, Place>,
    services: Services,
    /// The volumes of shapes, in cubic metres.
    volumes: HashMap<ShapeId, f64>,
}

impl Picture {
    /// Takes in news of a cell or a container. Gives the shapes that are to be asked for.
    pub(crate) fn apply(&mut self, at_ms: u64, of: &Cell, news: News) -> Option<Wanted> {
        let mut wanted = None;
        match news {
            News::State(state) => self.hear_state(at_ms, of, *state),
            News::Outcome(outcome) => self.hear_outcome(at_ms, of, &outcome),
            News::Seen(seen) => self.see(at_ms, of, *seen),
            News::Session(session) => self.hear_session(at_ms, of, *session),
            News::Decision(decision) => self.hear_decision(at_ms, of, *decision),
            News::Record(record) => wanted = self.learn(of, &record),
            News::Control(text) => self.note(at_ms, of, Level::Info, "control", text),
        }
        self.note_content(at_ms, of);
        wanted
    }

    pub(crate) fn look(&mut self, now_ms: u64, found: Vec<(Found, v1::HealthReply)>) {
        let turns = self.services.look(now_ms, found);
        let planned: Vec<Cell> = self.services.planned_cells().cloned().collect();
        for cell in planned {
            self.cell(&cell);
        }
        for turn in turns {
            let (level, kind) = match turn.is_back {
                true => (Level::Info, "back"),
                false => (Level::Warning, "away"),
            };
            for (cell, entry) in self.directory() {
                let names = std::iter::once(&cell).chain(&entry.containers);
                let mut serves = names.filter(|name| turn.cells.contains(name));
                if turn.cells.is_empty() || serves.next().is_some() {
                    self.note(now_ms, &cell, level, kind, turn.text.clone());
                }
            }
        }
    }

    pub(crate) fn learn_volumes(&mut self, at_ms: u64, volumes: Vec<(ShapeId, f64)>) {
        if self.volumes.len() + volumes.len() > MOST_VOLUMES {
            self.volumes.clear();
        }
        self.volumes.extend(volumes);
        let cells: Vec<Cell> = self.cells.keys().cloned().collect();
        cells.iter().for_each(|cell| self.note_content(at_ms, cell));
    }

    /// Gives the shapes that lie in containers and whose volumes are not known.
    pub(crate) fn missing(&self) -> Vec<Wanted> {
        let wanted = self.cells.keys().filter_map(|cell| {
            let containers = self.containers_of(cell);
            let lying = containers.iter().flat_map(|it| self.lying(cell, it));
            let shapes = lying.filter_map(|item| item.shape);
            let unknown = shapes.filter(|shape| !self.volumes.contains_key(shape));
            let shapes: HashSet<ShapeId> = unknown.collect();
            (!shapes.is_empty()).then(|| Wanted {
                cell: cell.clone(),
                shapes,
            })
        });
        wanted.collect()
    }

    /// Lists the cells with their containers.
    pub(crate) fn directory(&self) -> BTreeMap<Cell, Entry> {
        let cells = self.cells.keys();
        let cells = cells.map(|cell| (cell.clone(), self.containers_of(cell)));
        let mut cells: BTreeMap<Cell, Vec<Cell>> = cells.collect();
        for place in self.places.keys() {
            cells
                .entry(place.clone())
                .or_insert_with(|| vec![place.clone()]);
        }
        // Something may have been heard of a container before its cell was.
        let owned = cells.iter().flat_map(|(cell, containers)| {
            let others = containers.iter().filter(move |it| *it != cell);
            others.cloned()
        });
        let owned: BTreeSet<Cell> = owned.collect();
        cells.retain(|cell, _| !owned.contains(cell));
        let entries = cells.into_iter().map(|(cell, containers)| {
            let mut places = containers.iter().filter_map(|it| self.places.get(it));
            let seen = places.find_map(|place| place.seen.as_ref());
            let entry = Entry {
                resolution: seen.map(|seen| seen.grid.resolution().clone()),
                containers,
            };
            (cell, entry)
        });
        entries.collect()
    }

    /// Gives the containers of a cell: those of its session, else one with its own name.
    fn containers_of(&self, cell: &Cell) -> Vec<Cell> {
        let known = self.cells.get(cell);
        let session = known.and_then(|known| known.session.as_ref());
        let containers = session.into_iter().flat_map(|session| &session.containers);
        let names = containers.map(|container| session::address(cell, &container.container));
        let names: Vec<Cell> = names.filter_map(|name| Cell::new(name).ok()).collect();
        match names.is_empty() {
            true => vec![cell.clone()],
            false => names,
        }
    }

    /// Gives the cell of a container: the one whose session names it, else that of its own name.
    fn owner(&self, container: &Cell) -> Cell {
        let mut others = self.cells.keys().filter(|cell| *cell != container);
        let owner = others.find(|cell| self.containers_of(cell).contains(container));
        owner.unwrap_or(container).clone()
    }

    /// Gives or begins the picture of a cell; `None` where there are too many.
    fn cell(&mut self, cell: &Cell) -> Option<&mut CellPicture> {
        if self.cells.len() >= MOST_CELLS && !self.cells.contains_key(cell) {
            return None;
        }
        Some(self.cells.entry(cell.clone()).or_default())
    }

    /// Gives or begins the picture of a container; `None` where there are too many.
    fn place(&mut self, container: &Cell) -> Option<&mut Place> {
        if self.places.len() >= MOST_CELLS && !self.places.contains_key(container) {
            return None;
        }
        Some(self.places.entry(container.clone()).or_default())
    }

    /// Notes how full the containers of a cell are now, or of the cell of a container.
    fn note_content(&mut self, at_ms: u64, of: &Cell) {
        let cell = self.owner(of);
        for container in self.containers_of(&cell) {
            let content = self.content(&cell, &container);
            if let Some(place) = self.places.get_mut(&container) {
                place.note(at_ms, &content);
            }
        }
    }

    fn content(&self, cell: &Cell, container: &Cell) -> Content {
        let mut content = Content::default();
        let lying = self.lying(cell, container);
        for item in lying.iter().filter(|item| item.is_inside) {
            let volume_m3 = item.shape.and_then(|shape| self.volumes.get(&shape));
            content.items += 1;
            content.without_volume += usize::from(volume_m3.is_none());
            content.volume_m3 += volume_m3.copied().unwrap_or(0.0);
        }
        content
    }

    /// Gives the items that lie in a container: as its bridge knows them, else as the session does.
    fn lying(&self, cell: &Cell, container: &Cell) -> Vec<LyingItem<'_>> {
        let known = self.cells.get(cell);
        let session = known.and_then(|known| known.session.as_ref());
        let place = self.places.get(container);
        let state = place.and_then(|place| place.state.as_ref());
        let told = state.filter(|state| state.is_simulated || !state.bodies.is_empty());
        if let Some(state) = told {
            let bodies = state.bodies.iter();
            return bodies.map(|body| lying_body(known, body)).collect();
        }
        let Some((known, session)) = known.zip(session) else {
            return Vec::new();
        };
        let mut containers = session.containers.iter();
        let here = |name: &str| session::address(cell, name) == container.as_str();
        let sequence = containers.find(|standing| here(&standing.container));
        let sequence = sequence.map_or(0, |standing| standing.sequence);
        let packed = session.items.iter().filter(|item| {
            item.state() == ItemState::Packed
                && here(&item.container)
                && item.container_sequence == sequence
        });
        let at = |item: &v1::SessionItem| pose::read(item.container_from_item.as_ref());
        packed
            .map(|item| lying_item(known, session, item, at(item)))
            .collect()
    }
}

/// Gives an item where a bridge knows it to be.
fn lying_body<'a>(known: Option<&'a CellPicture>, body: &'a v1::Body) -> LyingItem<'a> {
    let session = known.and_then(|known| known.session.as_ref());
    let mut items = session.into_iter().flat_map(|session| &session.items);
    let item = items.find(|item| item.item_id == body.item_id);
    let at = pose::read(body.container_from_item.as_ref());
    if let Some(((known, session), item)) = known.zip(session).zip(item) {
        return LyingItem {
            is_inside: body.is_inside,
            ..lying_item(known, session, item, at)
        };
    }
    // Of an item of a session before no more than its object's name is known.
    let shape = known.and_then(|known| known.shapes.named("", &body.item_id, &body.object, 0));
    LyingItem {
        item_id: &body.item_id,
        object: &body.object,
        shape: shape.map(|known| known.shape),
        container_from_shape: shape.zip(at).map(|(known, at)| known.placed(&at)),
        is_inside: body.is_inside,
        step: None,
        session_item: None,
    }
}

/// Gives an item that a session has packed, with its own frame `at` that place.
fn lying_item<'a>(
    known: &CellPicture,
    session: &v1::Session,
    item: &'a v1::SessionItem,
    at: Option<Isometry3<f64>>,
) -> LyingItem<'a> {
    let shape = known.shapes.of_item(&session.session_id, item, item.pose);
    let mut decisions = known.decisions.iter().map(|decided| &decided.decision);
    let decision = decisions.find(|decision| {
        decision.item_id == item.item_id && decision.session_id == session.session_id
    });
    LyingItem {
        item_id: &item.item_id,
        object: &item.object,
        shape: shape.map(|known| known.shape),
        container_from_shape: shape.zip(at).map(|(known, at)| known.placed(&at)),
        is_inside: true,
        step: decision.map(|decision| decision.step),
        session_item: Some(item),
    }
}

#[cfg(test)]
mod tests;
