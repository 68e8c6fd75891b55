//! Which containers are open, where not all of the cell's are: by the sizes of those that stand ready, and by what waits.

use ppnpack_packing::grid::Grid;
use ppnpack_packing::sizes::{size_to_open, takes};
use ppnpack_protocol::session::{Container, ItemState, SessionItem, Stand};

use super::CellPlanner;
use super::refusal::Refusal;

impl CellPlanner {
    /// An empty container, as the session begins with it: open, or ready where not all are open.
    pub(super) fn standing(&self, start: Container) -> Container {
        let stand = match self.settings.opening.most {
            Some(_) => Stand::Ready,
            None => start.stand,
        };
        Container { stand, ..start }
    }

    /// Whether one more container may be open.
    pub(super) fn may_open_more(&self) -> bool {
        let containers = self.session.containers().iter();
        let open = containers.filter(|container| container.is_open()).count();
        let most = self.settings.opening.most;
        most.is_none_or(|most| open < most)
    }

    /// Opens as many of the containers that stand ready as may be open, where something waits.
    pub(super) fn open_ready(&mut self) {
        while self.may_open_more() && !self.session.has_failed() {
            let opened = self.next_to_open().and_then(|next| match next {
                Some(name) => self.open_one(&name).map(|()| true),
                None => Ok(false),
            });
            match opened {
                Ok(true) => {}
                Ok(false) => return,
                Err(refusal) => {
                    tracing::warn!(cell = %self.cell, reason = refusal.message, "no container is opened yet");
                    return;
                }
            }
        }
    }

    fn open_one(&mut self, name: &str) -> Result<(), Refusal> {
        let start = Container {
            stand: Stand::Open,
            ..self.session.container(name)?.clone()
        };
        self.open_container(start)
    }

    /// Of the containers that stand ready, the one whose size suits what waits; `None` where there is none, or nothing waits.
    fn next_to_open(&mut self) -> Result<Option<String>, Refusal> {
        let ready = self.ready();
        if ready.is_empty() {
            return Ok(None);
        }
        let items = self.session.items().iter();
        let waiting = items
            .filter(|item| matches!(item.state, ItemState::Waiting | ItemState::SetAside { .. }));
        let waiting: Vec<SessionItem> = waiting.cloned().collect();
        if waiting.is_empty() {
            return Ok(None);
        }
        let sizes = self.sizes(&ready)?;
        let candidates = self.candidates_of(&waiting)?;
        let waiting_m3 = match self.next_order_m3(&waiting) {
            Some(next_m3) => next_m3,
            None => self.volume_m3(&waiting),
        };
        let expected_percent = self.settings.opening.expected_percent;
        let at = size_to_open(&sizes, &candidates, waiting_m3, expected_percent);
        Ok(at.and_then(|at| ready.into_iter().nth(at)))
    }

    /// The volume of the first order that waits and was begun nowhere, where there are orders, in cubic metres.
    fn next_order_m3(&mut self, waiting: &[SessionItem]) -> Option<f64> {
        let open = self.open_by_fullness();
        let mut orders = self.orders(&open)?;
        orders.begin_with(waiting.iter().map(|item| item.arrival));
        orders.next_m3()
    }

    /// Leaves an open container in which nothing lies for later, where no open one is large enough for any item of the buffer and one
    /// that stands ready is: that is opened in its place. Says whether it was so.
    pub(super) fn exchange_empty(&mut self, open: &[String]) -> Result<bool, Refusal> {
        let buffer = self.session.buffer(self.settings.method.buffer);
        let buffer: Vec<SessionItem> = buffer.cloned().collect();
        let candidates = self.candidates_of(&buffer)?;
        let takes_any = |grid: &Grid| candidates.iter().any(|held| takes(grid, held));
        if self.sizes(open)?.iter().any(takes_any) {
            return Ok(false);
        }
        let ready = self.ready();
        let sizes = self.sizes(&ready)?;
        let is_empty = |name: &&String| self.session.packed_in(name).next().is_none();
        let empty = open.iter().find(is_empty).cloned();
        let mut ready = ready.into_iter().zip(&sizes);
        let larger = ready.find(|(_, grid)| takes_any(grid));
        let Some((empty, (larger, _))) = empty.zip(larger) else {
            return Ok(false);
        };
        self.change(|session| session.leave_for_later(&empty))?;
        tracing::info!(cell = %self.cell, container = empty, "an empty container is left for later: no item of the buffer goes into it");
        self.open_one(&larger)?;
        Ok(true)
    }

    /// The names of the containers that stand ready, in the order of the cell.
    fn ready(&self) -> Vec<String> {
        let containers = self.session.containers().iter();
        let ready = containers.filter(|container| container.is_ready());
        ready.map(|container| container.name.clone()).collect()
    }

    fn sizes(&mut self, containers: &[String]) -> Result<Vec<Grid>, Refusal> {
        let grids = containers
            .iter()
            .map(|name| Ok(self.place_of(name)?.planning.grid().clone()));
        grids.collect()
    }
}
