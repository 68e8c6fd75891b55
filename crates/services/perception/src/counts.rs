//! Counts of clouds by their fates.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use ppnpack_service::metrics::{self, Metric};
use ppnpack_service::sync::lock;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1;

/// Minimum time between lines about clouds that are refused.
const LINE_PERIOD: Duration = Duration::from_secs(1);

/// The fate of a cloud.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fate {
    /// It became a heightmap.
    Mapped,
    /// A newer one of its sensor came before it was looked at, or before all other sensors showed
    /// the same state.
    Replaced,
    /// Its layout, its pose or one of its fields is not possible.
    Malformed,
    /// It is older than the one before.
    Late,
    /// A sensor with noise sent the points of the one before, to the bit: it stands still.
    Repeated,
    /// Its cell or its sensor is not served.
    Unserved,
    /// No heightmap could be made of it.
    Failed,
    /// The clouds that are held left no room for it.
    NoRoom,
}

/// Fates with their labels in the metric.
const FATES: [(Fate, &str); 8] = [
    (Fate::Mapped, "mapped"),
    (Fate::Replaced, "replaced"),
    (Fate::Malformed, "malformed"),
    (Fate::Late, "late"),
    (Fate::Repeated, "repeated"),
    (Fate::Unserved, "unserved"),
    (Fate::Failed, "failed"),
    (Fate::NoRoom, "no_room"),
];

pub(crate) struct Counts {
    fates: Vec<(Fate, &'static str, AtomicU64, ::metrics::Counter)>,
    last_line: Mutex<Option<Instant>>,
}

impl Counts {
    pub(crate) fn new() -> Self {
        let count = |(fate, label)| {
            let counter = metrics::counter(Metric::CloudsTotal, &[("fate", label)]);
            (fate, label, AtomicU64::new(0), counter)
        };
        Self {
            fates: FATES.map(count).into(),
            last_line: Mutex::new(None),
        }
    }

    /// Counts a cloud; gives the label of its fate.
    pub(crate) fn count(&self, fate: Fate) -> &'static str {
        let own = self.fates.iter().find(|(own, ..)| *own == fate);
        own.map_or("", |(_, label, count, counter)| {
            count.fetch_add(1, Ordering::Relaxed);
            counter.increment(1);
            *label
        })
    }

    /// Counts a cloud that was refused, and says why, not too often.
    pub(crate) fn refuse(&self, cell: &Cell, fate: Fate, reason: &dyn std::fmt::Display) {
        let fate = self.count(fate);
        let now = Instant::now();
        let mut last = lock(&self.last_line);
        if last.is_none_or(|last| now - last >= LINE_PERIOD) {
            *last = Some(now);
            tracing::warn!(%cell, fate, %reason, "cloud refused");
        }
    }

    pub(crate) fn doubt(&self, cell: &Cell, doubts: &[v1::Doubt]) {
        for doubt in doubts {
            let kind = doubt.kind();
            let labels = [("cell", cell.as_str()), ("kind", kind.as_str_name())];
            metrics::counter(Metric::DoubtsTotal, &labels).increment(1);
        }
    }

    pub(crate) fn of(&self, fate: Fate) -> u64 {
        let own = self.fates.iter().find(|(own, ..)| *own == fate);
        own.map_or(0, |(.., count, _)| count.load(Ordering::Relaxed))
    }
}
