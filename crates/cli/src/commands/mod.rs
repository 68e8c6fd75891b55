//! The commands.

pub(crate) mod calibrate;
pub(crate) mod call;
pub(crate) mod carton;
pub(crate) mod catalogue;
pub(crate) mod inspect;
mod job;
pub(crate) mod pack;
pub(crate) mod perceive;
pub(crate) mod recognise;
pub(crate) mod record;
pub(crate) mod replay;
pub(crate) mod status;
pub(crate) mod up;
pub(crate) mod view;
pub(crate) mod watch;
