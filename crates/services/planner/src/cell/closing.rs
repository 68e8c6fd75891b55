//! Containers that are opened and closed while the session goes on.

use std::time::{Duration, Instant};

use ppnpack_packing::kernel::grid::ContainerSize;
use ppnpack_packing::streams::closing::{Closing, ClosingRules};
use ppnpack_protocol::session::open_container;
use ppnpack_service::rpc::Incoming;
use ppnpack_wire::{header, v1};

use super::CellPlanner;
use super::answers::read_regions;
use crate::fill::{fill, open_by_fullness};
use crate::orders::orders;
use crate::refusal::Refusal;

/// Pause before a container that could not be closed is looked at again.
const PAUSE: Duration = Duration::from_millis(500);

impl CellPlanner {
    pub(super) fn open(&mut self, incoming: &Incoming<v1::OpenRequest>) -> Result<(), Refusal> {
        let request = incoming.message();
        let start = request.start.as_ref();
        let start =
            start.ok_or_else(|| Refusal::invalid("start is missing: say which container"))?;
        self.open_container(v1::SessionContainer {
            sequence: request.sequence,
            ..read_start(start)?
        })
    }

    /// Has the session go on with an empty container.
    pub(super) fn open_container(&mut self, start: v1::SessionContainer) -> Result<(), Refusal> {
        let (container, sequence) = (start.container.clone(), start.sequence);
        self.session.change(|session| session.open(start))?;
        tracing::info!(cell = %self.cell, container, sequence, "an empty container stands there");
        self.automatic.go_on();
        self.place_of(&container)?.changed(None);
        Ok(())
    }

    pub(super) fn close(&mut self, incoming: &Incoming<v1::CloseRequest>) -> Result<(), Refusal> {
        let request = incoming.message();
        let closed = v1::ClosedContainer {
            container: request.container.clone(),
            sequence: request.sequence,
            reason: v1::ClosingReason::Request.into(),
            text: header::text(&request.text),
            items: 0,
        };
        self.close_container(closed, request.is_renewed)
    }

    fn close_container(
        &mut self,
        closed: v1::ClosedContainer,
        is_renewed: bool,
    ) -> Result<(), Refusal> {
        let renewal_id = is_renewed.then(|| format!("{:032x}", rand::random::<u128>()));
        let why = closed.clone();
        self.session
            .change(|session| session.close(closed, renewal_id))?;
        let (container, sequence) = (why.container, why.sequence);
        tracing::info!(cell = %self.cell, container, sequence, why = why.text, "a container is closed");
        Ok(())
    }

    /// Closes the fullest container, as nothing of the buffer fits into any; says whether there is
    /// one. It leaves out empty ones, and those no larger than an open one that is empty: what does
    /// not fit into that does not fit into an empty one there.
    pub(super) fn close_fullest(&mut self) -> Result<bool, Refusal> {
        if !self.settings.closing.renews {
            return Ok(false);
        }
        let places = &self.places;
        let size = |name: &str| {
            let place = places.iter().find(|place| place.name == name)?;
            Some(place.grid.container())
        };
        let open = open_by_fullness(&self.session, &mut self.shapes, size);
        let is_empty = |name: &String| self.session.packed_in(name).next().is_none();
        let (empty, begun): (Vec<String>, Vec<String>) = open.into_iter().partition(is_empty);
        let empty = empty.iter().map(|name| self.size(name));
        let empty = empty.collect::<Result<Vec<ContainerSize>, Refusal>>()?;
        for name in begun {
            let size = self.size(&name)?;
            if empty.iter().any(|empty| is_within(&size, empty)) {
                continue;
            }
            let sequence = self.session.container(&name)?.sequence;
            self.close_container(closed(&name, sequence, &Closing::NothingFits), true)?;
            return Ok(true);
        }
        Ok(false)
    }

    /// Closes the containers that a rule of the cell closes, where anything changed.
    pub(super) fn close_done(&mut self) {
        let has_rules = self.settings.closing.rules != ClosingRules::default();
        let is_due = self.session.closes_at.take_if(|at| *at <= Instant::now());
        if is_due.is_none() || !has_rules {
            return;
        }
        let containers = self.session.containers().iter();
        let open = containers.filter(|container| container.is_open);
        let open: Vec<(String, u64)> = open
            .map(|container| (container.container.clone(), container.sequence))
            .collect();
        for (name, sequence) in open {
            if let Err(refusal) = self.close_where_done(&name, sequence) {
                tracing::warn!(cell = %self.cell, container = name, reason = refusal.message, "not closed yet");
                self.session.closes_at = Some(Instant::now() + PAUSE);
            }
        }
    }

    fn close_where_done(&mut self, name: &str, sequence: u64) -> Result<(), Refusal> {
        let pending = self.session.pending();
        if pending.is_some_and(|pending| pending.container == name) {
            return Ok(());
        }
        let size = self.size(name)?;
        let fill = fill(&self.session, &mut self.shapes, name, size);
        let rules = self.settings.closing.rules;
        let by_fill = rules.closing(&fill);
        let is_complete = by_fill.is_none() && self.is_complete(name);
        let closing = by_fill.or_else(|| is_complete.then_some(Closing::OrderComplete));
        let Some(closing) = closing else {
            return Ok(());
        };
        let renews = self.settings.closing.renews;
        self.close_container(closed(name, sequence, &closing), renews)
    }

    fn size(&mut self, name: &str) -> Result<ContainerSize, Refusal> {
        Ok(self.place_of(name)?.grid.container())
    }

    /// Says whether a container is for one order of which all that was announced lies in it.
    fn is_complete(&mut self, name: &str) -> bool {
        let rules = &self.settings.rules;
        if !self.settings.closing.rules.order_complete {
            return false;
        }
        let open = [name.to_owned()];
        let orders = orders(rules, &self.session, &mut self.shapes, &open);
        orders.is_some_and(|orders| orders.complete() == Some(0))
    }
}

/// Describes a container that a rule closes, as the session tells of it.
fn closed(name: &str, sequence: u64, why: &Closing) -> v1::ClosedContainer {
    let (reason, text) = match why {
        Closing::NothingFits => (
            v1::ClosingReason::NothingFits,
            "no item of the buffer fits into an open container, and this was the fullest",
        ),
        Closing::Full { .. } => (
            v1::ClosingReason::Full,
            "it is as full as the cell is set to",
        ),
        Closing::OrderComplete => (
            v1::ClosingReason::OrderComplete,
            "all items that were announced of its order are in it",
        ),
    };
    v1::ClosedContainer {
        container: name.to_owned(),
        sequence,
        reason: reason.into(),
        text: text.to_owned(),
        items: 0,
    }
}

/// Says whether a container is no larger than another one, along any axis, and of its shape.
fn is_within(size: &ContainerSize, other: &ContainerSize) -> bool {
    let is_smaller = size.x_m <= other.x_m && size.y_m <= other.y_m && size.z_m <= other.z_m;
    let shape = |size: &ContainerSize| [size.draft_rad, size.corner_radius_m];
    is_smaller && shape(size) == shape(other)
}

/// Reads a container that is opened, the first that stands there.
pub(super) fn read_start(start: &v1::ContainerStart) -> Result<v1::SessionContainer, Refusal> {
    let keep_out = read_regions(&start.keep_out)?;
    let name = start.container.clone();
    Ok(open_container(name, keep_out, start.least_state_number))
}
