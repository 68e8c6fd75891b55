//! Counts of a cell's plans and sessions, by how they ended.

use ppnpack_service::metrics::{self, Metric};
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1::SessionEnd;

/// Counts from 0, so that the first of a kind is an increase.
pub(crate) fn begin(cell: &Cell) {
    stale_scenes(cell, 0);
    decisions(cell, false, 0);
    decisions(cell, true, 0);
    for end in (1..).map_while(|end| SessionEnd::try_from(end).ok()) {
        sessions_ended(cell, end, 0);
    }
}

pub(crate) fn stale_scenes(cell: &Cell, count: u64) {
    metrics::counter(Metric::StaleScenesTotal, &[("cell", cell.as_str())]).increment(count);
}

pub(crate) fn decisions(cell: &Cell, is_degraded: bool, count: u64) {
    let is_degraded = if is_degraded { "true" } else { "false" };
    let labels = [("cell", cell.as_str()), ("is_degraded", is_degraded)];
    metrics::counter(Metric::DecisionsTotal, &labels).increment(count);
}

pub(crate) fn sessions_ended(cell: &Cell, end: SessionEnd, count: u64) {
    let labels = [("cell", cell.as_str()), ("end", end.as_str_name())];
    metrics::counter(Metric::SessionsEndedTotal, &labels).increment(count);
}
