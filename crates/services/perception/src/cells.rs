//! The actor that begins the actors of cells.

use std::convert::Infallible;
use std::sync::{Arc, Weak};
use std::thread::JoinHandle;

use ppnpack_service::actor::{self, Actor};
use ppnpack_service::process::Process;
use ppnpack_service::supervision::Supervisor;
use ppnpack_wire::keys::Cell;

use crate::counts::{Counts, Fate};
use crate::router::{Begin, Clouds, Router};
use crate::settings::Settings;
use crate::worker::{Outputs, Worker};

/// Makes the actor of a cell, or says why it cannot be served.
type Build = dyn Fn(&Cell, Clouds) -> Result<Worker, String> + Send + Sync;

/// Begins the actors of cells, and ends when they have ended.
pub(crate) struct Cells {
    /// May take long: each cell's thread calls it for itself.
    build: Arc<Build>,
    /// Told of cells whose actors could not begin. Weak, as it keeps this one from ending.
    router: Weak<Router>,
    counts: Arc<Counts>,
    supervisor: Supervisor,
    threads: Vec<JoinHandle<()>>,
}

impl Actor for Cells {
    type Message = Begin;

    fn handle(&mut self, begin: Begin) {
        let Begin {
            cell,
            clouds,
            mailbox,
        } = begin;
        let (build, counts) = (Arc::clone(&self.build), Arc::clone(&self.counts));
        let (name, of) = (format!("perception-{cell}"), cell.clone());
        let work = move || match build(&cell, clouds.clone()) {
            Ok(worker) => actor::run(worker, &mailbox),
            Err(reason) => {
                let unserved = Unserved {
                    cell,
                    clouds,
                    reason,
                    counts,
                };
                actor::run(unserved, &mailbox);
            }
        };
        match self.supervisor.thread(&name, work) {
            Ok(thread) => self.threads.push(thread),
            Err(error) => {
                if let Some(router) = self.router.upgrade() {
                    router.give_up(&of, &format!("its thread cannot be started: {error}"));
                }
            }
        }
    }
}

impl Drop for Cells {
    fn drop(&mut self) {
        for thread in self.threads.drain(..) {
            // A panic of its was told when it happened.
            thread.join().ok();
        }
    }
}

impl Cells {
    pub(crate) fn new(
        process: &Process,
        settings: &Settings,
        outputs: Outputs,
        router: &Arc<Router>,
    ) -> Self {
        let counts = Arc::clone(&outputs.counts);
        let supervisor = process.supervisor().clone();
        let (process, settings) = (process.clone(), settings.clone());
        let epoch = rand::random();
        let build = move |cell: &Cell, clouds: Clouds| {
            Worker::new(&process, &settings, cell, epoch, clouds, outputs.clone())
        };
        Self::with(Arc::new(build), router, counts, supervisor)
    }

    fn with(
        build: Arc<Build>,
        router: &Arc<Router>,
        counts: Arc<Counts>,
        supervisor: Supervisor,
    ) -> Self {
        Self {
            build,
            router: Arc::downgrade(router),
            counts,
            supervisor,
            threads: Vec::new(),
        }
    }
}

/// In place of the actor of a cell that cannot be served: refuses its clouds.
struct Unserved {
    cell: Cell,
    clouds: Clouds,
    reason: String,
    counts: Arc<Counts>,
}

impl Actor for Unserved {
    type Message = Infallible;

    fn handle(&mut self, message: Infallible) {
        match message {}
    }

    fn tick(&mut self) {
        for _ in self.clouds.take() {
            self.counts.refuse(&self.cell, Fate::Unserved, &self.reason);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{Barrier, Mutex, mpsc};

    use ppnpack_service::Shutdown;
    use ppnpack_wire::v1;

    use super::*;
    use crate::router::MAX_CELLS;

    #[test]
    fn a_new_cells_first_cloud_does_not_hold_up_zenohs_thread() {
        let counts = Arc::new(Counts::new());
        let (release, released) = mpsc::channel::<()>();
        let (released, both_build) = (Mutex::new(released), Arc::new(Barrier::new(3)));
        let build = {
            let both_build = Arc::clone(&both_build);
            move |_: &Cell, _: Clouds| {
                both_build.wait();
                released.lock().unwrap().recv().ok();
                Err("it is slow, and then impossible".to_owned())
            }
        };
        let (address, mailbox) = actor::mailbox(MAX_CELLS);
        let router = Router::new(&Settings::default(), address, Arc::clone(&counts));
        let router = Arc::new(router);
        let supervisor = Supervisor::new(Shutdown::default());
        let cells = Cells::with(Arc::new(build), &router, Arc::clone(&counts), supervisor);
        let thread = std::thread::spawn(move || actor::run(cells, &mailbox));
        let [first, second] = ["c1", "c2"].map(|name| Cell::new(name).unwrap());
        // Nothing is released yet, so these return while the cells are being built: one does not wait for the other.
        let route = |cell: &Cell| {
            let room = router.room(cell, 100).unwrap();
            router.route(cell, room.with(v1::PointCloud::default()));
        };
        route(&first);
        route(&second);
        both_build.wait();
        route(&first);
        assert_eq!(counts.of(Fate::Replaced), 1, "the newer one waits");
        assert_eq!(counts.of(Fate::Unserved), 0);
        drop(release);
        router.close();
        thread.join().unwrap();
        assert_eq!(counts.of(Fate::Unserved), 2);
    }
}
