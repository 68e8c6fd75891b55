//! The memory that clouds may take at once.

use std::ops::Deref;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A bound on the bytes of all clouds that the service holds: those that wait, are looked at or are
/// kept. Clones share it.
#[derive(Debug, Clone)]
pub(crate) struct Budget(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    most_bytes: usize,
    held_bytes: AtomicUsize,
}

/// Room for a cloud, given back when it is dropped.
#[derive(Debug)]
pub(crate) struct Room {
    budget: Budget,
    bytes: usize,
}

/// A cloud, and the room that it takes for as long as it is there.
#[derive(Debug)]
pub(crate) struct Held<T> {
    cloud: T,
    room: Room,
}

impl Budget {
    pub(crate) fn new(most_bytes: usize) -> Self {
        Self(Arc::new(Shared {
            most_bytes,
            held_bytes: AtomicUsize::new(0),
        }))
    }

    /// Takes room for so many bytes; `None` where the clouds that are held leave too little.
    pub(crate) fn room(&self, bytes: usize) -> Option<Room> {
        let Shared {
            most_bytes,
            held_bytes,
        } = &*self.0;
        let with = |held: usize| held.checked_add(bytes).filter(|held| held <= most_bytes);
        let taken = held_bytes.fetch_update(Ordering::Relaxed, Ordering::Relaxed, with);
        let budget = self.clone();
        taken.is_ok().then(|| Room { budget, bytes })
    }
}

impl Drop for Room {
    fn drop(&mut self) {
        let held_bytes = &self.budget.0.held_bytes;
        held_bytes.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

impl Room {
    /// Gives a cloud the room.
    pub(crate) fn with<T>(self, cloud: T) -> Held<T> {
        Held { cloud, room: self }
    }
}

impl<T> Held<T> {
    /// Reads the cloud further, in the same room.
    pub(crate) fn read<U, E>(self, read: impl FnOnce(T) -> Result<U, E>) -> Result<Held<U>, E> {
        let cloud = read(self.cloud)?;
        Ok(self.room.with(cloud))
    }
}

impl<T> Deref for Held<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.cloud
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_clouds_that_are_held_never_take_more_than_they_may() {
        let budget = Budget::new(100);
        let first = budget.room(60).unwrap().with("first");
        assert!(budget.room(41).is_none());
        assert!(budget.room(usize::MAX).is_none());
        let second = budget.room(40).unwrap().with("second");
        assert!(budget.room(1).is_none());
        let read = first.read(|cloud| Ok::<usize, ()>(cloud.len())).unwrap();
        assert_eq!(*read, 5);
        assert!(budget.room(1).is_none(), "it is held still");
        drop(read);
        assert!(budget.room(61).is_none());
        assert!(second.read(|_| Err::<(), ()>(())).is_err());
        assert!(budget.room(100).is_some(), "all is given back");
    }
}
