//! The commands.

pub(crate) mod catalogue;
pub(crate) mod dataset;
pub(crate) mod evaluate;
pub(crate) mod experiment;
pub(crate) mod pack;
pub(crate) mod train;
