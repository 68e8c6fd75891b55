//! The picture, put on the board in parts.

use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1;
use serde::Serialize;

use super::decision::{Context, DecisionPart};
use super::place::{ItemPart, LyingItem};
use super::session::{address, buffer_part, session_part};
use super::status::Situation;
use super::{CellPicture, ExplainedPart, Picture};
use crate::board::{Board, PartKey};
use crate::directory::Entry;

#[derive(Debug, Serialize)]
struct CellNamesPart<'a> {
    name: &'a str,
    containers: Vec<&'a str>,
}

impl Picture {
    /// Puts all parts on the board that are otherwise than there; `now_ms` is the time of day, in milliseconds since 1970.
    pub(crate) fn show(&self, board: &Board, now_ms: u64) {
        let directory = self.directory();
        let names = directory.iter().map(|(cell, entry)| CellNamesPart {
            name: cell.as_str(),
            containers: entry.containers.iter().map(Cell::as_str).collect(),
        });
        let names: Vec<CellNamesPart<'_>> = names.collect();
        board.put(PartKey::of_all("cells"), &names);
        board.put(PartKey::of_all("services"), &self.services.parts());
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
        board.put(PartKey::of_cell(cell, "status"), &situation.part());
        let Some(known) = known else {
            return;
        };
        let session = known.session.as_ref();
        let session_part = session.and_then(|session| session_part(cell, session));
        board.put(PartKey::of_cell(cell, "session"), &session_part);
        let buffer = session.map(|session| buffer_part(session, &known.shapes));
        if let Some(buffer) = buffer {
            board.put(PartKey::of_cell(cell, "buffer"), &buffer);
        }
        let decisions: Vec<DecisionPart<'_>> = self.decisions(cell, known);
        board.put(PartKey::of_cell(cell, "decisions"), &decisions);
        board.put(PartKey::of_cell(cell, "cycles"), &known.decisions.cycles());
        board.put(PartKey::of_cell(cell, "events"), &known.log);
    }

    fn decisions<'a>(&'a self, cell: &'a Cell, known: &'a CellPicture) -> Vec<DecisionPart<'a>> {
        let parts = known.decisions.iter().map(|decided| {
            let container = address(cell, &decided.decision.container);
            decided.part(&self.context(known, container))
        });
        parts.collect()
    }

    /// What is looked up to show a placement into a container, by the container's name.
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
        let key = |part| PartKey::of_container(cell, container, part);
        let lying = self.lying(cell, container);
        let items: Vec<ItemPart<'_>> = lying.iter().map(LyingItem::part).collect();
        board.put(key("items"), &items);
        let Some(place) = self.places.get(container) else {
            return;
        };
        if let Some(state) = place.state_part() {
            board.put(key("state"), &state);
        }
        let content = self.content(cell, container);
        board.put(key("figures"), &place.figures_part(&content));
    }

    /// Puts the heightmap of a container on the board.
    pub(crate) fn show_heightmap(&self, board: &Board, container: &Cell) {
        let cell = self.owner(container);
        let place = self.places.get(container);
        if let Some(heightmap) = place.and_then(|place| place.heightmap_part()) {
            board.put(
                PartKey::of_container(&cell, container, "heightmap"),
                &heightmap,
            );
        }
    }

    /// What a planner explained of an item; `None` where nothing is known of the cell.
    pub(crate) fn explained(
        &self,
        cell: &Cell,
        item_id: &str,
        reply: &v1::ExplainReply,
    ) -> Option<ExplainedPart> {
        let known = self.cells.get(cell)?;
        // Containers of a cell have the same grid, but for their size.
        let containers = self.containers_of(cell);
        let container = containers.first().map_or("", Cell::as_str);
        let context = self.context(known, container);
        let best = reply.best.as_ref();
        let best = best.map(|best| context.placement(item_id, best));
        Some(ExplainedPart::new(
            item_id,
            context.object(item_id),
            best,
            reply,
        ))
    }
}
