//! Actors: threads that own their state, and change it by one message after another.
//!
//! Others know an actor by the [`Address`] of its [`Mailbox`], which has a bound: messages beyond
//! it are refused, so that Zenoh's threads never wait. Requests that cannot be answered yet are
//! [`PendingRequests`], each with a deadline; data of which only the newest counts are
//! [`LatestValues`]. [`run`] calls the actor for each message, and whenever it is due. It ends when
//! nobody has its address any more.
//!
//! ```
//! use std::time::{Duration, Instant};
//!
//! use ppnpack_service::actor::{self, Actor, LatestValues};
//!
//! /// Sums up what a sensor measured, and reports once a second.
//! struct Sum {
//!     measured: LatestValues<&'static str, u32>,
//!     sum: u32,
//!     next_report: Instant,
//! }
//!
//! impl Actor for Sum {
//!     /// To be added.
//!     type Message = u32;
//!
//!     fn handle(&mut self, addend: u32) {
//!         self.sum += addend;
//!     }
//!
//!     fn tick(&mut self) {
//!         self.sum += self.measured.take().values().sum::<u32>();
//!         if Instant::now() >= self.next_report {
//!             println!("{}", self.sum);
//!             self.next_report += Duration::from_secs(1);
//!         }
//!     }
//!
//!     fn next_tick(&self) -> Option<Instant> {
//!         Some(self.next_report)
//!     }
//! }
//!
//! # fn main() -> Result<(), ppnpack_service::ServiceError> {
//! # let hub = ppnpack_service::embedded::hub()?;
//! # let service = ppnpack_wire::keys::Service::Planner;
//! # let process = ppnpack_service::embedded::process(&hub, service, "sum")?;
//! let (address, mailbox) = actor::mailbox(16);
//! let measured = LatestValues::new(&address);
//! let sum = Sum {
//!     measured: measured.clone(),
//!     sum: 0,
//!     next_report: Instant::now(),
//! };
//! let thread = actor::spawn(&process, "sum", sum, mailbox)?;
//! assert!(address.send(1).is_ok());
//! measured.put("scales", 2);
//! // Without an address nothing more can come, and the actor ends.
//! drop(address);
//! assert!(thread.join().is_ok());
//! # Ok(())
//! # }
//! ```

mod latest;
mod mailbox;
mod pending;

use std::thread::JoinHandle;
use std::time::Instant;

pub use latest::LatestValues;
pub use mailbox::{Address, Closed, Mailbox, WeakAddress, mailbox};
pub use pending::PendingRequests;

use crate::error::ServiceError;
use crate::process::Process;
use crate::supervision::{Pulse, Supervisor};

/// An actor's work.
pub trait Actor {
    /// A message to it.
    type Message;

    /// Handles a message.
    fn handle(&mut self, message: Self::Message);

    /// Does all that is due: at first, after each message, when it was woken, and when
    /// [`Actor::next_tick`] has come.
    fn tick(&mut self) {}

    /// Gives the time at which something is due, message or not; `None` where nothing is.
    fn next_tick(&self) -> Option<Instant> {
        None
    }

    /// Says whether it ends now, although more messages could come.
    fn has_ended(&self) -> bool {
        false
    }
}

/// Works as an actor until it ends, or nobody has its address any more.
pub fn run<A: Actor>(actor: A, mailbox: &Mailbox<A::Message>) {
    work(actor, mailbox, None);
}

/// Works as [`run`] does, as an actor that the process cannot do without: one that hangs ends it.
pub fn run_watched<A: Actor>(
    supervisor: &Supervisor,
    name: &str,
    actor: A,
    mailbox: &Mailbox<A::Message>,
) {
    let pulse = supervisor.pulse(name);
    work(actor, mailbox, Some(&pulse));
}

/// Works as an actor; the pulse tells while it does not wait.
fn work<A: Actor>(mut actor: A, mailbox: &Mailbox<A::Message>, pulse: Option<&Pulse>) {
    loop {
        pulse.inspect(|pulse| pulse.begin());
        actor.tick();
        if actor.has_ended() {
            return;
        }
        pulse.inspect(|pulse| pulse.rest());
        let received = mailbox.receive(actor.next_tick());
        pulse.inspect(|pulse| pulse.begin());
        match received {
            Ok(Some(message)) => actor.handle(message),
            Ok(None) => {}
            Err(Closed) => return,
        }
    }
}

/// Starts the thread of an actor that the process cannot do without: one that panics or hangs ends
/// it.
///
/// # Errors
/// [`ServiceError::System`] where there can be no more threads.
pub fn spawn<A>(
    process: &Process,
    name: &str,
    actor: A,
    mailbox: Mailbox<A::Message>,
) -> Result<JoinHandle<()>, ServiceError>
where
    A: Actor + Send + 'static,
    A::Message: Send + 'static,
{
    let (supervisor, own) = (process.supervisor().clone(), name.to_owned());
    process.supervisor().thread(name, move || {
        run_watched(&supervisor, &own, actor, &mailbox);
    })
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    /// Counts how often it is due, until it was three times.
    struct Clock {
        ticks: u32,
        told: std::sync::mpsc::Sender<u32>,
    }

    impl Actor for Clock {
        type Message = ();

        fn handle(&mut self, (): ()) {}

        fn tick(&mut self) {
            self.ticks += 1;
            self.told.send(self.ticks).unwrap();
        }

        fn next_tick(&self) -> Option<Instant> {
            Some(Instant::now() + Duration::from_millis(1))
        }

        fn has_ended(&self) -> bool {
            self.ticks == 3
        }
    }

    #[test]
    fn an_actor_is_called_when_it_is_due_and_ends_when_it_wants() {
        let (address, mailbox) = mailbox(1);
        let (told, ticks) = std::sync::mpsc::channel();
        let clock = Clock { ticks: 0, told };
        let work = move || run(clock, &mailbox);
        std::thread::spawn(work).join().unwrap();
        assert_eq!(ticks.iter().collect::<Vec<_>>(), [1, 2, 3]);
        assert_eq!(address.send(()), Err(Closed));
    }
}
