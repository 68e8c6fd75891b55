//! Failures: somebody has to look before anything goes on by itself, and says at which one.

use ppnpack_wire::v1;

use super::{End, PAST_KEPT, Session, SessionError};
use crate::ledger::new_state_number;
use crate::pursuit;

/// Failure of a session where another planner planned meanwhile.
pub const AFTER_ANOTHER: &str = "another planner planned for the cell, and what was packed \
     meanwhile is not known: withdraw what is in the container, or begin a new session with an \
     empty one";

/// Failure of a session that was restored.
pub const FROM_BACKUP: &str = "the session was restored from a backup, and what was packed since is \
     not known: withdraw what is in the container, or begin a new session with an empty one";

impl Session {
    /// Names the failure; `None` where it has not failed. No other failure of the cell has this
    /// name.
    pub fn failure_id(&self) -> Option<String> {
        let name = || format!("{}-{}", self.0.session_id, self.0.failures);
        self.has_failed().then(name)
    }

    /// Refuses to go on by itself after a failure, unless this names it.
    ///
    /// # Errors
    /// [`SessionError::Failed`]
    pub fn must_be_acknowledged(&self, failure_id: &str) -> Result<(), SessionError> {
        match self.failure_id() {
            Some(own) if own != failure_id => Err(SessionError::Failed(self.0.failure.clone())),
            _ => Ok(()),
        }
    }

    /// Says whether a request of this id switched the automatic mode. One without an id never did.
    pub fn was_switched_by(&self, request_id: &str) -> bool {
        self.0.switched_by.iter().any(|own| own == request_id)
    }

    /// Remembers a request that switched the automatic mode: sent again, or late, it must not
    /// switch on what was switched off after it.
    pub fn remember_switch(&mut self, request_id: &str) {
        if request_id.is_empty() {
            return;
        }
        let ids = &mut self.0.switched_by;
        ids.push(request_id.to_owned());
        let surplus = ids.len().saturating_sub(PAST_KEPT);
        ids.drain(..surplus);
    }

    /// Switches the automatic mode; switching it on acknowledges the failure that is named.
    pub fn set_automatic(
        &mut self,
        is_automatic: bool,
        failure_id: &str,
    ) -> Result<(), SessionError> {
        self.must_be_under_way()?;
        if is_automatic {
            self.must_be_acknowledged(failure_id)?;
            self.set_end(None);
        }
        self.0.is_automatic = is_automatic;
        Ok(())
    }

    /// Restores a session that does not know what was packed since it was written, for this reason,
    /// such as [`FROM_BACKUP`]. The outcome of the pending decision is unknown: a later one may
    /// have placed its item.
    pub fn restored(&mut self, reason: &str) {
        // By the time: since it was written it may have failed.
        self.restored_after(new_state_number(), reason);
    }

    /// Restores as [`Self::restored`] does, with a number of failures that it cannot have had.
    pub fn restored_after(&mut self, failures: u64, reason: &str) {
        if self.id().is_empty() {
            return;
        }
        self.0.failures = self.0.failures.max(failures);
        if let Some(decision) = self.0.pending.take() {
            let unknown = pursuit::settled_as(&decision, v1::OutcomeKind::Unknown, reason, 0);
            self.settle(decision, &unknown);
        }
        self.end(End::Failed(reason.to_owned()));
    }
}
