//! The sessions of a cell, as its planner tells them.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use ppnpack_ros::messages::ppnpack_msgs::Session;
use ppnpack_ros::{Publisher, RosError};
use ppnpack_service::stream::Subscription;
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::v1;

use super::follow;
use crate::cells::Common;
use crate::convert::messages;
use crate::error::FaceError;

/// How long the planner may take to tell the session that is under way.
const SESSION_LIMIT: Duration = Duration::from_secs(1);

/// The sessions of a cell as they are told.
struct Sessions {
    publisher: Publisher<Session>,
    is_told: Mutex<bool>,
}

impl Sessions {
    /// Passes on what the planner tells.
    fn follow(&self, cell: &Cell, session: &v1::Session) -> Result<(), RosError> {
        *self.is_told() = true;
        self.publisher.publish(&messages::session(cell, session))
    }

    /// Passes on what was asked for, unless something was told since: that may be newer.
    fn begin(&self, cell: &Cell, session: &v1::Session) -> Result<(), RosError> {
        let is_told = self.is_told();
        if *is_told {
            return Ok(());
        }
        self.publisher.publish(&messages::session(cell, session))
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
        publisher,
        is_told: Mutex::new(false),
    });
    let followed = Arc::clone(&sessions);
    let subscription = follow::each(common, cell, Stream::Session, move |cell, session| {
        followed.follow(cell, session)
    })?;
    let asked = v1::SessionRequest::default();
    match common.requests.ask_within(cell, asked, SESSION_LIMIT) {
        Ok(reply) => sessions.begin(cell, &reply.session.unwrap_or_default())?,
        Err(error) => tracing::debug!(%cell, %error, "the session is told when it changes"),
    }
    Ok(subscription)
}
