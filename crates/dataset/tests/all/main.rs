//! Datasets: their files, what is refused, and the expert's labels.
#![cfg(test)]

mod folder;
mod hostile;
mod labels;
mod support;
