//! The actors of a cell.

use std::time::Duration;

use ppnpack_service::Shutdown;
use ppnpack_service::actor::{self, Address, Mailbox};
use ppnpack_service::process::thread;
use ppnpack_wire::keys::Cell;

use crate::camera::Camera;
use crate::desk::{self, Desk, Message, Progress};
use crate::journal::CellJournal;
use crate::robot::Robot;
use crate::runner::{JOBS, Job, Runner};
use crate::streams::Streams;

/// What the actors of a cell work with.
pub(crate) struct CellWorks {
    pub(crate) name: Cell,
    pub(crate) robot: Box<dyn Robot>,
    pub(crate) journal: CellJournal,
    pub(crate) streams: Streams,
    pub(crate) camera: Camera,
    pub(crate) cloud_period: Duration,
    pub(crate) state_period: Duration,
    /// The end of the whole process.
    pub(crate) shutdown: Shutdown,
    /// The end of the service, at once.
    pub(crate) cut_off: Shutdown,
}

impl CellWorks {
    /// Works as the desk until the end is asked for. The robot's actor works meanwhile, and tells it what came of that.
    pub(crate) fn run(mut self, address: Address<Message>, mailbox: &Mailbox<Message>) {
        let Some(ledger) = desk::open(&mut self.journal, self.robot.as_mut(), mailbox) else {
            return;
        };
        let (robot, jobs) = actor::mailbox(JOBS);
        let shown = Job::Show(ledger.head().state_number);
        robot.send(shown).ok();
        let desk = Desk {
            ledger,
            journal: self.journal,
            objects: self.robot.objects(),
            robot,
            streams: self.streams,
            shutdown: self.shutdown.clone(),
            cut_off: self.cut_off.clone(),
            progress: Progress::new(self.state_period),
        };
        let runner = Runner::new(
            self.robot,
            address,
            self.camera,
            self.cloud_period,
            self.cut_off,
        );
        let work = move || runner.run(&jobs);
        match thread(&format!("robot-{}", self.name), work) {
            Ok(runner) => {
                actor::run(desk, mailbox);
                // Without a desk it has no more jobs and ends. A panic of its was told when it happened.
                runner.join().ok();
            }
            Err(error) => {
                tracing::error!(%error, "the robot's thread cannot be started: the process ends");
                self.shutdown.request();
            }
        }
    }
}
