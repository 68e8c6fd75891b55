//! Clouds to the actors of their cells.

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Instant;

use ppnpack_service::actor::{self, Actor, Address, LatestValues};
use ppnpack_service::stream::Arrived;
use ppnpack_service::supervision::Supervisor;
use ppnpack_service::sync::lock;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1;

use crate::counts::{Counts, Fate};
use crate::room::{Budget, Held, Room};
use crate::sensors::Sensors;
use crate::settings::Settings;
use crate::worker::Worker;

/// Maximum number of cells that one process serves, those that are listed among them.
pub(crate) const MAX_CELLS: usize = 64;

/// The latest clouds of a cell, by the indices of their sensors.
pub(crate) type Clouds = LatestValues<usize, Arrived<Held<v1::PointCloud>>>;

/// Makes the actor of a cell, or says why it cannot be served. It may take long: each cell's thread
/// calls it for itself.
type Build<A> = dyn Fn(&Cell, Clouds) -> Result<A, String> + Send + Sync;

/// Gives clouds to the actors of their cells.
pub(crate) struct Router<A = Worker> {
    settings: Settings,
    counts: Arc<Counts>,
    supervisor: Supervisor,
    budget: Budget,
    /// `None` once it is closed.
    open: Mutex<Option<Open<A>>>,
}

struct Open<A> {
    build: Arc<Build<A>>,
    routes: BTreeMap<Cell, Route>,
    threads: Vec<JoinHandle<()>>,
}

struct Route {
    sensors: Sensors,
    clouds: Clouds,
    /// Keeps the cell's actor from ending.
    _actor: Address<Infallible>,
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

impl<A: Actor<Message = Infallible> + 'static> Router<A> {
    /// Makes a router. It makes the actors of cells with the first cloud of each, and tells them
    /// nothing but that there are clouds.
    pub(crate) fn new(
        settings: &Settings,
        counts: Arc<Counts>,
        supervisor: &Supervisor,
        build: impl Fn(&Cell, Clouds) -> Result<A, String> + Send + Sync + 'static,
    ) -> Self {
        Self {
            settings: settings.clone(),
            counts,
            supervisor: supervisor.clone(),
            budget: Budget::new(settings.clouds_mib << 20),
            open: Mutex::new(Some(Open {
                build: Arc::new(build),
                routes: BTreeMap::new(),
                threads: Vec::new(),
            })),
        }
    }

    /// Takes room for a cloud of so many bytes, before there is memory for it; one that has none is
    /// counted as dropped.
    pub(crate) fn room(&self, cell: &Cell, bytes: usize) -> Option<Room> {
        let room = self.budget.room(bytes);
        if room.is_none() {
            let reason = format!(
                "a cloud of {bytes} bytes has no room beside those that are held: {} MiB are for all (clouds_mib)",
                self.settings.clouds_mib
            );
            self.counts.refuse(cell, Fate::NoRoom, &reason);
        }
        room
    }

    /// Takes a cloud. Runs on Zenoh's thread: it only puts the cloud where the cell's actor finds
    /// it, and waits for nothing but a lock that is held as briefly.
    pub(crate) fn route(&self, cell: &Cell, cloud: Held<v1::PointCloud>) {
        if !cloud.cell.is_empty() && cloud.cell != cell.as_str() {
            let reason = format!("it is of cell {}, and came as one of another", cloud.cell);
            return self.counts.refuse(cell, Fate::Unserved, &reason);
        }
        let mut guard = lock(&self.open);
        let Some(open) = guard.as_mut() else {
            return;
        };
        if !open.routes.contains_key(cell) {
            match self.begin(open, cell) {
                Ok(route) => drop(open.routes.insert(cell.clone(), route)),
                Err(reason) => return self.counts.refuse(cell, Fate::Unserved, &reason),
            }
        }
        let Some(route) = open.routes.get(cell) else {
            return;
        };
        let Some(sensor) = route.sensors.index_of(&cloud.sensor) else {
            let reason = format!("the cell has no sensor {:?}", cloud.sensor);
            return self.counts.refuse(cell, Fate::Unserved, &reason);
        };
        if route.clouds.put(sensor, Arrived::now(cloud)).is_some() {
            self.counts.count(Fate::Replaced);
        }
    }

    /// Names the sensors of a cell that sent nothing for a while, for people.
    pub(crate) fn silence(&self, cell: &Cell) -> Option<String> {
        let patience = self.settings.sensor_restart_after();
        let sensors = self.settings.sensors_of(cell);
        let guard = lock(&self.open);
        let route = guard.as_ref()?.routes.get(cell);
        let last_of = |sensor| route?.clouds.last_put(&sensor);
        let last: Vec<Option<Instant>> = (0..sensors.count()).map(last_of).collect();
        sensors.silence(&last, patience)
    }

