//! Datasets: their files, what is refused, and the expert's labels.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    missing_docs,
    reason = "a panic in a test is a failing test"
)]

mod folder;
mod hostile;
mod labels;
mod support;
