//! Sequences that a test packs.

use std::path::{Path, PathBuf};

use ndarray::Array2;

/// A file of so many sequences, each of so many of the first objects of a catalogue.
pub(crate) fn sequences(folder: &Path, [count, length]: [usize; 2], objects: usize) -> PathBuf {
    let path = folder.join("sequences.npy");
    let object = |(row, column)| ((row * length + column) * 7 % objects) as i64;
    ndarray_npy::write_npy(&path, &Array2::from_shape_fn((count, length), object)).unwrap();
    path
}
