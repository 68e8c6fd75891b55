//! The mailboxes in which the messages of actors wait.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Weak};
use std::time::Instant;

use ppnpack_wire::keys::Cell;
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1::Status;

use crate::error::ServiceError;
use crate::process::Process;
use crate::rpc::{self, Incoming, Listener};

/// Room in a mailbox beyond its capacity, for messages that must not be refused with ordinary ones.
const RESERVE: usize = 64;

/// The other end of a mailbox is gone: an actor that has ended, or all who had its address.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the other end of the mailbox is gone")]
pub struct Closed;

/// The messages of an actor, oldest first.
pub struct Mailbox<M> {
    letters: Receiver<Letter<M>>,
    counts: Arc<Counts>,
}

/// The address of an actor. Clones reach the same one.
pub struct Address<M>(Arc<Sender<M>>);

/// An [`Address`] that does not keep its actor from ending: for the actor itself, and for those
/// that it waits for.
pub struct WeakAddress<M>(Weak<Sender<M>>);

struct Sender<M> {
    letters: SyncSender<Letter<M>>,
    /// The number of messages that may wait before ordinary ones are refused.
    capacity: usize,
    counts: Arc<Counts>,
}

#[derive(Default)]
struct Counts {
    /// Whether a wake-up waits: one is enough.
    is_woken: AtomicBool,
    waiting: AtomicUsize,
}

impl<M> Sender<M> {
    /// Sends a message where fewer than so many wait.
    fn try_send(&self, message: M, most: usize) -> Result<(), TrySendError<Letter<M>>> {
        let letter = Letter::Message(message);
        let waiting = &self.counts.waiting;
        let sent = match waiting.fetch_add(1, Ordering::AcqRel) < most {
            true => self.letters.try_send(letter),
            false => Err(TrySendError::Full(letter)),
        };
        if sent.is_err() {
            waiting.fetch_sub(1, Ordering::AcqRel);
        }
        sent
    }
}

enum Letter<M> {
    Message(M),
    WakeUp,
}

/// Makes a mailbox for so many messages, and its address.
pub fn mailbox<M>(capacity: usize) -> (Address<M>, Mailbox<M>) {
    let capacity = capacity.max(1);
    let (sender, letters) = sync_channel(capacity.saturating_add(RESERVE));
    let counts = Arc::new(Counts::default());
    let address = Address(Arc::new(Sender {
        letters: sender,
        capacity,
        counts: Arc::clone(&counts),
    }));
    (address, Mailbox { letters, counts })
}

impl<M> Mailbox<M> {
    /// Waits for a message; `None` where the actor was woken or the time has come before there is
    /// one.
    ///
    /// # Errors
    /// [`Closed`] when all messages are taken and no more can come.
    pub fn receive(&self, until: Option<Instant>) -> Result<Option<M>, Closed> {
        let letter = match until {
            None => self.letters.recv().map_err(|_| Closed)?,
            Some(until) => {
                let left = until.saturating_duration_since(Instant::now());
                match self.letters.recv_timeout(left) {
                    Ok(letter) => letter,
                    Err(RecvTimeoutError::Timeout) => return Ok(None),
                    Err(RecvTimeoutError::Disconnected) => return Err(Closed),
                }
            }
        };
        Ok(self.open(letter))
    }

    /// Takes the messages that are there, without waiting for more.
    pub fn take_waiting(&self) -> impl Iterator<Item = M> {
        let letters = self.letters.try_iter();
        letters.filter_map(move |letter| self.open(letter))
    }

    fn open(&self, letter: Letter<M>) -> Option<M> {
        match letter {
            Letter::Message(message) => {
                self.counts.waiting.fetch_sub(1, Ordering::AcqRel);
                Some(message)
            }
            Letter::WakeUp => {
                // Before the actor looks: a wake-up from now on is another one.
                self.counts.is_woken.store(false, Ordering::Release);
                None
            }
        }
    }
}

impl<M> Address<M> {
    /// Sends a message, and waits where the mailbox is full. Not for Zenoh's threads.
    ///
    /// # Errors
    /// [`Closed`] where the actor has ended.
    pub fn send(&self, message: M) -> Result<(), Closed> {
        self.0.counts.waiting.fetch_add(1, Ordering::AcqRel);
        let sent = self.0.letters.send(Letter::Message(message));
        sent.map_err(|_| Closed)
    }

    /// Sends a message where the mailbox has room; says whether it had.
    pub fn try_send(&self, message: M) -> bool {
        self.0.try_send(message, self.0.capacity).is_ok()
    }

    /// Has the actor look around, as soon as it has handled all messages before. Never waits.
    pub fn wake(&self) {
        let is_woken = &self.0.counts.is_woken;
        let was_woken = is_woken.swap(true, Ordering::AcqRel);
        if !was_woken && self.0.letters.try_send(Letter::WakeUp).is_err() {
            // It looks around all the same after each message that fills the mailbox.
            is_woken.store(false, Ordering::Release);
        }
    }

