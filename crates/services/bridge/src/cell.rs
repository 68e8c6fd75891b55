//! The threads of a cell.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::Duration;

use ppnpack_service::Shutdown;
use ppnpack_wire::keys::Cell;

use crate::camera::Camera;
use crate::desk::{self, Desk, Mail, Progress};
use crate::journal::CellJournal;
use crate::robot::Robot;
use crate::runner::{JOBS, Runner};
use crate::streams::Streams;

/// What the threads of a cell work with.
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
    /// Works as the desk until the end is asked for. The robot's thread runs meanwhile, and answers to `mailbox`.
    pub(crate) fn run(mut self, mailbox: SyncSender<Mail>, mail: &Receiver<Mail>) {
        let Some(ledger) = desk::open(&mut self.journal, self.robot.as_mut(), mail) else {
            return;
        };
        let (jobs, jobs_to_do) = sync_channel(JOBS);
        let desk = Desk {
            ledger,
            journal: self.journal,
            objects: self.robot.objects(),
            jobs,
            streams: self.streams,
            shutdown: self.shutdown.clone(),
            cut_off: self.cut_off.clone(),
            progress: Progress::new(self.state_period),
        };
        let runner = Runner {
            robot: self.robot,
            jobs: jobs_to_do,
            desk: mailbox,
            camera: self.camera,
            cloud_period: self.cloud_period,
            cut_off: self.cut_off,
        };
        match spawn(format!("robot-{}", self.name), move || runner.run()) {
            Ok(runner) => {
                desk.run(mail);
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

/// A thread with a name.
pub(crate) fn spawn(
    name: String,
    work: impl FnOnce() + Send + 'static,
) -> std::io::Result<JoinHandle<()>> {
    std::thread::Builder::new().name(name).spawn(work)
}
