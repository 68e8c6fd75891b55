//! Containers that share a robot: it places into one at a time, and where one is held, all are.
//!
//! Each container has a desk with a ledger. The robot's holds are one set in memory, which all its
//! desks see at once: a hold stops the robot before anything is written. Each desk copies the set
//! into its ledger, so that a restart knows it. The set begins as the holds of all ledgers
//! together, and nothing begins before the last of these is open. Holds end in the ledger of the
//! desk that is asked, then in the set, and from there in the other ledgers.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, MutexGuard};

use ppnpack_protocol::ledger::{Hold, Holds};
use ppnpack_service::Shutdown;
use ppnpack_service::actor::{Address, WeakAddress};
use ppnpack_service::rpc::Incoming;
use ppnpack_service::sync;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1::{self, Status};

use super::{Message, Refusal};

/// The default reason of a hold.
const ASKED_FOR: &str = "it was asked for";

/// A robot that several desks share.
#[derive(Clone, Default)]
pub(crate) struct SharedRobot(Arc<Mutex<Shared>>);

/// The state of a shared robot.
#[derive(Default)]
struct Shared {
    /// The containers whose ledgers are not open yet.
    awaited: BTreeSet<String>,
    /// The container that the robot places into, and the way to break that off.
    busy: Option<(Cell, Shutdown)>,
    holds: Holds,
    /// The placements after which each container holds itself, once the robot goes on; 0: any
    /// number.
    most_placements: u32,
    desks: BTreeMap<Cell, WeakAddress<Message>>,
}

/// A desk's share of a robot.
pub(crate) struct Share {
    cell: Cell,
    robot: SharedRobot,
}

/// A reason why the robot may not begin.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Taken {
    #[error("the robot places into container {0}")]
    Busy(Cell),
    #[error("the robot is held: {0}")]
    Held(Holds),
    /// It is not known whether this container is held.
    #[error("container {0} of the same robot is not served yet, or its journal not read")]
    NotOpen(String),
}

impl From<Taken> for Refusal {
    fn from(taken: Taken) -> Self {
        let status = match taken {
            Taken::Busy(_) => Status::Busy,
            Taken::Held(_) => Status::Held,
            Taken::NotOpen(_) => Status::Unavailable,
        };
        Self(status, taken.to_string())
    }
}

impl SharedRobot {
    /// The robot of these containers.
    pub(crate) fn of(containers: &[String]) -> Self {
        let shared = Shared {
            awaited: containers.iter().cloned().collect(),
            ..Shared::default()
        };
        Self(Arc::new(Mutex::new(shared)))
    }

    fn lock(&self) -> MutexGuard<'_, Shared> {
        sync::lock(&self.0)
    }
}

impl Share {
    /// The share of a desk, which is woken where others change the robot's holds.
    pub(crate) fn new(robot: SharedRobot, cell: &Cell, desk: &Address<Message>) -> Self {
        robot.lock().desks.insert(cell.clone(), desk.downgrade());
        Self {
            cell: cell.clone(),
            robot,
        }
    }

    /// Adds the holds of the desk's ledger, which is open now.
    pub(crate) fn open(&self, holds: &Holds) {
        self.change(|shared| {
            holds.iter().for_each(|hold| shared.holds.add(hold.clone()));
            shared.awaited.remove(self.cell.as_str());
        });
    }

    /// Takes the robot for a placement.
    ///
    /// # Errors
    /// [`Taken`] where another desk has it, or it is held.
    pub(crate) fn begin(&self, break_off: &Shutdown) -> Result<(), Taken> {
        let mut shared = self.robot.lock();
        shared.check_free()?;
        match &shared.busy {
            Some((other, _)) if *other != self.cell => Err(Taken::Busy(other.clone())),
            _ => {
                shared.busy = Some((self.cell.clone(), break_off.clone()));
                Ok(())
            }
        }
    }

    /// Refuses where the robot is held.
    ///
    /// # Errors
    /// [`Taken::Held`], and [`Taken::NotOpen`].
    pub(crate) fn check_free(&self) -> Result<(), Taken> {
        self.robot.lock().check_free()
    }

    /// Refuses where the holds of a container are not known yet.
    ///
    /// # Errors
    /// [`Taken::NotOpen`].
    pub(crate) fn check_open(&self) -> Result<(), Taken> {
        self.robot.lock().check_open()
    }

    /// Gives the robot back after a placement.
    pub(crate) fn end(&self) {
        let mut shared = self.robot.lock();
        shared.busy.take_if(|(busy, _)| *busy == self.cell);
    }

