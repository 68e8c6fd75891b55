//! The picture, put on the board in parts.

use ppnpack_wire::convert;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1::{self, Check};
use serde_json::{Value, json};

use super::decision::{Context, reason_part};
use super::place::LyingItem;
use super::session::{address, buffer_part, session_part};
use super::status::Situation;
use super::{CellPicture, Picture, words};
use crate::board::Board;
use crate::directory::Entry;

impl Picture {
    /// Puts all parts on the board; `now_ms` is the time of day, in milliseconds since 1970.
    pub(crate) fn show(&self, board: &Board, now_ms: u64) {
        let directory = self.directory();
        let names = directory.iter().map(|(cell, entry)| {
            let containers: Vec<&str> = entry.containers.iter().map(Cell::as_str).collect();
            json!({"name": cell.as_str(), "containers": containers})
        });
        let names: Vec<Value> = names.collect();
        board.put((None, None, "cells"), names);
        board.put((None, None, "services"), self.services.parts());
        for (cell, entry) in &directory {
            self.show_cell(board, cell, entry, now_ms);
            for container in &entry.containers {
                self.show_container(board, cell, container);
            }
        }
    }

    fn show_cell(&self, board: &Board, cell: &Cell, entry: &Entry, now_ms: u64) {
        let known = self.cells.get(cell);
        let places = entry.containers.iter();
        let places = places.filter_map(|name| self.places.get_key_value(name));
        let situation = Situation {
            cell,
            session: known.and_then(|known| known.session.as_ref()),
            places: places.collect(),
            services: &self.services,
            now_ms,
        };
        board.put((Some(cell), None, "status"), json!(situation.part()));
        let Some(known) = known else {
            return;
        };
        let session = known.session.as_ref();
        let session_part = session.and_then(|session| session_part(cell, session));
        board.put((Some(cell), None, "session"), session_part);
        let buffer = session.map(|session| buffer_part(session, &known.shapes));
        if let Some(buffer) = buffer {
            board.put((Some(cell), None, "buffer"), buffer);
        }
        let decisions = known.decisions.iter().map(|decided| {
            let container = address(cell, &decided.decision.container);
            decided.part(&self.context(known, container))
        });
        let decisions: Vec<Value> = decisions.collect();
        board.put((Some(cell), None, "decisions"), decisions);
        board.put((Some(cell), None, "cycles"), known.decisions.cycles());
        board.put((Some(cell), None, "events"), json!(known.log));
    }

    /// Gives the knowledge that a placement into a container, by its name, is shown with.
    fn context<'a>(&'a self, known: &'a CellPicture, container: &'a str) -> Context<'a> {
        let mut places = self.places.iter();
        let place = places.find(|(name, _)| name.as_str() == container);
        let seen = place.and_then(|(_, place)| place.seen.as_ref());
        Context {
            session: known.session.as_ref(),
            shapes: &known.shapes,
            grid: seen.map(|seen| &seen.grid),
            container,
        }
    }

    fn show_container(&self, board: &Board, cell: &Cell, container: &Cell) {
        let key = |part| (Some(cell), Some(container), part);
        let lying = self.lying(cell, container);
        let items: Vec<Value> = lying.iter().map(LyingItem::part).collect();
        board.put(key("items"), items);
        let Some(place) = self.places.get(container) else {
            return;
        };
        if let Some(state) = place.state_part() {
            board.put(key("state"), state);
        }
        let content = self.content(cell, container);
        board.put(key("figures"), place.figures_part(&content));
    }

    /// Puts the heightmap of a container on the board.
    pub(crate) fn show_heightmap(&self, board: &Board, container: &Cell) {
        let cell = self.owner(container);
        let place = self.places.get(container);
        if let Some(heightmap) = place.and_then(|place| place.heightmap_part()) {
            let key = (Some(&cell), Some(container), "heightmap");
            board.put(key, heightmap);
        }
    }

    /// Shows a planner's explanation of an item, and keeps the reason with the last decision;
    /// `None` where nothing is known of the cell.
    pub(crate) fn explain(
        &mut self,
        cell: &Cell,
        item_id: &str,
        reply: v1::ExplainReply,
    ) -> Option<Value> {
        let known = self.cells.get(cell)?;
        // Containers of a cell have the same grid, but for their size.
        let containers = self.containers_of(cell);
        let container = containers.first().map_or("", Cell::as_str);
        let context = self.context(known, container);
        let object = context.object(item_id);
        let best = reply.best.as_ref();
        let reason = reply.reason.as_ref();
        let counts = reply.counts.unwrap_or_default();
        let explained = json!({
            "item_id": item_id,
            "object": object,
            "best": best.map(|best| context.placement(item_id, best)),
            "reason": reason.map(|reason| reason_part(reason, object)),
            "counts": {
                "possible": counts.possible,
                "proposed": counts.proposed,
                "fitting": counts.fitting,
                "refusals": counts.refusals.iter().map(refusals).collect::<Vec<_>>(),
            },
        });
        if let (Some(reason), Some(known)) = (reply.reason, self.cells.get_mut(cell)) {
            known.decisions.explain(reason);
        }
        Some(explained)
    }
}

fn refusals(refusals: &v1::Refusals) -> Value {
    let check = Check::try_from(refusals.check).unwrap_or(Check::Unspecified);
    let cause = convert::check::cause(check);
    json!({
        "check": words::short(check.as_str_name(), "CHECK_"),
        "text": cause.map_or_else(|| "refused".to_owned(), |cause| cause.to_string()),
        "count": refusals.count,
        "detail": refusals.detail,
    })
}
