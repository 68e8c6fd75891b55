//! The newest clouds of a cell, one a sensor, on their way from Zenoh's thread to the cell's own.

use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use ppnpack_wire::v1;

/// A cloud, whose it is, and when it came.
pub(crate) struct Arrived {
    pub(crate) cloud: v1::PointCloud,
    /// The index of its sensor.
    pub(crate) sensor: usize,
    pub(crate) at: Instant,
}

/// Where clouds are put.
pub(crate) struct Inlet {
    shelf: Arc<Mutex<Shelf>>,
    bell: SyncSender<()>,
}

/// Where the newest are taken.
pub(crate) struct Outlet {
    shelf: Arc<Mutex<Shelf>>,
    bell: Receiver<()>,
}

/// What each sensor sent.
struct Shelf {
    newest: Vec<Option<Arrived>>,
    last: Vec<Option<Instant>>,
}

/// What came to an outlet.
pub(crate) enum Taken {
    /// Clouds, one a sensor at most.
    Clouds(Vec<Arrived>),
    /// None within the time that was given.
    Nothing,
    /// No more can come.
    End,
}

/// A place for one cloud of each of so many sensors.
pub(crate) fn slot(sensors: usize) -> (Inlet, Outlet) {
    let shelf = Arc::new(Mutex::new(Shelf {
        newest: (0..sensors).map(|_| None).collect(),
        last: vec![None; sensors],
    }));
    let (bell, rung) = sync_channel(1);
    let inlet = Inlet {
        shelf: Arc::clone(&shelf),
        bell,
    };
    (inlet, Outlet { shelf, bell: rung })
}

impl Inlet {
    /// Puts a cloud of a sensor; says whether it replaced one that nobody took.
    pub(crate) fn put(&self, sensor: usize, cloud: v1::PointCloud) -> bool {
        let at = Instant::now();
        let mut shelf = lock(&self.shelf);
        if let Some(last) = shelf.last.get_mut(sensor) {
            *last = Some(at);
        }
        let place = shelf.newest.get_mut(sensor);
        let replaced = place.and_then(|place| place.replace(Arrived { cloud, sensor, at }));
        drop(shelf);
        // A bell that is rung already will be heard.
        self.bell.try_send(()).ok();
        replaced.is_some()
    }

    /// When the last cloud of each sensor came.
    pub(crate) fn last(&self) -> Vec<Option<Instant>> {
        lock(&self.shelf).last.clone()
    }
}

impl Outlet {
    /// Waits for clouds.
    pub(crate) fn take(&self, patience: Duration) -> Taken {
        loop {
            match self.bell.recv_timeout(patience) {
                Ok(()) => {}
                Err(RecvTimeoutError::Timeout) => return Taken::Nothing,
                Err(RecvTimeoutError::Disconnected) => return Taken::End,
            }
            let mut shelf = lock(&self.shelf);
            let clouds: Vec<Arrived> = shelf.newest.iter_mut().filter_map(Option::take).collect();
            if !clouds.is_empty() {
                return Taken::Clouds(clouds);
            }
        }
    }
}

fn lock(shelf: &Mutex<Shelf>) -> MutexGuard<'_, Shelf> {
    shelf.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATIENCE: Duration = Duration::from_secs(60);

    fn cloud(sequence: u64) -> v1::PointCloud {
        v1::PointCloud {
            sequence,
            ..v1::PointCloud::default()
        }
    }

    /// The sensors and sequences of the clouds that are there.
    fn taken(outlet: &Outlet) -> Vec<(usize, u64)> {
        match outlet.take(PATIENCE) {
            Taken::Clouds(clouds) => {
                let name = |arrived: &Arrived| (arrived.sensor, arrived.cloud.sequence);
                clouds.iter().map(name).collect()
            }
            Taken::Nothing => panic!("nothing came"),
            Taken::End => Vec::new(),
        }
    }

    #[test]
    fn only_the_newest_of_each_sensor_is_kept() {
        let (inlet, outlet) = slot(2);
        assert!(!inlet.put(0, cloud(1)));
        assert!(inlet.put(0, cloud(2)));
        assert!(!inlet.put(1, cloud(7)));
        assert!(inlet.put(0, cloud(3)));
        assert_eq!(taken(&outlet), [(0, 3), (1, 7)]);
        assert!(!inlet.put(0, cloud(4)));
        assert_eq!(taken(&outlet), [(0, 4)]);
        assert!(inlet.last().iter().all(Option::is_some));
        drop(inlet);
        assert!(taken(&outlet).is_empty());
    }

    #[test]
    fn what_is_put_is_taken_before_the_end() {
        let (inlet, outlet) = slot(1);
        inlet.put(0, cloud(1));
        drop(inlet);
        assert_eq!(taken(&outlet), [(0, 1)]);
        assert!(taken(&outlet).is_empty());
    }

    #[test]
    fn silence_is_told() {
        let (inlet, outlet) = slot(1);
        assert!(matches!(
            outlet.take(Duration::from_millis(1)),
            Taken::Nothing
        ));
        assert_eq!(inlet.last(), [None]);
    }
}
