//! Locks of which a panic takes nothing away.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// The content of a mutex, also where a thread panicked that held it.
pub fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
