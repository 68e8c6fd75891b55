//! The streams of a cell, but for the clouds.

use std::time::{Duration, Instant};

use ppnpack_service::ServiceError;
use ppnpack_service::metrics::{self, Metric};
use ppnpack_service::process::Process;
use ppnpack_service::stream::Publisher;
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::{header, v1};

use crate::Settings;
use crate::clock;
use crate::robot::Robot;
use crate::settings::span;
use ppnpack_protocol::ledger::{Ledger, Record};
use ppnpack_protocol::message;

/// Publishes states and outcomes.
pub(crate) struct Streams {
    cell: Cell,
    states: Publisher<v1::CellState>,
    outcomes: Publisher<v1::Outcome>,
    is_simulated: bool,
    state_period: Duration,
    /// The time to publish the state although it did not change.
    pub(crate) next_state: Instant,
}

impl Streams {
    pub(crate) fn new(
        process: &Process,
        cell: &Cell,
        robot: &dyn Robot,
        settings: &Settings,
    ) -> Result<Self, ServiceError> {
        // From 0, so that the first of a kind is an increase.
        for kind in (1..).map_while(|kind| v1::OutcomeKind::try_from(kind).ok()) {
            count_outcomes(cell, kind, 0);
        }
        Ok(Self {
            cell: cell.clone(),
            states: Publisher::new(process, cell, Stream::State)?,
            outcomes: Publisher::new(process, cell, Stream::Outcome)?,
            is_simulated: robot.is_simulated(),
            state_period: span(settings.state_period_s),
            next_state: Instant::now(),
        })
    }

    /// The state of the cell.
    pub(crate) fn state_of(&self, ledger: &Ledger) -> v1::CellState {
        let executing = match ledger.under_way() {
            Some(Record::Placement { placement, .. }) => placement.placement_id.clone(),
            _ => String::new(),
        };
        let head = ledger.head();
        v1::CellState {
            state_number: head.state_number,
            executing_placement_id: executing,
            bodies: head.bodies.iter().map(message::write_body).collect(),
            is_simulated: self.is_simulated,
            hold: ledger.is_held().then(|| v1::Hold {
                reason: header::text(&head.holds.to_string()),
                ..v1::Hold::default()
            }),
            holds: head.holds.iter().map(message::write_hold).collect(),
            first_state_number: head.first_state_number,
            clock_ns: clock::now_ns(),
        }
    }

    /// Publishes the state of the cell where it is due.
    pub(crate) fn tell_due_state(&mut self, ledger: &Ledger) {
        let now = Instant::now();
        if self.next_state <= now {
            self.tell_state(ledger);
            self.next_state = now + self.state_period;
        }
    }

    /// Publishes the state of the cell.
    pub(crate) fn tell_state(&self, ledger: &Ledger) {
        warn(self.states.put(&self.state_of(ledger)));
    }

    /// Publishes how a placement ended.
    pub(crate) fn tell_outcome(&self, outcome: &v1::Outcome) {
        count_outcomes(&self.cell, outcome.kind(), 1);
        warn(self.outcomes.put(outcome));
    }
}

fn count_outcomes(cell: &Cell, kind: v1::OutcomeKind, count: u64) {
    let labels = [("cell", cell.as_str()), ("kind", kind.as_str_name())];
    metrics::counter(Metric::OutcomesTotal, &labels).increment(count);
}

/// Warns of an error; nothing depends on a stream, as its content can be asked for.
fn warn(result: Result<(), ServiceError>) {
    if let Err(error) = result {
        tracing::warn!(%error, "not published");
    }
}
