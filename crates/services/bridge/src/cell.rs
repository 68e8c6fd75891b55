//! The actors of a cell.

use ppnpack_service::Shutdown;
use ppnpack_service::actor::{self, Address, Mailbox};
use ppnpack_service::supervision::Supervisor;
use ppnpack_wire::keys::Cell;

use crate::camera::Camera;
use crate::desk::{self, Desk, DeskRobot, Early, Message, Reach, Share, TimeLimits};
use crate::journal::CellJournal;
use crate::robot::Robot;
use crate::runner::{Jobs, Runner};
use crate::streams::Streams;

/// The parts that the actors of a cell work with.
pub(crate) struct CellParts {
    pub(crate) name: Cell,
    pub(crate) robot: Box<dyn Robot>,
    pub(crate) camera: Camera,
    /// The address at which the robot's actor reports.
    pub(crate) desk: Address<Message>,
    pub(crate) journal: CellJournal,
    pub(crate) streams: Streams,
    pub(crate) supervisor: Supervisor,
    /// The end of the service, at once.
    pub(crate) cut_off: Shutdown,
    /// Whether another bridge served the cell before this one did.
    pub(crate) is_after_another: bool,
    pub(crate) limits: TimeLimits,
    /// Its share of the robot.
    pub(crate) share: Share,
}

impl CellParts {
    /// Works as the desk until the end is asked for, with the robot's actor in a thread beside it.
    pub(crate) fn run(mut self, mailbox: &Mailbox<Message>) {
        let is_simulated = self.robot.is_simulated();
        let early = Early {
            mailbox,
            share: &self.share,
        };
        let Some(ledger) = desk::open(
            &mut self.journal,
            is_simulated,
            &early,
            self.is_after_another,
        ) else {
            return;
        };
        let reach = Reach::of(self.robot.as_ref());
        let (actor, robot_mailbox) = actor::mailbox(1);
        let jobs = Jobs::new(&actor);
        let (supervisor, desk) = (&self.supervisor, self.desk);
        let runner = Runner::new(self.robot, desk, jobs.clone(), self.camera, supervisor);
        let desk = Desk::new(
            ledger,
            self.journal,
            DeskRobot {
                _actor: actor,
                jobs,
                reach,
                share: self.share,
            },
            self.streams,
            self.cut_off,
            self.limits,
        );
        let work = move || runner.run(&robot_mailbox);
        let name = format!("robot-{}", self.name);
        match self.supervisor.thread(&name, work) {
            Ok(runner) => {
                let name = format!("bridge-{}", self.name);
                actor::run_watched(&self.supervisor, &name, desk, mailbox);
                // Without a desk it ends. A panic of its was told when it happened.
                runner.join().ok();
            }
            Err(error) => self.supervisor.give_up(error.to_string()),
        }
    }
}