    /// The robot's holds; without any, the placements after which each container holds itself.
    pub(crate) fn robot_holds(&self) -> (Holds, u32) {
        let shared = self.robot.lock();
        (shared.holds.clone(), shared.most_placements)
    }

    /// Holds the robot as a request says.
    pub(super) fn hold_as_asked(&self, incoming: &Incoming<v1::HoldRequest>) {
        let request = incoming.message();
        let reason = match request.reason.as_str() {
            "" => ASKED_FOR,
            reason => reason,
        };
        let hold = Hold::new(&incoming.header().request_id, &request.holder, reason);
        self.hold(hold, request.is_aborting);
    }

    /// Holds the robot at once, for all of its desks, and breaks off its placement if asked to.
    pub(super) fn hold(&self, hold: Hold, is_aborting: bool) {
        self.change(|shared| {
            shared.holds.add(hold);
            if is_aborting && let Some((_, break_off)) = &shared.busy {
                break_off.request();
            }
        });
    }

    /// Ends holds that have ended in the desk's ledger, so that the other desks end them too.
    pub(super) fn end_holds(&self, ids: &[String], most_placements: u32) {
        self.change(|shared| {
            if let Some(left) = shared.holds.without(ids) {
                shared.holds = left;
                shared.most_placements = most_placements;
            }
        });
    }

    /// Changes what all desks see, and wakes the others.
    fn change(&self, change: impl FnOnce(&mut Shared)) {
        let mut shared = self.robot.lock();
        change(&mut shared);
        let others = shared.desks.iter().filter(|(cell, _)| **cell != self.cell);
        // A desk that is gone begins nothing.
        for address in others.filter_map(|(_, desk)| desk.upgrade()) {
            address.wake();
        }
    }
}

impl Shared {
    fn check_free(&self) -> Result<(), Taken> {
        self.check_open()?;
        match self.holds.is_empty() {
            true => Ok(()),
            false => Err(Taken::Held(self.holds.clone())),
        }
    }

    fn check_open(&self) -> Result<(), Taken> {
        match self.awaited.first() {
            Some(container) => Err(Taken::NotOpen(container.clone())),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use ppnpack_service::actor;

    use super::*;

    fn hold(id: &str) -> Hold {
        Hold::new(id, "", "a hand")
    }

    /// The shares of two desks in one robot.
    fn shares() -> [Share; 2] {
        let (address, _mailbox) = actor::mailbox(1);
        let names = ["left", "right"];
        let robot = SharedRobot::of(&names.map(str::to_owned));
        names.map(|name| Share::new(robot.clone(), &Cell::new(name).unwrap(), &address))
    }

    fn begin(share: &Share) -> Result<Shutdown, Taken> {
        let break_off = Shutdown::default();
        share.begin(&break_off)?;
        Ok(break_off)
    }

    #[test]
    fn a_robot_places_into_one_container_at_a_time_and_is_held_as_a_whole() {
        let [left, right] = shares();
        for share in [&left, &right] {
            share.open(&Holds::default());
        }
        let break_off = begin(&left).unwrap();
        assert_eq!(begin(&right).unwrap_err(), Taken::Busy(left.cell.clone()));
        right.end();
        assert_eq!(begin(&right).unwrap_err(), Taken::Busy(left.cell.clone()));
        right.hold(hold("h1"), false);
        assert!(!break_off.is_requested());
        right.hold(hold("h2"), true);
        assert!(break_off.is_requested());
        left.end();
        for share in [&left, &right] {
            assert!(matches!(share.check_free(), Err(Taken::Held(_))));
            assert!(matches!(begin(share), Err(Taken::Held(_))));
        }
        left.end_holds(&["h1".to_owned()], 7);
        assert!(matches!(begin(&right), Err(Taken::Held(_))));
        right.end_holds(&["h1".to_owned(), "h2".to_owned()], 1);
        assert_eq!(left.robot_holds(), (Holds::default(), 1));
        assert!(begin(&right).is_ok());
    }

    #[test]
    fn nothing_begins_before_it_is_known_of_all_containers_what_holds_them() {
        let [left, right] = shares();
        left.open(&Holds::default());
        for share in [&left, &right] {
            let not_open = Taken::NotOpen("right".to_owned());
            assert_eq!(begin(share).unwrap_err(), not_open);
            assert_eq!(share.check_open(), Err(not_open));
        }
        let mut holds = Holds::default();
        holds.add(hold("cut off"));
        right.open(&holds);
        assert_eq!(begin(&left).unwrap_err(), Taken::Held(holds));
        assert_eq!(left.check_open(), Ok(()));
    }
}
