//! The run of one process of ppnpack, whatever service it is.
//!
//! A thin binary calls [`main`] with the function that starts its service:
//!
//! ```no_run
//! use std::process::ExitCode;
//! use std::time::Instant;
//!
//! use ppnpack_service::{Process, Running, ServiceSettings};
//! use ppnpack_wire::keys::Service;
//! use serde::{Deserialize, Serialize};
//!
//! #[derive(Default, Serialize, Deserialize)]
//! #[serde(default, deny_unknown_fields)]
//! struct Settings {
//!     threads: usize,
//! }
//!
//! impl ServiceSettings for Settings {
//!     fn validate(&self) -> Result<(), String> {
//!         Ok(())
//!     }
//! }
//!
//! struct Started;
//!
//! impl Running for Started {
//!     fn finish(self: Box<Self>, _deadline: Instant) -> Result<(), String> {
//!         Ok(())
//!     }
//! }
//!
//! fn start(_process: &Process, _settings: Settings) -> anyhow::Result<Box<dyn Running>> {
//!     Ok(Box::new(Started))
//! }
//!
//! fn main() -> ExitCode {
//!     ppnpack_service::main(Service::Planner, start)
//! }
//! ```
//!
//! The process reads its configuration ([`configuration`]), writes logs, opens the admin port, then
//! the Zenoh session, starts the service, waits for SIGTERM or SIGINT, and finishes within a grace.
//! A service uses [`Process`] and:
//!
//! - [`actor`]: threads that own their state, and work through bounded mailboxes; [`one_worker`]: a
//!   service of one,
//! - [`rpc`]: answer requests and make them,
//! - [`stream`]: publish data and read it; [`shapes`]: what records of planned steps name,
//! - [`alive`]: say that it is there, and see who else is,
//! - [`lease`]: serve a cell that no other instance serves,
//! - [`health`]: say what it needs, and whether it has it; [`survey`]: what all say,
//! - [`supervision`]: end where a thread is dead,
//! - [`database`]: keep what it knows in a file,
//! - [`clock`]: the time of day, as messages tell it; [`sync`]: locks,
//! - [`metrics`] of what happens, to be counted,
//!
//! [`embedded`] runs several services in one process.
//!
//! Threads: Zenoh's threads only check requests and hand them over to mailboxes with a bound; the
//! service's own threads work and answer. Requests have deadlines, whether they are made or
//! pending. An actor waits without one, for messages, as long as some can come; so does
//! [`actor::Address::send`], for room in the mailbox.

pub mod actor;
mod admin;
pub mod alive;
pub mod clock;
pub mod configuration;
pub mod database;
pub mod embedded;
pub mod error;
pub mod health;
mod http;
pub mod lease;
mod logs;
pub mod metrics;
pub mod one_worker;
mod payload;
pub mod process;
pub mod rpc;
mod run;
mod session;
pub mod shapes;
pub mod shutdown;
pub mod stream;
pub mod supervision;
pub mod survey;
pub mod sync;
mod telemetry;

pub use admin::ask_ready;
pub use configuration::ServiceSettings;
pub use error::ServiceError;
pub use health::{Health, HealthLatch};
pub use one_worker::OneWorker;
pub use process::Process;
pub use run::{Running, join, main};
pub use shutdown::Shutdown;
