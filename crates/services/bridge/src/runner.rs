//! The thread of a robot: does one job after another, and looks at the container between them.

use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender};
use std::time::{Duration, Instant};

use ppnpack_service::Shutdown;

use crate::camera::Camera;
use crate::desk::Mail;
use crate::robot::{CutOff, Placement, Robot};

/// Jobs that wait at most: a desk gives the next one when it has heard of the last.
pub(crate) const JOBS: usize = 4;

/// What a robot is told.
pub(crate) enum Job {
    /// Place an item.
    Place(Placement),
    /// Bring an empty container.
    Renew,
    /// The content of the container is written down as this state: it may be shown.
    Show(u64),
}

/// The thread of a robot.
pub(crate) struct Runner {
    pub(crate) robot: Box<dyn Robot>,
    pub(crate) jobs: Receiver<Job>,
    pub(crate) desk: SyncSender<Mail>,
    pub(crate) camera: Camera,
    pub(crate) cloud_period: Duration,
    pub(crate) cut_off: Shutdown,
}

impl Runner {
    /// Works until the desk is gone.
    pub(crate) fn run(mut self) {
        let _gone = SaysThatItIsGone(self.desk.clone());
        // Until a change is written down, nothing is shown of it.
        let mut shown: Option<u64> = None;
        let mut next_cloud = Instant::now();
        loop {
            let job = match shown {
                Some(_) => {
                    let pause = next_cloud.saturating_duration_since(Instant::now());
                    self.jobs.recv_timeout(pause)
                }
                None => self.jobs.recv().map_err(RecvTimeoutError::from),
            };
            match job {
                Ok(Job::Show(state_number)) => shown = Some(state_number),
                Ok(Job::Place(placement)) => {
                    shown = None;
                    self.place(&placement);
                }
                Ok(Job::Renew) => {
                    shown = None;
                    self.renew();
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
            if let Some(state_number) = shown {
                self.camera.show(self.robot.as_mut(), state_number);
                next_cloud = Instant::now() + self.cloud_period;
            }
        }
    }

    fn place(&mut self, placement: &Placement) {
        let mail = match self.robot.place(placement, &self.cut_off) {
            Ok(finding) => Mail::Placed(finding, self.robot.bodies()),
            Err(CutOff) => Mail::CutOff,
        };
        self.tell(mail);
    }

    fn renew(&mut self) {
        let result = self.robot.renew();
        self.tell(Mail::Renewed(result, self.robot.bodies()));
    }

    /// A desk that is gone needs to be told nothing.
    fn tell(&self, mail: Mail) {
        self.desk.send(mail).ok();
    }
}

/// Tells the desk where the robot's thread ends by a panic.
struct SaysThatItIsGone(SyncSender<Mail>);

impl Drop for SaysThatItIsGone {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.send(Mail::RobotIsGone).ok();
        }
    }
}
