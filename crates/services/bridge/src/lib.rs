//! The bridge service: a cell, its robot and its sensor behind one interface.
//!
//! It accepts placements, has each carried out at most once, and says how it ended; it brings empty
//! containers; it publishes the sensors' clouds. The cells are simulated or have robots that are
//! programs of their own ([`start`]), or anything that implements [`Robot`] ([`start_robots`]).
//!
//! Each cell has two actors. The desk answers requests and keeps the journal; the robot's actor is
//! busy for as long as a placement takes.

mod camera;
mod cell;
mod clock;
mod desk;
mod journal;
mod remote;
pub mod robot;
mod runner;
mod settings;
pub mod simulated;
mod streams;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_service::actor::{self, Address};
use ppnpack_service::lease::{self, Lease};
use ppnpack_service::process::Process;
use ppnpack_service::rpc::Listener;
use ppnpack_service::{HealthLatch, Running, ServiceError, Shutdown};
use ppnpack_wire::keys::Cell;

use camera::Camera;
use cell::CellParts;
use desk::{Message, Share, SharedRobot, TimeLimits};
use journal::{CellJournal, Journal};
use remote::RemoteRobot;
pub use remote::RemoteSettings;
use robot::Robot;
pub use settings::Settings;
use simulated::SimulatedRobot;
use streams::Streams;

/// Compiles the example of the guide.
#[cfg(doctest)]
#[doc = include_str!("../../../../docs/guides/real-robot.md")]
struct RealRobot;

/// The maximum time for a robot to stop when it is cut off.
const CUT_OFF_PATIENCE: Duration = Duration::from_secs(1);

/// The running service. Dropped, it ends at once, and cuts off a placement where that is possible.
pub struct Bridge {
    // Requests stop coming before the desks end: fields are dropped in this order.
    inputs: Vec<(Lease, [Listener; 7])>,
    desks: Vec<Address<Message>>,
    threads: Vec<JoinHandle<()>>,
    cut_off: Shutdown,
    /// The journal's health check, which fails once it is dropped.
    _health: HealthLatch,
}

/// Starts the service with simulated cells, and robots that are programs of their own.
///
/// # Errors
/// [`ServiceError`] where a cell cannot be simulated, or there is no session or no thread. Where
/// another bridge serves a cell, this waits for the end of that. A journal that cannot be used is
/// no error: requests are refused until it can, and the health check `journal` says why.
pub fn start(
    process: &Process,
    settings: &Settings,
    catalogue: &Catalogue,
) -> Result<Bridge, ServiceError> {
    let mut robots: BTreeMap<Cell, Box<dyn Robot>> = BTreeMap::new();
    for (name, cell_settings) in &settings.cells {
        let cell = Cell::new(name)?;
        let robot: Box<dyn Robot> = match cell_settings.remote {
            Some(remote) => {
                let container = cell_settings.physics.container;
                Box::new(RemoteRobot::new(process, &cell, container, remote))
            }
            None => {
                let robot = SimulatedRobot::new(cell_settings.clone(), catalogue);
                let robot = robot
                    .map_err(|error| ServiceError::start(format_args!("cell {cell}: {error}")))?;
                Box::new(robot)
            }
        };
        robots.insert(cell, robot);
    }
    start_robots(process, settings, robots)
}

/// Starts the service with these robots in place of the settings' simulated cells.
///
/// # Errors
/// As [`start`].
pub fn start_robots(
    process: &Process,
    settings: &Settings,
    mut robots: BTreeMap<Cell, Box<dyn Robot>>,
) -> Result<Bridge, ServiceError> {
    let health = process.health().check("journal");
    let journal = match &settings.journal {
        Some(path) => Some(Arc::new(Journal::new(path, health.clone()))),
        None => {
            health.pass();
            None
        }
    };
    let mut bridge = Bridge {
        inputs: Vec::new(),
        desks: Vec::new(),
        threads: Vec::new(),
        cut_off: Shutdown::default(),
        _health: health,
    };
    let mut shared = shared_robots(settings);
    let cells: Vec<Option<Cell>> = robots.keys().cloned().map(Some).collect();
    lease::take_each(process, cells, |cell, lease| {
        let own = cell.and_then(|cell| Some((cell, robots.remove(cell)?)));
        own.map_or(Ok(()), |(cell, robot)| {
            let journal = CellJournal::new(journal.clone(), cell.clone());
            let own = shared.remove(cell.as_str()).unwrap_or_default();
            bridge.add(process, settings, journal, (cell, lease), (robot, own))
        })
    })?;
    match shared.keys().next() {
        Some(unknown) => Err(ServiceError::start(format_args!(
            "robots: there is no cell {unknown}: name those that this bridge serves"
        ))),
        None => Ok(bridge),
    }
}

/// The robots of the cells that share theirs with others.
fn shared_robots(settings: &Settings) -> BTreeMap<&str, SharedRobot> {
    let robots = settings.robots.values().flat_map(|cells| {
        let robot = SharedRobot::of(cells);
        let cells = cells.iter();
        cells.map(move |cell| (cell.as_str(), robot.clone()))
    });
    robots.collect()
}

impl Bridge {
    /// Starts the actors of a cell, and has them take requests.
    fn add(
        &mut self,
        process: &Process,
        settings: &Settings,
        journal: CellJournal,
        (cell, lease): (&Cell, Lease),
        (robot, shared): (Box<dyn Robot>, SharedRobot),
    ) -> Result<(), ServiceError> {
        let (address, mailbox) = actor::mailbox(settings.queue.max(1));
        let camera = Camera::new(process, cell, settings)?;
        let parts = CellParts {
            streams: Streams::new(process, cell, robot.as_ref(), settings)?,
            name: cell.clone(),
            robot,
            camera,
            desk: address.clone(),
            journal,
            supervisor: process.supervisor().clone(),
            cut_off: self.cut_off.clone(),
            is_after_another: lease.is_after_another,
            limits: TimeLimits::of(settings),
            share: Share::new(shared, cell, &address),
        };
        let listeners = [
            address.listen(process, Some(cell), Message::Place)?,
            address.listen(process, Some(cell), Message::Outcome)?,
            address.listen(process, Some(cell), Message::Renew)?,
            address.listen_past_others(process, Some(cell), Message::Hold)?,
            address.listen(process, Some(cell), Message::Resume)?,
            address.listen(process, Some(cell), Message::Changed)?,
            address.listen(process, Some(cell), Message::State)?,
        ];
        self.inputs.push((lease, listeners));
        let work = move || parts.run(&mailbox);
        let thread = process
            .supervisor()
            .thread(&format!("bridge-{cell}"), work)?;
        self.threads.push(thread);
        self.desks.push(address);
        Ok(())
    }

    /// Takes no more requests, asks the desks to end and waits for that.
    fn end(&mut self, deadline: Instant) -> Result<(), String> {
        self.inputs.clear();
        for desk in self.desks.drain(..) {
            // A desk that is gone has ended.
            desk.send(Message::End).ok();
        }
        ppnpack_service::join(std::mem::take(&mut self.threads), deadline)
    }
}

impl Running for Bridge {
    fn finish(mut self: Box<Self>, deadline: Instant) -> Result<(), String> {
        // A placement that is left at the deadline is cut off when this is dropped.
        self.end(deadline)
    }
}

impl Drop for Bridge {
    fn drop(&mut self) {
        self.cut_off.request();
        // A placement that the robot cannot break off ends by itself, later.
        self.end(Instant::now() + CUT_OFF_PATIENCE).ok();
    }
}
