//! Settings of the engine from dictionaries: the same names and values as in its JSON files.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// Converts a Python value of dictionaries, lists, strings, numbers, booleans and `None` to JSON.
pub(crate) fn json(value: &Bound<'_, PyAny>) -> PyResult<Value> {
    let dumps = value.py().import("json")?.getattr("dumps")?;
    let options = PyDict::new(value.py());
    options.set_item("allow_nan", false)?;
    let text: String = dumps.call((value,), Some(&options))?.extract()?;
    serde_json::from_str(&text).map_err(|error| PyValueError::new_err(error.to_string()))
}

/// Reads settings from a dictionary, and keyword arguments that win over it.
pub(crate) fn settings<T: DeserializeOwned>(
    what: &str,
    base: Option<&Bound<'_, PyDict>>,
    over: Option<&Bound<'_, PyDict>>,
    py: Python<'_>,
) -> PyResult<T> {
    let all = match base {
        Some(base) => base.copy()?,
        None => PyDict::new(py),
    };
    if let Some(over) = over {
        all.update(over.as_mapping())?;
    }
    let read = serde_json::from_value(json(all.as_any())?);
    read.map_err(|error| PyValueError::new_err(format!("{what}: {error}")))
}
