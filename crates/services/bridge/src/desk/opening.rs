//! The beginning of a desk: it reads the cell's ledger from the journal.

use std::time::{Duration, Instant};

use ppnpack_protocol::ledger::{AFTER_ANOTHER, Ledger};
use ppnpack_service::actor::Mailbox;
use ppnpack_service::rpc::Incoming;
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1::Status;

use super::share::Share;
use super::{Message, RETRY_AFTER};
use crate::journal::{CellJournal, JournalError};

/// The requests that come before there is a desk.
pub(crate) struct Early<'a> {
    pub(crate) mailbox: &'a Mailbox<Message>,
    /// Keeps the holds that come for the desk.
    pub(crate) share: &'a Share,
}

/// Reads the ledger of a cell, and settles what was cut off.
///
/// Until the journal can be read and written, requests are refused. Where another bridge served the
/// cell, it is not known what that did. `None` where the end is asked for meanwhile.
pub(crate) fn open(
    journal: &mut CellJournal,
    is_simulated: bool,
    early: &Early<'_>,
    is_after_another: bool,
) -> Option<Ledger> {
    let mut ledger = early.persist(|| journal.load())?;
    let change = match is_after_another {
        true => ledger.restored(AFTER_ANOTHER),
        false => {
            let settled = ledger.recover(is_simulated);
            settled.unwrap_or_else(|| ledger.no_change())
        }
    };
    early.persist(|| journal.write(&ledger, &change))?;
    ledger.apply(change);
    Some(ledger)
}

impl Early<'_> {
    /// Tries until it works; `None` where the end is asked for before.
    fn persist<T>(&self, mut work: impl FnMut() -> Result<T, JournalError>) -> Option<T> {
        loop {
            match work() {
                Ok(done) => return Some(done),
                Err(error) => self.refuse_for(RETRY_AFTER, &error)?,
            }
        }
    }

    /// Refuses what comes, for a while; `None` where the end is asked for.
    fn refuse_for(&self, span: Duration, error: &JournalError) -> Option<()> {
        let until = Instant::now() + span;
        loop {
            match self.mailbox.receive(Some(until)).ok()? {
                Some(Message::Place(incoming)) => refuse(incoming, error),
                Some(Message::Outcome(incoming)) => refuse(incoming, error),
                Some(Message::Renew(incoming)) => refuse(incoming, error),
                Some(Message::Hold(incoming)) => {
                    self.share.hold_as_asked(&incoming);
                    refuse(incoming, error);
                }
                Some(Message::Resume(incoming)) => refuse(incoming, error),
                Some(Message::Changed(incoming)) => refuse(incoming, error),
                Some(Message::State(incoming)) => refuse(incoming, error),
                Some(Message::End) => return None,
                Some(_) => {}
                None => return Some(()),
            }
        }
    }
}

fn refuse<R: Request>(incoming: Incoming<R>, error: &JournalError) {
    incoming.refuse(Status::Unavailable, error.to_string());
}
