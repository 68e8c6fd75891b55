//! What time it is on the bridge's clock, by which decisions age.

use ppnpack_service::ServiceError;
use ppnpack_service::process::Process;
use ppnpack_service::stream::{Arrived, Latest};
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::{MAX_MESSAGE_BYTES, v1};

/// The clock of a cell's bridge, as that tells it with each state.
pub(super) struct BridgeClock {
    states: Latest<v1::CellState>,
    /// What it told last.
    told: Option<Arrived<u64>>,
}

impl BridgeClock {
    pub(super) fn subscribe(process: &Process, cell: &Cell) -> Result<Self, ServiceError> {
        Ok(Self {
            states: Latest::subscribe(process, cell, Stream::State, MAX_MESSAGE_BYTES)?,
            told: None,
        })
    }

    /// Takes over what the bridge said just now.
    pub(super) fn heard(&mut self, state: &v1::CellState) {
        self.told = Some(Arrived::now(state.clock_ns));
    }

    /// Whether a bridge was ever heard of.
    pub(super) fn was_heard(&mut self) -> bool {
        if let Some(Ok(arrived)) = self.states.take().map(Arrived::transpose) {
            self.told = Some(arrived.map(|state| state.clock_ns));
        }
        self.told.is_some()
    }

    /// What it shows now, in nanoseconds: a little less, as a state is on its way for a while; 0 where that is not known.
    pub(super) fn now_ns(&mut self) -> u64 {
        self.was_heard();
        let told = self.told.as_ref().filter(|told| told.message != 0);
        told.map_or(0, |told| {
            let since_ns = u64::try_from(told.at.elapsed().as_nanos()).unwrap_or(u64::MAX);
            told.message.saturating_add(since_ns)
        })
    }
}
