//! The actor of a robot: does one job after another, and looks at the container between them.
//!
//! The desk leaves jobs for the robot and never waits for it, so the desk takes whatever comes. A
//! robot that waits for room in the desk's mailbox cannot deadlock with it.

use std::convert::Infallible;
use std::time::Instant;

use ppnpack_service::Shutdown;
use ppnpack_service::actor::{self, Actor, Address, LatestValues, Mailbox};
use ppnpack_service::supervision::Supervisor;

use crate::camera::Camera;
use crate::desk::{Ended, Message};
use crate::robot::{Body, CutOff, Placement, Robot};

/// The jobs that wait for a robot, one of each kind. A newer one to take over or to show says all
/// that the older one did.
pub(crate) type Jobs = LatestValues<Kind, Job>;

/// Kinds of jobs, in the order in which those that wait are done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    TakeOver,
    Show,
    /// The desk gives the next one when it has heard how the last ended.
    Work,
}

/// A job for a robot.
pub(crate) enum Job {
    /// Place an item, unless that is broken off.
    Place(Placement, Shutdown),
    /// Bring an empty container.
    Renew,
    /// People changed what lies in the container; the number counts their changes.
    Changed(u64, Vec<Body>),
    /// The content of the container is written down as this state: it may be shown.
    Show(u64),
}

impl Job {
    pub(crate) fn kind(&self) -> Kind {
        match self {
            Self::Changed(..) => Kind::TakeOver,
            Self::Show(_) => Kind::Show,
            Self::Place(..) | Self::Renew => Kind::Work,
        }
    }
}

/// Works as a robot.
pub(crate) struct Runner {
    robot: Box<dyn Robot>,
    desk: Address<Message>,
    jobs: Jobs,
    camera: Camera,
    supervisor: Supervisor,
    /// The state that is shown. Until a change is written down, nothing is shown of it.
    shown: Option<u64>,
    next_cloud: Instant,
}

impl Actor for Runner {
    type Message = Infallible;

    fn handle(&mut self, message: Infallible) {
        match message {}
    }

    fn tick(&mut self) {
        for job in self.jobs.take().into_values() {
            self.work(job);
        }
        if let Some(state_number) = self.shown
            && self.next_cloud <= Instant::now()
        {
            self.camera.show(self.robot.as_mut(), state_number);
            self.next_cloud = Instant::now() + self.camera.period;
        }
    }

    fn next_tick(&self) -> Option<Instant> {
        self.shown.map(|_| self.next_cloud)
    }
}

impl Runner {
    pub(crate) fn new(
        robot: Box<dyn Robot>,
        desk: Address<Message>,
        jobs: Jobs,
        camera: Camera,
        supervisor: &Supervisor,
    ) -> Self {
        Self {
            robot,
            desk,
            jobs,
            camera,
            supervisor: supervisor.clone(),
            shown: None,
            next_cloud: Instant::now(),
        }
    }

    /// Works until the desk is gone.
    pub(crate) fn run(self, mailbox: &Mailbox<Infallible>) {
        let _gone = SaysThatItIsGone(self.desk.clone());
        actor::run(self, mailbox);
    }

    fn work(&mut self, job: Job) {
        let _kept = self.supervisor.keep();
        self.shown = None;
        // After a change the next cloud is due at once.
        self.next_cloud = Instant::now();
        let done = match job {
            Job::Show(state_number) => {
                self.shown = Some(state_number);
                return;
            }
            Job::Place(placement, break_off) => self.place(&placement, &break_off),
            Job::Changed(change, bodies) => {
                Message::TakenOver(change, self.robot.take_over(bodies))
            }
            Job::Renew => {
                let renewed = self.robot.renew();
                Message::Ended(Ended::Renewal(renewed, self.robot.bodies()))
            }
        };
        // A desk that is gone needs to be told nothing.
        self.desk.send(done).ok();
    }

    fn place(&mut self, placement: &Placement, break_off: &Shutdown) -> Message {
        match self.robot.place(placement, break_off) {
            Ok(finding) => Message::Ended(Ended::Placement(finding, self.robot.bodies())),
            Err(CutOff) => Message::CutOff,
        }
    }
}

/// Tells the desk where the robot's thread ends by a panic.
struct SaysThatItIsGone(Address<Message>);

impl Drop for SaysThatItIsGone {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.send(Message::RobotIsGone).ok();
        }
    }
}