    /// Lets the actors of cells end; gives their threads.
    pub(crate) fn close(&self) -> Vec<JoinHandle<()>> {
        let open = lock(&self.open).take();
        open.map_or_else(Vec::new, |open| open.threads)
    }

    /// Has the actor of a cell begin. What takes time is left to it.
    fn begin(&self, open: &mut Open<A>, cell: &Cell) -> Result<Route, String> {
        if self.settings.grid_of(cell).is_none() {
            return Err("it is not among the cells served".to_owned());
        }
        // Those that are listed always find room, whatever cells a sensor names.
        let is_unlisted = |cell: &Cell| !self.settings.cells.contains_key(cell.as_str());
        let most = MAX_CELLS.saturating_sub(self.settings.cells.len());
        if is_unlisted(cell) && open.routes.keys().filter(|own| is_unlisted(own)).count() >= most {
            return Err(format!(
                "{most} cells that are not listed are served already"
            ));
        }
        let (actor, mailbox) = actor::mailbox(1);
        let clouds = LatestValues::new(&actor);
        let (of, build, own) = (cell.clone(), Arc::clone(&open.build), clouds.clone());
        let counts = Arc::clone(&self.counts);
        let (supervisor, name) = (self.supervisor.clone(), format!("perception-{cell}"));
        let work = move || match build(&of, own.clone()) {
            Ok(worker) => actor::run_watched(&supervisor, &name, worker, &mailbox),
            Err(reason) => {
                let unserved = Unserved {
                    cell: of,
                    clouds: own,
                    reason,
                    counts,
                };
                actor::run(unserved, &mailbox);
            }
        };
        let thread = self.supervisor.thread(&format!("perception-{cell}"), work);
        let failed = |error| format!("its thread cannot be started: {error}");
        open.threads.push(thread.map_err(failed)?);
        Ok(Route {
            sensors: self.settings.sensors_of(cell),
            clouds,
            _actor: actor,
        })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{Barrier, mpsc};

    use ppnpack_service::Shutdown;

    use super::*;

    /// A router whose cells are made by this, which cannot be served then.
    fn router(
        settings: &Settings,
        build: impl Fn(&Cell) + Send + Sync + 'static,
    ) -> (Router<Unserved>, Arc<Counts>) {
        let counts = Arc::new(Counts::new());
        let supervisor = Supervisor::new(Shutdown::default());
        let build = move |cell: &Cell, _: Clouds| {
            build(cell);
            Err("it is impossible".to_owned())
        };
        let router = Router::new(settings, Arc::clone(&counts), &supervisor, build);
        (router, counts)
    }

    fn route(router: &Router<Unserved>, cell: &str) {
        let cell = Cell::new(cell).unwrap();
        let room = router.room(&cell, 100).unwrap();
        router.route(&cell, room.with(v1::PointCloud::default()));
    }

    #[test]
    fn a_sensor_of_many_cells_leaves_those_that_are_listed_their_room() {
        let mut settings = Settings::default();
        settings.cells.insert("listed".to_owned(), settings.grid);
        let (told, begun) = mpsc::channel();
        let told = Mutex::new(told);
        let (router, _) = router(&settings, move |cell| {
            told.lock().unwrap().send(cell.clone()).unwrap();
        });
        for number in 0..MAX_CELLS {
            route(&router, &format!("c{number}"));
        }
        route(&router, "listed");
        let threads = router.close();
        assert_eq!(threads.len(), MAX_CELLS);
        threads
            .into_iter()
            .for_each(|thread| thread.join().unwrap());
        let begun: Vec<Cell> = begun.try_iter().collect();
        assert_eq!(begun.len(), MAX_CELLS);
        assert!(begun.contains(&Cell::new("listed").unwrap()));
    }

    #[test]
    fn a_new_cells_first_cloud_does_not_hold_up_zenohs_thread() {
        let (release, released) = mpsc::channel::<()>();
        let (released, both_build) = (Mutex::new(released), Arc::new(Barrier::new(3)));
        let (router, counts) = router(&Settings::default(), {
            let both_build = Arc::clone(&both_build);
            move |_| {
                both_build.wait();
                released.lock().unwrap().recv().ok();
            }
        });
        // Nothing is released yet, so these return while the cells are being built: one does not
        // wait for the other.
        route(&router, "c1");
        route(&router, "c2");
        both_build.wait();
        route(&router, "c1");
        assert_eq!(counts.of(Fate::Replaced), 1, "the newer one waits");
        assert_eq!(counts.of(Fate::Unserved), 0);
        drop(release);
        for thread in router.close() {
            thread.join().unwrap();
        }
        assert_eq!(counts.of(Fate::Unserved), 2);
    }
}
