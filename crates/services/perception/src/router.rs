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
use crate::order::CloudOrder;
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
    cells: BTreeMap<Cell, Inlet>,
    threads: Vec<JoinHandle<()>>,
}

impl Router {
    pub(crate) fn new(
        process: &Process,
        settings: &Settings,
        desk: SyncSender<Mail>,
        counts: Arc<Counts>,
    ) -> Self {
        Self {
            process: process.clone(),
            settings: settings.clone(),
            epoch: rand::random(),
            counts,
            open: Mutex::new(Some(Open {
                desk,
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
                Ok(inlet) => drop(open.cells.insert(cell.clone(), inlet)),
                Err(reason) => return self.counts.refuse(cell, Fate::Unserved, &reason),
            }
        }
        if let Some(inlet) = open.cells.get(cell)
            && inlet.put(cloud)
        {
            self.counts.count(Fate::Replaced);
        }
    }

    /// Lets the threads end; gives them, to wait for.
    pub(crate) fn close(&self) -> Vec<JoinHandle<()>> {
        let open = self.lock().take();
        open.map(|open| open.threads).unwrap_or_default()
    }

    /// Begins the thread of a cell.
    fn begin(&self, open: &mut Open, cell: &Cell) -> Result<Inlet, String> {
        if open.cells.len() >= MAX_CELLS {
            return Err(format!("{MAX_CELLS} cells are served already"));
        }
        let settings = self
            .settings
            .grid_of(cell)
            .ok_or("it is not among the cells served")?;
        let grid = settings.grid().map_err(|error| error.to_string())?;
        let mapper = Mapper::new(&grid, self.settings.mapper.clone());
        let mapper = mapper.map_err(|error| error.to_string())?;
        let (inlet, outlet) = slot();
        let worker = Worker {
            cell: cell.clone(),
            mapper,
            order: CloudOrder::new(self.settings.sensor_restart_after()),
            epoch: self.epoch,
            sequence: 0,
            desk: open.desk.clone(),
            counts: Arc::clone(&self.counts),
        };
        let process = self.process.clone();
        let has_debug_streams = self.settings.debug_streams;
        let thread = std::thread::Builder::new()
            .name(format!("perception-{cell}"))
            .spawn(move || worker.run(&process, has_debug_streams, &outlet))
            .map_err(|error| error.to_string())?;
        open.threads.push(thread);
        Ok(inlet)
    }

    fn lock(&self) -> MutexGuard<'_, Option<Open>> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
