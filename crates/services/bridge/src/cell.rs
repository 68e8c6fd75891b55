//! The actors of a cell.

use ppnpack_service::Shutdown;
use ppnpack_service::actor::{self, Mailbox};
use ppnpack_service::supervision::Supervisor;
use ppnpack_wire::keys::Cell;

use crate::desk::{self, Desk, DeskRobot, Early, Message, Reach, Share, TimeLimits};
use crate::journal::CellJournal;
use crate::runner::{JOBS, Job, Runner};
use crate::streams::Streams;

/// What the actors of a cell work with.
pub(crate) struct CellWorks {
    pub(crate) name: Cell,
    pub(crate) runner: Runner,
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

impl CellWorks {
    /// Works as the desk until the end is asked for. The robot's actor works meanwhile, and tells it what came of that.
    pub(crate) fn run(mut self, mailbox: &Mailbox<Message>) {
        let robot = self.runner.robot.as_mut();
        let early = Early {
            mailbox,
            share: &self.share,
        };
        let Some(ledger) = desk::open(&mut self.journal, robot, &early, self.is_after_another)
        else {
            return;
        };
        let reach = Reach::of(robot);
        let (robot, jobs) = actor::mailbox(JOBS);
        robot.send(Job::Show(ledger.head().state_number)).ok();
        let desk = Desk::new(
            ledger,
            self.journal,
            DeskRobot {
                jobs: robot,
                reach,
                share: self.share,
            },
            self.streams,
            self.cut_off,
            self.limits,
        );
        let work = move || self.runner.run(&jobs);
        let name = format!("robot-{}", self.name);
        match self.supervisor.thread(&name, work) {
            Ok(runner) => {
                actor::run(desk, mailbox);
                // Without a desk it has no more jobs and ends. A panic of its was told when it happened.
                runner.join().ok();
            }
            Err(error) => self.supervisor.give_up(error.to_string()),
        }
    }
}
