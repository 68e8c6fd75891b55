//! Clouds to the actors of their cells.

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use ppnpack_service::actor::{self, Address, LatestValues, Mailbox};
use ppnpack_service::stream::Arrived;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1;

use crate::counts::{Counts, Fate};
use crate::room::{Budget, Held, Room};
use crate::sensors::Sensors;
use crate::settings::Settings;

/// The most cells that one process serves, those that are listed among them.
pub(crate) const MAX_CELLS: usize = 64;

/// The latest clouds of a cell, by the indices of their sensors.
pub(crate) type Clouds = LatestValues<usize, Arrived<Held<v1::PointCloud>>>;

/// The first cloud of a cell has come: its actor is to begin.
pub(crate) struct Begin {
    pub(crate) cell: Cell,
    pub(crate) clouds: Clouds,
    /// Its actor is told nothing but that there are clouds.
    pub(crate) mailbox: Mailbox<Infallible>,
}

/// Gives clouds to the actors of their cells.
pub(crate) struct Router {
    settings: Settings,
    counts: Arc<Counts>,
    budget: Budget,
    /// `None` once it is closed.
    open: Mutex<Option<Open>>,
}

struct Open {
    /// Begins the actors of cells.
    cells: Address<Begin>,
    routes: BTreeMap<Cell, Route>,
}

/// Where the clouds of a cell go.
struct Route {
    sensors: Sensors,
    clouds: Clouds,
    /// Keeps the cell's actor from ending.
    _actor: Address<Infallible>,
}

impl Router {
    /// `cells` begins the actors of cells; its mailbox has room for [`MAX_CELLS`].
    pub(crate) fn new(settings: &Settings, cells: Address<Begin>, counts: Arc<Counts>) -> Self {
        Self {
            settings: settings.clone(),
            counts,
            budget: Budget::new(settings.clouds_mib << 20),
            open: Mutex::new(Some(Open {
                cells,
                routes: BTreeMap::new(),
            })),
        }
    }

    /// Room for a cloud of so many bytes, before memory is taken for it; one that has none is counted as dropped.
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

    /// Takes a cloud. Runs on Zenoh's thread: it only puts the cloud where the cell's actor finds it, and waits for
    /// nothing but a lock that is held as briefly.
    pub(crate) fn route(&self, cell: &Cell, cloud: Held<v1::PointCloud>) {
        if !cloud.cell.is_empty() && cloud.cell != cell.as_str() {
            let reason = format!("it is of cell {}, and came as one of another", cloud.cell);
            return self.counts.refuse(cell, Fate::Unserved, &reason);
        }
        let mut guard = self.lock();
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

    /// Refuses the clouds of a cell whose actor could not begin, and forgets it: its next cloud begins anew.
    pub(crate) fn give_up(&self, cell: &Cell, reason: &dyn std::fmt::Display) {
        let mut guard = self.lock();
        let route = guard.as_mut().and_then(|open| open.routes.remove(cell));
        drop(guard);
        for _ in route.iter().flat_map(|route| route.clouds.take()) {
            self.counts.refuse(cell, Fate::Unserved, reason);
        }
    }

    /// Which sensors of a cell sent nothing for a while, for people.
    pub(crate) fn silence(&self, cell: &Cell) -> Option<String> {
        let patience = self.settings.sensor_restart_after();
        let sensors = self.settings.sensors_of(cell);
        let guard = self.lock();
        let route = guard.as_ref()?.routes.get(cell);
        let last_of = |sensor| route?.clouds.last_put(&sensor);
        let last: Vec<Option<Instant>> = (0..sensors.count()).map(last_of).collect();
        sensors.silence(&last, patience)
    }

    /// Lets the actors of cells end.
    pub(crate) fn close(&self) {
        drop(self.lock().take());
    }

    /// Has the actor of a cell begin. What takes time is left to it.
    fn begin(&self, open: &Open, cell: &Cell) -> Result<Route, String> {
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
        let begin = Begin {
            cell: cell.clone(),
            clouds: clouds.clone(),
            mailbox,
        };
        if !open.cells.try_send(begin) {
            return Err("the service is ending".to_owned());
        }
        Ok(Route {
            sensors: self.settings.sensors_of(cell),
            clouds,
            _actor: actor,
        })
    }

    fn lock(&self) -> MutexGuard<'_, Option<Open>> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn route(router: &Router, cell: &Cell) {
        let room = router.room(cell, 100).unwrap();
        router.route(cell, room.with(v1::PointCloud::default()));
    }

    #[test]
    fn a_sensor_of_many_cells_leaves_those_that_are_listed_their_room() {
        let counts = Arc::new(Counts::new());
        let (address, mailbox) = actor::mailbox(MAX_CELLS);
        let mut settings = Settings::default();
        settings.cells.insert("listed".to_owned(), settings.grid);
        let router = Router::new(&settings, address, Arc::clone(&counts));
        for number in 0..MAX_CELLS {
            let cell = Cell::new(&format!("c{number}")).unwrap();
            route(&router, &cell);
        }
        assert_eq!(counts.of(Fate::Unserved), 1);
        route(&router, &Cell::new("listed").unwrap());
        assert_eq!(counts.of(Fate::Unserved), 1);
        assert_eq!(mailbox.take_waiting().count(), MAX_CELLS);
    }

    #[test]
    fn a_cell_whose_actor_could_not_begin_begins_anew_with_its_next_cloud() {
        let counts = Arc::new(Counts::new());
        let (address, mailbox) = actor::mailbox(MAX_CELLS);
        let router = Router::new(&Settings::default(), address, Arc::clone(&counts));
        let cell = Cell::new("c1").unwrap();
        for unserved in 1..=2 {
            route(&router, &cell);
            assert_eq!(mailbox.take_waiting().count(), 1, "its actor is to begin");
            router.give_up(&cell, &"there are no more threads");
            assert_eq!(counts.of(Fate::Unserved), unserved);
        }
        assert_eq!(counts.of(Fate::Replaced), 0);
    }
}
