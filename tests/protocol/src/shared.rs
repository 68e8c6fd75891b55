//! What most steps leave as it is.

use std::hash::{DefaultHasher, Hasher};
use std::ops::{Deref, DerefMut};
use std::sync::{Arc, OnceLock};

/// A value that the copies of a world share until one of them changes it; it is hashed once.
#[derive(Debug, Clone)]
pub(crate) struct Shared<T>(Arc<Hashed<T>>);

#[derive(Debug, Clone)]
struct Hashed<T> {
    value: T,
    hash: OnceLock<u64>,
}

impl<T> Shared<T> {
    pub(crate) fn new(value: T) -> Self {
        let hash = OnceLock::new();
        Self(Arc::new(Hashed { value, hash }))
    }

    /// What `hash` makes of the value, which has to be the same function each time.
    pub(crate) fn hash_by(&self, hash: impl FnOnce(&T, &mut DefaultHasher)) -> u64 {
        *self.0.hash.get_or_init(|| {
            let mut hasher = DefaultHasher::new();
            hash(&self.0.value, &mut hasher);
            hasher.finish()
        })
    }
}

impl<T> Deref for Shared<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.0.value
    }
}

impl<T: Clone> DerefMut for Shared<T> {
    fn deref_mut(&mut self) -> &mut T {
        let own = Arc::make_mut(&mut self.0);
        own.hash = OnceLock::new();
        &mut own.value
    }
}

impl<T: PartialEq> PartialEq for Shared<T> {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.0.value == other.0.value
    }
}

#[cfg(test)]
mod tests {
    use std::hash::Hash;

    use super::*;

    #[test]
    fn a_copy_that_changes_leaves_the_others_and_is_hashed_anew() {
        let hash = |shared: &Shared<u8>| shared.hash_by(|value, hasher| value.hash(hasher));
        let first = Shared::new(1);
        let before = hash(&first);
        let mut second = first.clone();
        assert_eq!(hash(&second), before);
        *second = 2;
        assert_eq!((*first, *second), (1, 2));
        assert_eq!(hash(&first), before);
        assert_eq!(hash(&second), hash(&Shared::new(2)));
        assert_ne!(hash(&second), before);
    }
}
