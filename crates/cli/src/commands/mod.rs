//! The commands.

pub(crate) mod catalogue;
pub(crate) mod evaluate;
pub(crate) mod experiment;
pub(crate) mod pack;
