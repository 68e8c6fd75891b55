//! What became of clouds, counted.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use ppnpack_service::metrics::{self, Metric};
use ppnpack_service::sync::lock;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1;

/// Lines about clouds that are refused come at most this often.
const LINE_PERIOD: Duration = Duration::from_secs(1);

/// What became of a cloud.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fate {
    /// It became a heightmap.
    Mapped,
    /// A newer one of its sensor came before it was looked at, or before all other sensors showed the same state.
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

impl Fate {
    /// All of them.
    pub const ALL: &[Self] = &[
        Self::Mapped,
        Self::Replaced,
        Self::Malformed,
        Self::Late,
        Self::Repeated,
        Self::Unserved,
        Self::Failed,
        Self::NoRoom,
    ];

    /// As it stands in the label of the metric.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Mapped => "mapped",
            Self::Replaced => "replaced",
            Self::Malformed => "malformed",
            Self::Late => "late",
            Self::Repeated => "repeated",
            Self::Unserved => "unserved",
            Self::Failed => "failed",
            Self::NoRoom => "no_room",
        }
    }
}

/// Counts clouds by what became of them.
pub(crate) struct Counts {
    fates: Vec<(Fate, AtomicU64, ::metrics::Counter)>,
    last_line: Mutex<Option<Instant>>,
}

impl Counts {
    pub(crate) fn new() -> Self {
        let fate = |fate: &Fate| {
            let labels = [("fate", fate.as_str())];
            let counter = metrics::counter(Metric::CloudsTotal, &labels);
            (*fate, AtomicU64::new(0), counter)
        };
        Self {
            fates: Fate::ALL.iter().map(fate).collect(),
            last_line: Mutex::new(None),
        }
    }

    /// Counts a cloud.
    pub(crate) fn count(&self, fate: Fate) {
        if let Some((_, count, counter)) = self.fates.iter().find(|(own, ..)| *own == fate) {
            count.fetch_add(1, Ordering::Relaxed);
            counter.increment(1);
        }
    }

    /// Counts a cloud that was refused, and says why, not too often.
    pub(crate) fn refuse(&self, cell: &Cell, fate: Fate, reason: &dyn std::fmt::Display) {
        self.count(fate);
        let now = Instant::now();
        let mut last = lock(&self.last_line);
        if last.is_none_or(|last| now - last >= LINE_PERIOD) {
            *last = Some(now);
            tracing::warn!(%cell, fate = fate.as_str(), %reason, "cloud refused");
        }
    }

    /// Counts the doubts about a heightmap.
    pub(crate) fn doubt(&self, cell: &Cell, doubts: &[v1::Doubt]) {
        for doubt in doubts {
            let kind = doubt.kind();
            let labels = [("cell", cell.as_str()), ("kind", kind.as_str_name())];
            metrics::counter(Metric::DoubtsTotal, &labels).increment(1);
        }
    }

    /// How many clouds there were.
    pub(crate) fn of(&self, fate: Fate) -> u64 {
        let own = self.fates.iter().find(|(own, ..)| *own == fate);
        own.map_or(0, |(_, count, _)| count.load(Ordering::Relaxed))
    }
}
