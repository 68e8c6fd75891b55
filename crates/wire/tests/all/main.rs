//! The wire, held against its schemas, against hostile bytes and against what was recorded of it.
#![cfg(test)]

mod convert;
mod decode;
mod generated;
mod golden;
mod hostile;
mod item_store;
#[path = "../support/payload.rs"]
mod payload;
mod ros;
mod ros_layouts;
mod rpc;
mod schema;
mod support;
