//! The newest cloud of a cell, on its way from Zenoh's thread to the cell's own.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use ppnpack_wire::v1;

/// A cloud and when it came.
pub(crate) struct Arrived {
    pub(crate) cloud: v1::PointCloud,
    pub(crate) at: Instant,
}

/// Where clouds are put.
pub(crate) struct Inlet {
    newest: Arc<Mutex<Option<Arrived>>>,
    bell: SyncSender<()>,
}

/// Where the newest is taken.
pub(crate) struct Outlet {
    newest: Arc<Mutex<Option<Arrived>>>,
    bell: Receiver<()>,
}

/// A place for one cloud.
pub(crate) fn slot() -> (Inlet, Outlet) {
    let newest = Arc::new(Mutex::new(None));
    let (bell, rung) = sync_channel(1);
    let inlet = Inlet {
        newest: Arc::clone(&newest),
        bell,
    };
    (inlet, Outlet { newest, bell: rung })
}

impl Inlet {
    /// Puts a cloud; says whether it replaced one that nobody took.
    pub(crate) fn put(&self, cloud: v1::PointCloud) -> bool {
        let arrived = Arrived {
            cloud,
            at: Instant::now(),
        };
        let mut newest = self.newest.lock().unwrap_or_else(PoisonError::into_inner);
        let replaced = newest.replace(arrived);
        drop(newest);
        // A bell that is rung already will be heard.
        self.bell.try_send(()).ok();
        replaced.is_some()
    }
}

impl Outlet {
    /// Waits for a cloud; `None` when the inlet is gone.
    pub(crate) fn take(&self) -> Option<Arrived> {
        loop {
            self.bell.recv().ok()?;
            let mut newest = self.newest.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(arrived) = newest.take() {
                return Some(arrived);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud(sequence: u64) -> v1::PointCloud {
        v1::PointCloud {
            sequence,
            ..v1::PointCloud::default()
        }
    }

    #[test]
    fn only_the_newest_is_kept() {
        let (inlet, outlet) = slot();
        assert!(!inlet.put(cloud(1)));
        assert!(inlet.put(cloud(2)));
        assert!(inlet.put(cloud(3)));
        assert_eq!(outlet.take().unwrap().cloud.sequence, 3);
        assert!(!inlet.put(cloud(4)));
        assert_eq!(outlet.take().unwrap().cloud.sequence, 4);
        drop(inlet);
        assert!(outlet.take().is_none());
    }

    #[test]
    fn what_is_put_is_taken_before_the_end() {
        let (inlet, outlet) = slot();
        inlet.put(cloud(1));
        drop(inlet);
        assert_eq!(outlet.take().unwrap().cloud.sequence, 1);
        assert!(outlet.take().is_none());
    }
}
