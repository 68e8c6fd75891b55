//! The actor of a robot: does one job after another, and looks at the container between them.

use std::time::Instant;

use ppnpack_service::Shutdown;
use ppnpack_service::actor::{self, Actor, Address, Mailbox};
use ppnpack_service::supervision::Supervisor;

use crate::camera::Camera;
use crate::desk::Message;
use crate::robot::{Body, CutOff, Placement, Robot};

/// Jobs that wait at most: a desk gives the next one when it has heard of the last.
pub(crate) const JOBS: usize = 4;

/// What a robot is told.
pub(crate) enum Job {
    /// Place an item, unless that is broken off.
    Place(Placement, Shutdown),
    /// Bring an empty container.
    Renew,
    /// People changed what lies in the container.
    Changed(Vec<Body>),
    /// The content of the container is written down as this state: it may be shown.
    Show(u64),
}

/// Works as a robot.
pub(crate) struct Runner {
    pub(crate) robot: Box<dyn Robot>,
    desk: Address<Message>,
    camera: Camera,
    supervisor: Supervisor,
    /// The state that is shown. Until a change is written down, nothing is shown of it.
    shown: Option<u64>,
    next_cloud: Instant,
}

impl Actor for Runner {
    type Message = Job;

    fn handle(&mut self, job: Job) {
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
            Job::Changed(bodies) => Message::TakenOver(self.robot.take_over(bodies)),
            Job::Renew => Message::Renewed(self.robot.renew(), self.robot.bodies()),
        };
        // A desk that is gone needs to be told nothing.
        self.desk.send(done).ok();
    }

    fn tick(&mut self) {
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
        camera: Camera,
        supervisor: &Supervisor,
    ) -> Self {
        Self {
            robot,
            desk,
            camera,
            supervisor: supervisor.clone(),
            shown: None,
            next_cloud: Instant::now(),
        }
    }

    /// Works until the desk is gone.
    pub(crate) fn run(self, jobs: &Mailbox<Job>) {
        let _gone = SaysThatItIsGone(self.desk.clone());
        actor::run(self, jobs);
    }

    fn place(&mut self, placement: &Placement, break_off: &Shutdown) -> Message {
        match self.robot.place(placement, break_off) {
            Ok(finding) => Message::Placed(finding, self.robot.bodies()),
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
