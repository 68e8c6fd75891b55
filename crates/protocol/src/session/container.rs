//! The containers that a session packs: the open ones, and those that were closed.

use ppnpack_wire::v1::{self, ItemState};

use super::{Session, SessionError, item};

/// Maximum number of closed containers that are remembered.
const CLOSED_KEPT: usize = 64;

/// Maximum number of items that left and are remembered, to tell a repeated announcement from a new
/// one.
const LEFT_KEPT: usize = 256;

/// Makes a container that is open from the start of a session.
pub fn open_container(
    name: String,
    keep_out: Vec<v1::Region>,
    least_state_number: u64,
) -> v1::SessionContainer {
    v1::SessionContainer {
        container: name,
        is_open: true,
        keep_out,
        least_state_number,
        ..v1::SessionContainer::default()
    }
}

/// Makes a place where no container is open yet.
pub fn closed_container(name: String) -> v1::SessionContainer {
    v1::SessionContainer {
        container: name,
        ..v1::SessionContainer::default()
    }
}

impl Session {
    /// Gives the containers of the cell.
    pub fn containers(&self) -> &[v1::SessionContainer] {
        &self.0.containers
    }

    /// Gives the containers that were closed, as far as they are remembered.
    pub fn closed(&self) -> &[v1::ClosedContainer] {
        &self.0.closed
    }

    /// Gives the containers that are to be renewed, and the ids of the requests; none where somebody
    /// has to look first.
    pub fn to_be_renewed(&self) -> impl Iterator<Item = (&v1::SessionContainer, &str)> {
        let containers = self.containers().iter();
        let containers = containers.filter(|_| !self.has_failed());
        let renewing = containers.filter(|container| !container.renewal_id.is_empty());
        renewing.map(|container| (container, container.renewal_id.as_str()))
    }

    /// Says whether an empty container comes for one that was closed.
    pub fn is_renewing(&self) -> bool {
        self.to_be_renewed().next().is_some()
    }

    /// Finds a container by its name.
    ///
    /// # Errors
    /// [`SessionError::UnknownContainer`]
    pub fn container(&self, name: &str) -> Result<&v1::SessionContainer, SessionError> {
        let mut containers = self.0.containers.iter();
        let container = containers.find(|container| container.container == name);
        container.ok_or_else(|| SessionError::UnknownContainer(name.to_owned()))
    }

    pub(super) fn container_mut(
        &mut self,
        name: &str,
    ) -> Result<&mut v1::SessionContainer, SessionError> {
        let mut containers = self.0.containers.iter_mut();
        let container = containers.find(|container| container.container == name);
        container.ok_or_else(|| SessionError::UnknownContainer(name.to_owned()))
    }

    /// Gives the least state that shows all that was done in a container so far; 0 of an unknown
    /// one.
    pub fn least_state_number(&self, container: &str) -> u64 {
        let container = self.container(container);
        container.map_or(0, |container| container.least_state_number)
    }

    /// Has nothing planned in a container on an earlier state than this one any more.
    pub fn needs_state(&mut self, container: &str, state_number: Option<u64>) {
        if let Ok(container) = self.container_mut(container) {
            let least = &mut container.least_state_number;
            *least = state_number.unwrap_or_default().max(*least);
        }
    }

    /// Has nothing planned in a container on an earlier state than this one, where it is known. It
    /// may be before the one so far, as the bridge counts anew.
    pub fn goes_on_at(&mut self, container: &str, state_number: Option<u64>) {
        if let (Ok(container), Some(state_number)) = (self.container_mut(container), state_number) {
            container.least_state_number = state_number;
        }
    }