    /// Has the actor answer a method, for a cell or for every cell. Requests are refused with
    /// `STATUS_BUSY` where the mailbox is full, with `STATUS_UNAVAILABLE` where the actor has
    /// ended.
    ///
    /// # Errors
    /// [`ServiceError::Zenoh`] where the session is closed.
    pub fn listen<R: Request>(
        &self,
        process: &Process,
        cell: Option<&Cell>,
        wrap: impl Fn(Incoming<R>) -> M + Send + Sync + 'static,
    ) -> Result<Listener, ServiceError>
    where
        M: Send + 'static,
    {
        self.listen_within(self.0.capacity, process, cell, wrap)
    }

    /// Has the actor answer as [`Self::listen`] does, also where the mailbox is full of others:
    /// these requests have a reserve.
    ///
    /// # Errors
    /// As [`Self::listen`].
    pub fn listen_past_others<R: Request>(
        &self,
        process: &Process,
        cell: Option<&Cell>,
        wrap: impl Fn(Incoming<R>) -> M + Send + Sync + 'static,
    ) -> Result<Listener, ServiceError>
    where
        M: Send + 'static,
    {
        self.listen_within(usize::MAX, process, cell, wrap)
    }

    /// Has the actor answer where fewer than so many messages wait.
    fn listen_within<R: Request>(
        &self,
        most: usize,
        process: &Process,
        cell: Option<&Cell>,
        wrap: impl Fn(Incoming<R>) -> M + Send + Sync + 'static,
    ) -> Result<Listener, ServiceError>
    where
        M: Send + 'static,
    {
        let sender = Arc::clone(&self.0);
        rpc::listen(process, cell, move |incoming| {
            // A message cannot be unwrapped here, but it can be dropped.
            match sender.try_send(wrap(incoming), most) {
                Ok(()) => {}
                Err(TrySendError::Full(letter)) => {
                    rpc::drop_with(letter, Status::Busy, "the queue is full");
                }
                Err(TrySendError::Disconnected(letter)) => {
                    rpc::drop_with(letter, Status::Unavailable, "the service is ending");
                }
            }
        })
    }

    /// Gives the same address, for those who must not keep the actor from ending.
    pub fn downgrade(&self) -> WeakAddress<M> {
        WeakAddress(Arc::downgrade(&self.0))
    }
}

impl<M> WeakAddress<M> {
    /// Gives the address; `None` where nobody else has it any more.
    pub fn upgrade(&self) -> Option<Address<M>> {
        self.0.upgrade().map(Address)
    }
}

impl<M> Clone for Address<M> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

impl<M> Clone for WeakAddress<M> {
    fn clone(&self) -> Self {
        Self(Weak::clone(&self.0))
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn soon() -> Option<Instant> {
        Some(Instant::now() + Duration::from_millis(1))
    }

    #[test]
    fn messages_come_in_their_order_and_those_that_must_not_be_refused_have_a_reserve() {
        let (address, mailbox) = mailbox(2);
        assert!(address.try_send(1) && address.clone().try_send(2) && !address.try_send(3));
        assert_eq!(mailbox.receive(None), Ok(Some(1)));
        assert!(address.try_send(4));
        assert!(address.0.try_send(5, usize::MAX).is_ok() && !address.try_send(6));
        assert_eq!(mailbox.take_waiting().collect::<Vec<_>>(), [2, 4, 5]);
        assert_eq!(mailbox.receive(soon()), Ok(None));
        assert!(address.try_send(7));
    }

    #[test]
    fn what_was_sent_is_received_before_the_end() {
        let (address, mailbox) = mailbox(1);
        let weak = address.downgrade();
        address.send(1).unwrap();
        assert!(weak.upgrade().is_some());
        drop(address);
        assert!(weak.upgrade().is_none());
        assert_eq!(mailbox.receive(None), Ok(Some(1)));
        assert_eq!(mailbox.receive(None), Err(Closed));
        assert_eq!(mailbox.receive(soon()), Err(Closed));
    }

    #[test]
    fn one_wake_up_waits_at_most_and_none_is_lost_on_a_full_mailbox() {
        let (address, mailbox) = mailbox(2);
        address.wake();
        address.wake();
        assert!(address.try_send(1), "the second wake-up takes no room");
        address.wake();
        assert_eq!(mailbox.receive(None), Ok(None));
        assert_eq!(mailbox.receive(None), Ok(Some(1)));
        assert!(address.try_send(2) && address.try_send(3));
        address.wake();
        for message in [2, 3] {
            assert_eq!(mailbox.receive(None), Ok(Some(message)));
        }
        address.wake();
        assert_eq!(mailbox.receive(None), Ok(None));
    }
}
