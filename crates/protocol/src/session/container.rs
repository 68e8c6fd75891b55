//! The containers that a session packs: which are open, and what became of those that were closed.

use ppnpack_wire::v1;

use super::{ItemState, Session, SessionError, SessionItem};

/// Closed containers that are told of.
const CLOSED_KEPT: usize = 64;

/// Items that left which are remembered, to tell a repeated announcement from a new one.
const LEFT_KEPT: usize = 256;

/// A place for a container, and the one that stands there.
#[derive(Debug, Clone, PartialEq)]
pub struct Container {
    /// Under which bridge and perception serve it; empty where that is the cell itself.
    pub name: String,
    /// Which of those that stand there one after another; where none is open: which the next one is.
    pub sequence: u64,
    /// What stands there.
    pub stand: Stand,
    /// The regions of its floor that stay free.
    pub keep_out: Vec<v1::Region>,
    /// The least state that shows what was done in it so far.
    pub least_state_number: u64,
}

/// What stands in the place of a container.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Stand {
    /// One that is packed.
    Open,
    /// Nothing that is packed, until somebody says that an empty one stands there.
    Closed,
    /// Nothing that is packed: the bridge is to bring an empty one, by the request of this id.
    Renewing(String),
}

impl Container {
    /// A container that is open from the start of a session.
    pub fn open(name: String, keep_out: Vec<v1::Region>, least_state_number: u64) -> Self {
        Self {
            name,
            sequence: 0,
            stand: Stand::Open,
            keep_out,
            least_state_number,
        }
    }

    /// A place where none is open yet.
    pub fn closed(name: String) -> Self {
        Self {
            stand: Stand::Closed,
            ..Self::open(name, Vec::new(), 0)
        }
    }

    /// Whether it is packed.
    pub fn is_open(&self) -> bool {
        self.stand == Stand::Open
    }

    /// The id of the request by which the bridge is to bring an empty one.
    pub fn renewal_id(&self) -> Option<&str> {
        match &self.stand {
            Stand::Renewing(id) => Some(id),
            Stand::Open | Stand::Closed => None,
        }
    }

    /// Nothing is planned on an earlier state than this one any more.
    pub(super) fn needs_state(&mut self, state_number: u64) {
        self.least_state_number = self.least_state_number.max(state_number);
    }
}

impl Session {
    /// The containers of the cell.
    pub fn containers(&self) -> &[Container] {
        &self.containers
    }

    /// The containers that were closed, as far as they are remembered.
    pub fn closed(&self) -> &[v1::ClosedContainer] {
        &self.closed
    }

    /// A container by its name.
    ///
    /// # Errors
    /// [`SessionError::UnknownContainer`]
    pub fn container(&self, name: &str) -> Result<&Container, SessionError> {
        let mut containers = self.containers.iter();
        let container = containers.find(|container| container.name == name);
        container.ok_or_else(|| SessionError::UnknownContainer(name.to_owned()))
    }

    pub(super) fn container_mut(&mut self, name: &str) -> Result<&mut Container, SessionError> {
        let mut containers = self.containers.iter_mut();
        let container = containers.find(|container| container.name == name);
        container.ok_or_else(|| SessionError::UnknownContainer(name.to_owned()))
    }

    /// The least state that shows what was done in a container so far; 0 of one that there is not.
    pub fn least_state_number(&self, container: &str) -> u64 {
        let container = self.container(container);
        container.map_or(0, |container| container.least_state_number)
    }

    /// Nothing is planned in a container on an earlier state than this one any more.
    pub fn needs_state(&mut self, container: &str, state_number: Option<u64>) {
        if let Ok(container) = self.container_mut(container) {
            container.needs_state(state_number.unwrap_or_default());
        }
    }

    /// The items that lie in a container that is open.
    pub fn packed_in<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a SessionItem> {
        self.items
            .iter()
            .filter(move |item| self.lies_in(item) == Some(name))
    }

