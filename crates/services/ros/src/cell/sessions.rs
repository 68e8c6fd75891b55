//! The sessions of a cell, as its planner tells them.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use ppnpack_ros::Publisher;
use ppnpack_ros::messages::ppnpack_msgs::Session;
use ppnpack_service::stream::{self, Subscription};
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::{MAX_MESSAGE_BYTES, v1};

use crate::cells::Common;
use crate::convert::messages;
use crate::error::FaceError;

/// How long the planner may take to tell the session that is under way.
const SESSION_LIMIT: Duration = Duration::from_secs(1);

/// The sessions of a cell as they are told.
struct Sessions {
    cell: Cell,
    publisher: Publisher<Session>,
    is_told: Mutex<bool>,
}

impl Sessions {
    /// Passes on what the planner tells.
    fn follow(&self, session: &v1::Session) {
        *self.is_told() = true;
        self.publish(session);
    }

    /// Passes on what was asked for, unless something was told since: that may be newer.
    fn begin(&self, session: &v1::Session) {
        let is_told = self.is_told();
        if !*is_told {
            self.publish(session);
        }
    }

    fn publish(&self, session: &v1::Session) {
        let message = messages::session(&self.cell, session);
        if let Err(error) = self.publisher.publish(&message) {
            tracing::debug!(cell = %self.cell, %error, "a session is not passed on");
        }
    }

    fn is_told(&self) -> MutexGuard<'_, bool> {
        self.is_told.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Passes sessions on, the one that is under way first: the planner tells it on change alone, which may not come for long.
pub(super) fn follow(
    common: &Common,
    cell: &Cell,
    publisher: Publisher<Session>,
) -> Result<Subscription, FaceError> {
    let sessions = Arc::new(Sessions {
        cell: cell.clone(),
        publisher,
        is_told: Mutex::new(false),
    });
    let followed = Arc::clone(&sessions);
    let subscription = stream::subscribe(
        common.process.session(),
        Some(cell),
        Stream::Session,
        MAX_MESSAGE_BYTES,
        move |_, session: v1::Session| followed.follow(&session),
    )?;
    let asked = v1::SessionRequest::default();
    match common.requests.ask_within(cell, asked, SESSION_LIMIT) {
        Ok(reply) => sessions.begin(&reply.session.unwrap_or_default()),
        Err(error) => tracing::debug!(%cell, %error, "the session is told when it changes"),
    }
    Ok(subscription)
}
