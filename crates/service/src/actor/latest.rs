//! Data of which only the newest counts.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};
use std::time::Instant;

use super::Address;
use crate::sync::lock;

/// The latest value of each source, until the actor takes it. Clones share them, among the actor
/// and its sources.
pub struct LatestValues<K, T> {
    shared: Arc<Shared<K, T>>,
}

struct Shared<K, T> {
    slots: Mutex<BTreeMap<K, Slot<T>>>,
    wake: Box<dyn Fn() + Send + Sync>,
}

struct Slot<T> {
    /// `None` once it is taken.
    value: Option<T>,
    put_at: Instant,
}

impl<K: Ord, T> LatestValues<K, T> {
    /// Makes values that wake this actor, which ends nevertheless once nobody has its address.
    pub fn new<M: Send + 'static>(actor: &Address<M>) -> Self {
        let actor = actor.downgrade();
        let shared = Shared {
            slots: Mutex::default(),
            wake: Box::new(move || actor.upgrade().iter().for_each(Address::wake)),
        };
        let shared = Arc::new(shared);
        Self { shared }
    }

    /// Puts a value and wakes the actor; gives the one before, where it was not taken. Waits for no
    /// more than a lock.
    pub fn put(&self, source: K, value: T) -> Option<T> {
        let slot = Slot {
            value: Some(value),
            put_at: Instant::now(),
        };
        let before = lock(&self.shared.slots).insert(source, slot);
        (self.shared.wake)();
        before.and_then(|before| before.value)
    }

    /// Takes the values that were not taken yet.
    pub fn take(&self) -> BTreeMap<K, T>
    where
        K: Clone,
    {
        let mut slots = lock(&self.shared.slots);
        let slots = slots.iter_mut();
        let taken = slots.filter_map(|(source, slot)| Some((source.clone(), slot.value.take()?)));
        taken.collect()
    }

    /// Gives the time of a source's last value, whether or not it was taken.
    pub fn last_put(&self, source: &K) -> Option<Instant> {
        let slots = lock(&self.shared.slots);
        slots.get(source).map(|slot| slot.put_at)
    }
}

impl<K, T> Clone for LatestValues<K, T> {
    fn clone(&self) -> Self {
        let shared = Arc::clone(&self.shared);
        Self { shared }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Closed, mailbox};
    use super::*;

    #[test]
    fn only_the_latest_of_each_source_is_kept() {
        let (address, mailbox) = mailbox::<()>(1);
        let latest = LatestValues::new(&address);
        assert_eq!(latest.last_put(&"left"), None);
        assert_eq!(latest.put("left", 1), None);
        assert_eq!(latest.put("left", 2), Some(1));
        assert_eq!(latest.put("right", 7), None);
        assert_eq!(mailbox.receive(None), Ok(None), "it wakes");
        assert_eq!(latest.take(), BTreeMap::from([("left", 2), ("right", 7)]));
        assert!(latest.take().is_empty());
        assert_eq!(latest.put("left", 3), None);
        assert!(latest.last_put(&"left") >= latest.last_put(&"right"));
        drop(address);
        assert_eq!(mailbox.receive(None), Ok(None));
        assert_eq!(mailbox.receive(None), Err(Closed));
        assert_eq!(latest.take(), BTreeMap::from([("left", 3)]));
    }
}