    /// The open container that an item lies in.
    fn lies_in(&self, item: &SessionItem) -> Option<&str> {
        let ItemState::Packed {
            container,
            sequence,
            ..
        } = &item.state
        else {
            return None;
        };
        let place = self.container(container).ok()?;
        (place.is_open() && place.sequence == *sequence).then_some(&place.name)
    }

    /// Whether an item left: with its container, or otherwise, in a session of which containers were closed.
    fn has_left(&self, item: &SessionItem) -> bool {
        match item.state {
            ItemState::Packed { .. } => self.lies_in(item).is_none(),
            ItemState::Gone | ItemState::Withdrawn => !self.closed.is_empty(),
            ItemState::Waiting | ItemState::Decided | ItemState::SetAside { .. } => false,
        }
    }

    /// An empty container stands where one was closed: what is set aside waits again.
    ///
    /// # Errors
    /// [`SessionError::UnknownContainer`], and [`SessionError::OtherContainer`] where another one is next there.
    pub fn open(&mut self, start: Container) -> Result<(), SessionError> {
        self.must_be_under_way()?;
        let container = self.container_mut(&start.name)?;
        if container.sequence != start.sequence {
            return Err(container.is_other_than(start.sequence));
        }
        if container.is_open() {
            return Ok(());
        }
        // What was done there is seen in no earlier state.
        let known = container.least_state_number;
        *container = start;
        container.needs_state(known);
        for item in &mut self.items {
            item.wait_again();
        }
        // One that has packed all that came stays at its end until more is announced.
        if self.buffer(1).next().is_some() {
            self.go_on();
        }
        Ok(())
    }

    /// Refuses where something is on its way into a container.
    fn must_not_await(&self, name: &str) -> Result<(), SessionError> {
        let pending = self.pending.as_ref();
        match pending.filter(|pending| pending.container == name) {
            Some(pending) => Err(SessionError::Pending(pending.decision_id.clone())),
            None => Ok(()),
        }
    }

    /// Nothing more is put into a container, for the reason that `closed` has; how many items it holds is counted here. With a
    /// `renewal_id` the bridge is to bring an empty one by this request. One that was closed before stays closed.
    ///
    /// # Errors
    /// [`SessionError::UnknownContainer`], [`SessionError::Pending`] where something is on its way into it, and
    /// [`SessionError::OtherContainer`] where it was not opened.
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
        if sequence != container.sequence || !container.is_open() {
            return Err(container.is_other_than(sequence));
        }
        self.must_not_await(name)?;
        let items = u32::try_from(self.packed_in(name).count()).unwrap_or(u32::MAX);
        let container = self.container_mut(name)?;
        container.stand = renewal_id.map_or(Stand::Closed, Stand::Renewing);
        container.sequence += 1;
        let surplus = (self.closed.len() + 1).saturating_sub(CLOSED_KEPT);
        self.closed.drain(..surplus);
        self.closed.push(v1::ClosedContainer { items, ..closed });
        self.forget_left(LEFT_KEPT);
        Ok(())
    }

    /// Forgets one more item that left, to make room; says whether there was one.
    pub(super) fn forget_one(&mut self) -> bool {
        let left = self.items.iter().filter(|item| self.has_left(item));
        let count = left.count();
        self.forget_left(count.saturating_sub(1));
        count > 0
    }

    /// Forgets the items that left first, but for so many.
    pub(super) fn forget_left(&mut self, kept: usize) {
        let left = self.items.iter().map(|item| self.has_left(item));
        let left: Vec<bool> = left.collect();
        let count = left.iter().filter(|has_left| **has_left).count();
        let mut surplus = count.saturating_sub(kept);
        let mut left = left.into_iter();
        let forgotten = &mut self.forgotten;
        self.items.retain(|_| {
            let goes = left.next().unwrap_or_default() && surplus > 0;
            surplus -= usize::from(goes);
            *forgotten += usize::from(goes);
            !goes
        });
    }
}

impl Container {
    fn is_other_than(&self, sequence: u64) -> SessionError {
        SessionError::OtherContainer {
            name: self.name.clone(),
            asked: sequence,
            known: self.sequence,
            is_open: self.is_open(),
        }
    }
}

#[cfg(test)]
mod tests;
