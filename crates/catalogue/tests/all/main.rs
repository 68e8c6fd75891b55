//! Folders of meshes, and real objects.
#![cfg(test)]

mod folders;
#[path = "../../../packing/tests/golden/cases.rs"]
mod golden;
#[path = "../../../../tests/shared.rs"]
mod shared;
mod shared_data;
