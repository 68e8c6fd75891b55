//! The beginning of a desk: what the journal knows of the cell.

use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use ppnpack_service::rpc::Incoming;
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1::Status;

use super::{Mail, RETRY_AFTER};
use crate::journal::{CellJournal, JournalError};
use crate::ledger::Ledger;
use crate::robot::Robot;

/// Reads the ledger of a cell, settles what was cut off, and has the robot go on from there. Until the journal can be
/// read and written, requests are refused. `None` where the end is asked for before that.
pub(crate) fn open(
    journal: &mut CellJournal,
    robot: &mut dyn Robot,
    mail: &Receiver<Mail>,
) -> Option<Ledger> {
    let mut ledger = persist(mail, || journal.load())?;
    let settled = ledger.recover(robot.is_simulated());
    let change = settled.unwrap_or_else(|| ledger.no_change());
    persist(mail, || journal.write(&ledger, &change))?;
    ledger.apply(change);

    let bodies = robot.resume(ledger.head().bodies.clone());
    if bodies != ledger.head().bodies {
        let change = ledger.find_bodies(bodies);
        persist(mail, || journal.write(&ledger, &change))?;
        ledger.apply(change);
    }
    Some(ledger)
}

/// Tries until it works; `None` where the end is asked for before.
fn persist<T>(
    mail: &Receiver<Mail>,
    mut work: impl FnMut() -> Result<T, JournalError>,
) -> Option<T> {
    loop {
        match work() {
            Ok(done) => return Some(done),
            Err(error) => refuse_for(RETRY_AFTER, mail, &error)?,
        }
    }
}

/// Refuses what comes, for a while; `None` where the end is asked for.
fn refuse_for(span: Duration, mail: &Receiver<Mail>, error: &JournalError) -> Option<()> {
    let until = Instant::now() + span;
    loop {
        let left = until.saturating_duration_since(Instant::now());
        match mail.recv_timeout(left) {
            Ok(Mail::Place(incoming)) => refuse(incoming, error),
            Ok(Mail::Outcome(incoming)) => refuse(incoming, error),
            Ok(Mail::Renew(incoming)) => refuse(incoming, error),
            Ok(Mail::State(incoming)) => refuse(incoming, error),
            Ok(Mail::End) | Err(RecvTimeoutError::Disconnected) => return None,
            Ok(_) => {}
            Err(RecvTimeoutError::Timeout) => return Some(()),
        }
    }
}

fn refuse<R: Request>(incoming: Incoming<R>, error: &JournalError) {
    incoming.refuse(Status::Unavailable, error.to_string());
}
