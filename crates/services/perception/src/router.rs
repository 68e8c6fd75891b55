//! Clouds to the threads of their cells, which begin with the first cloud.

use std::collections::BTreeMap;
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use ppnpack_perception::mapper::Mapper;
use ppnpack_service::process::Process;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1;

use crate::counts::{Counts, Fate};
use crate::desk::Mail;
use crate::inspect;
use crate::order::CloudOrder;
use crate::round::Round;
use crate::sensors::Sensors;
use crate::settings::Settings;
use crate::slot::{Inlet, slot};
use crate::worker::Worker;

/// The most cells that one process serves.
const MAX_CELLS: usize = 64;

/// Gives clouds to the threads of their cells.
pub(crate) struct Router {
    process: Process,
    settings: Settings,
    epoch: u64,
    counts: Arc<Counts>,
    /// `None` once it is closed.
    open: Mutex<Option<Open>>,
}

struct Open {
    desk: SyncSender<Mail>,
    inspected: Option<inspect::Inlet>,
    cells: BTreeMap<Cell, Entrance>,
    threads: Vec<JoinHandle<()>>,
}

/// Where the clouds of a cell go.
struct Entrance {
    sensors: Sensors,
    inlet: Inlet,
}

impl Router {
    pub(crate) fn new(
        process: &Process,
        settings: &Settings,
        desk: SyncSender<Mail>,
        inspected: Option<inspect::Inlet>,
        counts: Arc<Counts>,
    ) -> Self {
        Self {
            process: process.clone(),
            settings: settings.clone(),
            epoch: rand::random(),
            counts,
            open: Mutex::new(Some(Open {
                desk,
                inspected,
                cells: BTreeMap::new(),
                threads: Vec::new(),
            })),
        }
    }

    /// Takes a cloud. Runs on Zenoh's thread, and waits for nothing but a lock that is held as briefly.
    pub(crate) fn route(&self, cell: &Cell, cloud: v1::PointCloud) {
        let mut guard = self.lock();
        let Some(open) = guard.as_mut() else {
            return;
        };
        if !open.cells.contains_key(cell) {
            match self.begin(open, cell) {
                Ok(entrance) => drop(open.cells.insert(cell.clone(), entrance)),
                Err(reason) => return self.counts.refuse(cell, Fate::Unserved, &reason),
            }
        }
        let Some(entrance) = open.cells.get(cell) else {
            return;
        };
        let Some(sensor) = entrance.sensors.index_of(&cloud.sensor) else {
            let reason = format!("the cell has no sensor {:?}", cloud.sensor);
            return self.counts.refuse(cell, Fate::Unserved, &reason);
        };
        if entrance.inlet.put(sensor, cloud) {
            self.counts.count(Fate::Replaced);
        }
    }

    /// Which sensors of a cell sent nothing for a while, for people.
    pub(crate) fn silence(&self, cell: &Cell) -> Option<String> {
        let patience = self.settings.sensor_restart_after();
        let guard = self.lock();
        match guard.as_ref()?.cells.get(cell) {
            Some(entrance) => entrance.sensors.silence(&entrance.inlet.last(), patience),
            None => {
                let sensors = self.settings.sensors_of(cell);
                sensors.silence(&vec![None; sensors.count()], patience)
            }
        }
    }

    /// Lets the threads end; gives them, to wait for.
    pub(crate) fn close(&self) -> Vec<JoinHandle<()>> {
        let open = self.lock().take();
        open.map(|open| open.threads).unwrap_or_default()
    }

    /// Begins the thread of a cell.
    fn begin(&self, open: &mut Open, cell: &Cell) -> Result<Entrance, String> {
        if open.cells.len() >= MAX_CELLS {
            return Err(format!("{MAX_CELLS} cells are served already"));
        }
        let settings = self
            .settings
            .grid_of(cell)
            .ok_or("it is not among the cells served")?;
        let grid = settings.build().map_err(|error| error.to_string())?;
        let mapper = Mapper::new(&grid, self.settings.mapper.clone());
        let mapper = mapper.map_err(|error| error.to_string())?;
        let sensors = self.settings.sensors_of(cell);
        let (inlet, outlet) = slot(sensors.count());
        let order = CloudOrder::new(self.settings.sensor_restart_after());
        let worker = Worker {
            cell: cell.clone(),
            mapper,
            orders: vec![order; sensors.count()],
            round: Round::new(sensors.count()),
            state_number: 0,
            epoch: self.epoch,
            sequence: 0,
            desk: open.desk.clone(),
            inspected: open.inspected.clone(),
            counts: Arc::clone(&self.counts),
        };
        let process = self.process.clone();
        let has_debug_streams = self.settings.debug_streams;
        let thread = std::thread::Builder::new()
            .name(format!("perception-{cell}"))
            .spawn(move || worker.run(&process, has_debug_streams, &outlet))
            .map_err(|error| error.to_string())?;
        open.threads.push(thread);
        Ok(Entrance { sensors, inlet })
    }

    fn lock(&self) -> MutexGuard<'_, Option<Open>> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
