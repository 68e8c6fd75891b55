//! The session of a cell as it is kept: each change is on disk before anything follows from it.

use std::ops::Deref;
use std::sync::Arc;
use std::time::Instant;

use ppnpack_protocol::session::{End, Session, SessionError};
use ppnpack_service::ServiceError;
use ppnpack_service::process::Process;
use ppnpack_service::stream::Publisher;
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::v1;

use super::Shared;
use crate::counts;
use crate::refusal::Refusal;
use crate::settings::CellSettings;
use crate::store::StoreError;

/// The number of changes of a cell's session.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Version {
    sessions: u64,
    announcements: u64,
    /// Changes that are no announcements.
    others: u64,
}

impl Version {
    /// Says whether nothing has changed since an earlier version but for items that are new.
    pub(super) fn is_but_for_new_items(&self, since: &Self) -> bool {
        self.is_of_same_session(since) && self.others == since.others
    }

    pub(super) fn is_of_same_session(&self, other: &Self) -> bool {
        self.sessions == other.sessions
    }
}

/// A session on disk.
pub(super) struct KeptSession {
    cell: Cell,
    shared: Arc<Shared>,
    /// The number of waiting items that may be chosen from.
    buffer: usize,
    publisher: Publisher<v1::Session>,
    session: Session,
    version: Version,
    /// The session on disk, where that is not this one.
    on_disk: Option<Session>,
    is_published: bool,
    /// Time when containers are looked at that may be closed; `None` until something changes.
    pub(super) closes_at: Option<Instant>,
}

impl Deref for KeptSession {
    type Target = Session;

    fn deref(&self) -> &Session {
        &self.session
    }
}

impl KeptSession {
    /// Takes up the session that is on disk.
    pub(super) fn read(
        process: &Process,
        cell: &Cell,
        settings: &CellSettings,
        shared: &Arc<Shared>,
    ) -> Result<Self, ServiceError> {
        let session = shared.store.session(cell).map_err(ServiceError::start)?;
        Ok(Self {
            cell: cell.clone(),
            shared: Arc::clone(shared),
            buffer: settings.method.buffer,
            publisher: Publisher::new(process, cell, Stream::Session)?,
            session,
            version: Version::default(),
            on_disk: None,
            is_published: false,
            // The container that was closed last may not be on disk as such.
            closes_at: Some(Instant::now()),
        })
    }

    pub(super) fn version(&self) -> Version {
        self.version
    }

    pub(super) fn message(&self) -> v1::Session {
        self.to_message(self.buffer)
    }

    /// Publishes the session where it has changed.
    pub(super) fn publish(&mut self) {
        let is_published = std::mem::replace(&mut self.is_published, true);
        if !is_published && let Err(error) = self.publisher.put(&self.message()) {
            tracing::warn!(cell = %self.cell, %error, "the session is not published");
        }
    }

    /// Puts another session in place of this one; on an error nothing has changed.
    pub(super) fn begin(&mut self, next: Session) -> Result<(), Refusal> {
        let saved = self.shared.store.begin(&self.cell, &next);
        self.saved(saved)?;
        self.session = next;
        self.version.sessions += 1;
        self.is_published = false;
        Ok(())
    }

    /// Ends the session, in this way.
    pub(super) fn end(&mut self, end: End) -> Result<(), Refusal> {
        self.change(|session| {
            session.end(end);
            Ok(())
        })
    }

    /// Changes the session; on an error nothing has changed.
    pub(super) fn change(
        &mut self,
        change: impl FnOnce(&mut Session) -> Result<(), SessionError>,
    ) -> Result<(), Refusal> {
        let had_ended = self.has_ended();
        self.change_unsaved(change)?;
        self.save_with(&[])?;
        if self.has_ended() && !had_ended {
            counts::sessions_ended(&self.cell, self.message().end(), 1);
        }
        Ok(())
    }

    /// Announces items as [`Self::change`] changes the session, and saves their heightmaps with it.
    pub(super) fn announce(
        &mut self,
        shapes: &[v1::Item],
        announce: impl FnOnce(&mut Session) -> Result<(), SessionError>,
    ) -> Result<(), Refusal> {
        let before = self.version;
        self.change_unsaved(announce)?;
        self.save_with(shapes)?;
        if self.version != before {
            self.version = Version {
                announcements: before.announcements + 1,
                ..before
            };
        }
        Ok(())
    }

    /// Changes the session, for who saves it with what follows.
    pub(super) fn change_unsaved(
        &mut self,
        change: impl FnOnce(&mut Session) -> Result<(), SessionError>,
    ) -> Result<(), Refusal> {
        let mut next = self.session.clone();
        change(&mut next)?;
        if next != self.session {
            let before = std::mem::replace(&mut self.session, next);
            self.on_disk.get_or_insert(before);
            self.version.others += 1;
            self.is_published = false;
            self.closes_at = Some(Instant::now());
        }
        Ok(())
    }

    /// Saves what has changed; on an error the session is what it is on disk.
    pub(super) fn save(&mut self) -> Result<(), Refusal> {
        self.save_with(&[])
    }

    fn save_with(&mut self, shapes: &[v1::Item]) -> Result<(), Refusal> {
        let Some(on_disk) = self.on_disk.take() else {
            return Ok(());
        };
        let saved = self.shared.store.save(&self.cell, &self.session, shapes);
        let saved = self.saved(saved);
        if saved.is_err() {
            self.session = on_disk;
        }
        saved
    }

    /// Notes whether the disk serves.
    fn saved(&self, saved: Result<(), StoreError>) -> Result<(), Refusal> {
        match &saved {
            Ok(()) => self.shared.store_health.pass(),
            // The disk is as good as before.
            Err(StoreError::TooManyShapes { .. }) => {}
            Err(error) => {
                tracing::error!(cell = %self.cell, %error, "nothing is acknowledged");
                self.shared.store_health.fail(error.to_string());
            }
        }
        Ok(saved?)
    }
}
