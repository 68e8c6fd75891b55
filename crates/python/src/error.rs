//! Errors of the engine as exceptions, in the same words.

use std::error::Error;
use std::fmt::Display;
use std::sync::{Mutex, MutexGuard, TryLockError};

use pyo3::PyErr;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;

/// Turns what went wrong into an exception.
pub(crate) trait OrRaise<T> {
    /// Raises `ValueError`: an input is wrong.
    fn or_value_error(self) -> PyResult<T>;

    /// Raises `RuntimeError`: something went wrong on the way.
    fn or_runtime_error(self) -> PyResult<T>;
}

impl<T, E: Display> OrRaise<T> for Result<T, E> {
    fn or_value_error(self) -> PyResult<T> {
        self.map_err(|error| PyValueError::new_err(error.to_string()))
    }

    fn or_runtime_error(self) -> PyResult<T> {
        self.map_err(|error| PyRuntimeError::new_err(error.to_string()))
    }
}

/// Locks what one thread uses at a time; `RuntimeError` in these words where another does.
pub(crate) fn unused<'a, T>(
    shared: &'a Mutex<T>,
    busy: &'static str,
) -> PyResult<MutexGuard<'a, T>> {
    match shared.try_lock() {
        Ok(free) => Ok(free),
        Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
        Err(TryLockError::WouldBlock) => Err(PyRuntimeError::new_err(busy)),
    }
}

/// Refuses work on threads that stayed with another process when this one was forked.
pub(crate) fn not_forked(made_in: u32) -> PyResult<()> {
    if made_in == std::process::id() {
        return Ok(());
    }
    Err(PyRuntimeError::new_err(
        "its threads stayed with the process that made it: make it after the fork, or with threads=1",
    ))
}

/// Finds the exception that led to an error, where Python code that the engine called raised one.
pub(crate) fn raised(py: Python<'_>, error: &(dyn Error + 'static)) -> Option<PyErr> {
    let mut cause = Some(error);
    while let Some(error) = cause {
        if let Some(exception) = error.downcast_ref::<PyErr>() {
            return Some(exception.clone_ref(py));
        }
        cause = error.source();
    }
    None
}