    /// Finds an item that the bridge has in a container and that cannot have come there in this
    /// session. It waits here, or is unknown, in a later state than is known here. So another
    /// planner packed meanwhile, or this is an old copy. To be asked where no decision is pending.
    pub fn unexplained<'a>(&self, container: &str, told: &'a v1::CellState) -> Option<&'a str> {
        let least = self.least_state_number(container);
        let is_later = least > 0 && told.state_number > least;
        let cannot_be = |body: &&v1::Body| {
            let mut items = self.items().iter();
            let known = items.find(|item| item.item_id == body.item_id);
            known.map_or(is_later, |item| {
                matches!(item.state(), ItemState::Waiting | ItemState::SetAside)
            })
        };
        let unexplained = told.bodies.iter().find(cannot_be);
        unexplained.map(|body| body.item_id.as_str())
    }

    /// Gives the items that lie in a container that is open.
    pub fn packed_in<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a v1::SessionItem> {
        let items = self.items().iter();
        items.filter(move |item| self.lies_in(item) == Some(name))
    }

    /// Gives the open container that an item lies in.
    fn lies_in(&self, item: &v1::SessionItem) -> Option<&str> {
        let place = self.container(&item.container).ok()?;
        let is_there = place.is_open && place.sequence == item.container_sequence;
        (is_there && item.state() == ItemState::Packed).then_some(&place.container)
    }

    /// Says whether an item left: with its container, or otherwise, in a session of which
    /// containers were closed.
    fn has_left(&self, item: &v1::SessionItem) -> bool {
        match item.state() {
            ItemState::Packed => self.lies_in(item).is_none(),
            ItemState::Gone | ItemState::Withdrawn => !self.closed().is_empty(),
            _ => false,
        }
    }

    /// Opens an empty container where one was closed: items that were set aside wait again.
    ///
    /// # Errors
    /// [`SessionError::UnknownContainer`], and [`SessionError::OtherContainer`] where another one
    /// is next there.
    pub fn open(&mut self, start: v1::SessionContainer) -> Result<(), SessionError> {
        self.must_be_under_way()?;
        let container = self.container_mut(&start.container)?;
        if container.sequence != start.sequence {
            return Err(is_other(container, start.sequence));
        }
        if container.is_open {
            return Ok(());
        }
        // What was done there is seen in no earlier state.
        let known = container.least_state_number;
        *container = start;
        container.least_state_number = container.least_state_number.max(known);
        self.0.items.iter_mut().for_each(item::wait_again);
        // One that has packed all that came stays at its end until more is announced.
        if self.buffer(1).next().is_some() {
            self.go_on();
        }
        Ok(())
    }

    /// Closes a container for the reason that `closed` has; its items are counted here. With a
    /// `renewal_id` the bridge is to bring an empty one by this request. One that was closed before
    /// stays closed.
    ///
    /// # Errors
    /// [`SessionError::UnknownContainer`], [`SessionError::Pending`] where something is on its way
    /// into it, and [`SessionError::OtherContainer`] where it was not opened.
    pub fn close(
        &mut self,
        closed: v1::ClosedContainer,
        renewal_id: Option<String>,
    ) -> Result<(), SessionError> {
        self.must_be_under_way()?;
        let (name, sequence) = (closed.container.as_str(), closed.sequence);
        let container = self.container(name)?;
        if sequence < container.sequence {
            return Ok(());
        }
        if sequence != container.sequence || !container.is_open {
            return Err(is_other(container, sequence));
        }
        let pending = self.pending();
        if let Some(pending) = pending.filter(|pending| pending.container == name) {
            return Err(SessionError::Pending(pending.decision_id.clone()));
        }
        let items = u32::try_from(self.packed_in(name).count()).unwrap_or(u32::MAX);
        let container = self.container_mut(name)?;
        container.is_open = false;
        container.renewal_id = renewal_id.unwrap_or_default();
        container.sequence += 1;
        let surplus = (self.0.closed.len() + 1).saturating_sub(CLOSED_KEPT);
        self.0.closed.drain(..surplus);
        self.0.closed.push(v1::ClosedContainer { items, ..closed });
        self.forget_left(LEFT_KEPT);
        Ok(())
    }

    /// Forgets one more item that left, to make room; says whether there was one.
    pub(super) fn forget_one(&mut self) -> bool {
        let left = self.items().iter().filter(|item| self.has_left(item));
        let count = left.count();
        self.forget_left(count.saturating_sub(1));
        count > 0
    }

    /// Forgets the items that left first, but for so many.
    pub(super) fn forget_left(&mut self, kept: usize) {
        let left = self.items().iter().map(|item| self.has_left(item));
        let left: Vec<bool> = left.collect();
        let count = left.iter().filter(|has_left| **has_left).count();
        let mut surplus = count.saturating_sub(kept);
        let mut left = left.into_iter();
        let forgotten = &mut self.0.forgotten_items;
        self.0.items.retain(|_| {
            let goes = left.next().unwrap_or_default() && surplus > 0;
            surplus -= usize::from(goes);
            *forgotten += u64::from(goes);
            !goes
        });
    }
}

fn is_other(container: &v1::SessionContainer, asked: u64) -> SessionError {
    SessionError::OtherContainer {
        name: container.container.clone(),
        asked,
        known: container.sequence,
        is_open: container.is_open,
    }
}

#[cfg(test)]
mod tests;
