//! NumPy arrays in and out.

use numpy::ndarray::{Dim, Dimension, IntoDimension};
use numpy::{
    Element, IntoPyArray, PyArray, PyArray1, PyArrayMethods, PyReadonlyArray, PyUntypedArrayMethods,
};
use pyo3::prelude::*;

/// Copies the values of an array, row-major, for the engine to keep.
pub(crate) fn values<T: Element + Copy, D: Dimension>(array: &PyReadonlyArray<'_, T, D>) -> Vec<T> {
    match array.as_slice() {
        Ok(values) if array.is_c_contiguous() => values.to_vec(),
        _ => array.as_array().iter().copied().collect(),
    }
}

/// Moves values into an array of one dimension.
pub(crate) fn array1<T: Element>(py: Python<'_>, values: Vec<T>) -> Bound<'_, PyArray1<T>> {
    values.into_pyarray(py)
}

/// Moves row-major values into an array.
pub(crate) fn array<T: Element, const N: usize>(
    py: Python<'_>,
    shape: [usize; N],
    values: Vec<T>,
) -> PyResult<Bound<'_, PyArray<T, Dim<[usize; N]>>>>
where
    [usize; N]: IntoDimension<Dim = Dim<[usize; N]>>,
    Dim<[usize; N]>: Dimension,
{
    values.into_pyarray(py).reshape(shape)
}

/// Freezes an array that is handed out many times: it cannot be written to.
pub(crate) fn frozen<T: Element, D: Dimension>(
    array: Bound<'_, PyArray<T, D>>,
) -> Py<PyArray<T, D>> {
    // Nobody else has it yet.
    drop(array.readwrite().make_nonwriteable());
    array.unbind()
}
