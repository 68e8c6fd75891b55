//! Containers that share a robot: it places into one at a time, and where one is held, all are.
//!
//! Each container has a desk and a ledger of its own. What they share is in memory alone: after a restart nothing is being placed,
//! and the holds are in the ledgers.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use ppnpack_service::actor::{Address, WeakAddress};
use ppnpack_wire::keys::Cell;
use ppnpack_wire::{header, v1};

use super::Message;

/// A robot that several desks share.
#[derive(Clone, Default)]
pub(crate) struct SharedRobot(Arc<Mutex<Shared>>);

#[derive(Default)]
struct Shared {
    /// Where the robot places something.
    busy: Option<Cell>,
    /// Which are held, and why.
    held: BTreeMap<Cell, String>,
    desks: BTreeMap<Cell, Other>,
}

/// A desk, as the others know it.
struct Other {
    address: WeakAddress<Message>,
    /// What was asked of another desk, and is asked of this one too.
    order: Option<Order>,
}

/// What is done in all containers of a robot where it is asked for in one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Order {
    Hold { reason: String, is_aborting: bool },
    Resume,
}

impl Order {
    /// What a request asks for.
    pub(super) fn hold(request: &v1::HoldRequest) -> Self {
        let reason = match request.reason.is_empty() {
            true => "it was asked for".to_owned(),
            false => header::text(&request.reason),
        };
        Self::Hold {
            reason,
            is_aborting: request.is_aborting,
        }
    }
}

/// A desk's share of a robot.
pub(crate) struct Share {
    cell: Cell,
    robot: SharedRobot,
}

/// Why the robot may not begin.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Taken {
    /// It places into this container.
    Busy(Cell),
    /// Another container is held, for this reason.
    Held(String),
}

impl Share {
    /// The share of a desk, which is told what the others do from now on.
    pub(crate) fn new(robot: SharedRobot, cell: &Cell, desk: &Address<Message>) -> Self {
        let other = Other {
            address: desk.downgrade(),
            order: None,
        };
        robot.lock().desks.insert(cell.clone(), other);
        Self {
            cell: cell.clone(),
            robot,
        }
    }

    /// Takes the robot for a placement.
    ///
    /// # Errors
    /// [`Taken`] where another desk has it, or another container is held.
    pub(crate) fn begin(&self) -> Result<(), Taken> {
        let mut shared = self.robot.lock();
        if let Some(reason) = shared.held_but(&self.cell) {
            return Err(Taken::Held(reason.clone()));
        }
        match &shared.busy {
            Some(other) if *other != self.cell => Err(Taken::Busy(other.clone())),
            _ => {
                shared.busy = Some(self.cell.clone());
                Ok(())
            }
        }
    }

    /// Whether no other container is held.
    ///
    /// # Errors
    /// [`Taken::Held`]
    pub(crate) fn may_begin(&self) -> Result<(), Taken> {
        match self.held_elsewhere() {
            Some(reason) => Err(Taken::Held(reason)),
            None => Ok(()),
        }
    }

    /// The placement has ended.
    pub(crate) fn end(&self) {
        let mut shared = self.robot.lock();
        shared.busy.take_if(|busy| *busy == self.cell);
    }

    /// Why another container is held, where one is.
    pub(crate) fn held_elsewhere(&self) -> Option<String> {
        self.robot.lock().held_but(&self.cell).cloned()
    }

    /// Notes whether the own container is held.
    pub(crate) fn note(&self, hold: Option<&str>) {
        let mut shared = self.robot.lock();
        match hold {
            Some(reason) => drop(shared.held.insert(self.cell.clone(), reason.to_owned())),
            None => drop(shared.held.remove(&self.cell)),
        }
    }

    /// Has all desks do this, the own one too. What was ordered before and not done yet is done no more, but that something is broken
    /// off.
    pub(super) fn order(&self, order: &Order) {
        let mut shared = self.robot.lock();
        for (cell, desk) in &mut shared.desks {
            let breaks_off = matches!(
                desk.order,
                Some(Order::Hold {
                    is_aborting: true,
                    ..
                })
            );
            let mut order = order.clone();
            if let Order::Hold { is_aborting, .. } = &mut order {
                *is_aborting |= breaks_off;
            }
            desk.order = Some(order);
            // A desk that is gone begins nothing.
            if *cell != self.cell
                && let Some(address) = desk.address.upgrade()
            {
                address.wake();
            }
        }
    }

    /// What was ordered last, and is not done yet.
    pub(super) fn take_order(&self) -> Option<Order> {
        let mut shared = self.robot.lock();
        shared.desks.get_mut(&self.cell)?.order.take()
    }

    /// Whether it was ordered last to go on.
    pub(super) fn is_resuming(&self) -> bool {
        let shared = self.robot.lock();
        let own = shared.desks.get(&self.cell);
        own.is_some_and(|own| own.order == Some(Order::Resume))
    }

    /// An order that could not be followed yet; a newer one counts.
    pub(super) fn put_back(&self, order: Order) {
        let mut shared = self.robot.lock();
        if let Some(own) = shared.desks.get_mut(&self.cell) {
            own.order.get_or_insert(order);
        }
    }
}

impl Shared {
    /// Why a container other than this one is held, where one is.
    fn held_but(&self, own: &Cell) -> Option<&String> {
        let mut held = self.held.iter();
        let other = held.find(|(cell, _)| *cell != own);
        other.map(|(_, reason)| reason)
    }
}

impl SharedRobot {
    fn lock(&self) -> MutexGuard<'_, Shared> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use ppnpack_service::actor;

    use super::*;

    fn hold(reason: &str, is_aborting: bool) -> Order {
        Order::Hold {
            reason: reason.to_owned(),
            is_aborting,
        }
    }

    /// The shares of two desks in one robot.
    fn shares() -> [Share; 2] {
        let (address, _mailbox) = actor::mailbox(1);
        let robot = SharedRobot::default();
        ["left", "right"].map(|name| Share::new(robot.clone(), &Cell::new(name).unwrap(), &address))
    }

    #[test]
    fn a_robot_places_into_one_container_at_a_time_and_is_held_as_a_whole() {
        let [left, right] = shares();
        assert_eq!(left.begin(), Ok(()));
        assert_eq!(right.begin(), Err(Taken::Busy(left.cell.clone())));
        right.end();
        assert_eq!(right.begin(), Err(Taken::Busy(left.cell.clone())));
        left.end();
        assert_eq!(right.begin(), Ok(()));
        right.end();
        left.note(Some("a hand"));
        assert_eq!(left.held_elsewhere(), None);
        assert_eq!(right.begin(), Err(Taken::Held("a hand".to_owned())));
        left.note(None);
        assert_eq!(right.begin(), Ok(()));
    }

    #[test]
    fn the_last_order_counts_but_what_was_to_be_broken_off_is() {
        let [left, right] = shares();
        left.order(&hold("first", true));
        left.order(&hold("second", false));
        for desk in [&left, &right] {
            assert_eq!(desk.take_order(), Some(hold("second", true)));
            assert_eq!(desk.take_order(), None);
        }
        left.order(&hold("third", false));
        right.order(&Order::Resume);
        assert!(left.is_resuming());
        assert_eq!(left.take_order(), Some(Order::Resume));
        left.put_back(Order::Resume);
        assert_eq!(left.take_order(), Some(Order::Resume));
        right.order(&hold("fourth", false));
        right.put_back(Order::Resume);
        assert_eq!(right.take_order(), Some(hold("fourth", false)));
    }
}
