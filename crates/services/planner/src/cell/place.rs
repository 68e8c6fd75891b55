//! A container of a cell, as its actor reaches it.

use std::time::{Duration, Instant};

use ppnpack_packing::kernel::grid::Grid;
use ppnpack_service::ServiceError;
use ppnpack_service::clock::Boottime;
use ppnpack_service::process::Process;
use ppnpack_service::rpc::CallError;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1::{self, Status};

use super::Shared;
use crate::bridge::Bridge;
use crate::refusal::Refusal;
use crate::settings::ContainerPlan;
use crate::step::Change;

/// Time until a perception that inspects nothing is asked again: it may be given a catalogue.
const UNINSPECTED: Duration = Duration::from_secs(60);

/// Maximum wait for the bridge to void what was decided.
const VOID_LIMIT: Duration = Duration::from_millis(500);

/// A place for a container of a cell.
pub(super) struct Place {
    /// Its name in sessions; empty where it is the cell itself.
    pub(super) name: String,
    /// The name under which bridge and perception serve it.
    pub(super) address: Cell,
    pub(super) grid: Grid,
    pub(super) bridge: Bridge,
    /// Changes since the last step.
    pub(super) change: Change,
    /// Time before which a perception that inspects nothing here is not asked again.
    pub(super) uninspected_until: Option<Instant>,
}

impl Place {
    pub(super) fn new(
        process: &Process,
        plan: ContainerPlan,
        shared: &Shared,
    ) -> Result<Self, ServiceError> {
        let ContainerPlan {
            name,
            address,
            settings,
        } = plan;
        Ok(Self {
            name,
            grid: settings.grid.build().map_err(ServiceError::start)?,
            bridge: Bridge::subscribe(process, &address, &shared.helpers.client)?,
            change: Change::default(),
            uninspected_until: None,
            address,
        })
    }

    /// Notes that the content changed just now, to this state where it is known.
    pub(super) fn changed(&mut self, state_number: Option<u64>) {
        self.change = Change {
            at: Some(Boottime::now()),
            state_number,
            is_by_hand: self.change.is_by_hand || state_number.is_none(),
        };
    }

    /// Says whether perception may inspect what is placed here, as far as is known.
    pub(super) fn may_be_inspected(&self) -> bool {
        let until = self.uninspected_until;
        until.is_none_or(|until| until <= Instant::now())
    }

    /// Notes that perception inspects nothing here; says whether that is news.
    pub(super) fn is_not_inspected(&mut self) -> bool {
        let until = Instant::now() + UNINSPECTED;
        self.uninspected_until.replace(until).is_none()
    }

    /// Has the bridge count the state up, so that all that was decided before is stale, however
    /// late its request comes. Gives the new state; `None` where there is no bridge, and a
    /// controller drives the robot itself.
    ///
    /// # Errors
    /// The status with which the bridge refuses: [`Status::Busy`] while the robot carries something
    /// out; [`Status::Unavailable`] where a bridge that was there, now or when `is_by_bridge` was
    /// decided, does not answer.
    pub(super) fn void_decisions(
        &mut self,
        is_by_bridge: bool,
        deadline: Instant,
    ) -> Result<Option<u64>, Refusal> {
        // Whoever has that done has looked.
        self.change.is_by_hand = true;
        let until = deadline.min(Instant::now() + VOID_LIMIT);
        let request = v1::ChangedRequest::default();
        match self.bridge.call(request, until) {
            Ok(reply) => Ok(reply
                .state
                .map(|state| self.bridge.heard(state).state_number)),
            // One that is away for a moment may get such a request when it is back.
            Err(CallError::NoAnswer { .. }) if !is_by_bridge && !self.bridge.was_heard() => {
                Ok(None)
            }
            Err(error) => Err(Refusal::new(
                error.status().unwrap_or(Status::Unavailable),
                format_args!("what was decided before may still begin: {error}"),
            )),
        }
    }
}
