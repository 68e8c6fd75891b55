//! Requests and their answers.
//!
//! A service declares the methods that it answers with [`listen`]. Each request comes as an
//! [`Incoming`], goes to an actor's mailbox by its [`Address`](crate::actor::Address), and is
//! answered from there. A [`Client`] makes requests. Every request carries an id and a time limit,
//! every answer the id and a status.
//!
//! Zenoh's `get` gives no reply at all where nobody is there, where the other dies, and for a
//! moment after a reconnect. That is no refusal: the client tries again until the deadline. A
//! reader that is slow holds the writer of a request up for at most two seconds; then it is cut
//! off.

mod client;
mod error;
mod incoming;
mod server;
mod trace;

pub use client::Client;
pub use error::{CallError, Refusal};
pub(crate) use incoming::drop_with;
pub use incoming::{Done, Incoming};
pub(crate) use server::answer_health;
pub use server::{Listener, listen};
pub(crate) use trace::TARGET as TRACE_TARGET;
