//! Containers that are opened and closed while the session goes on.

use std::time::{Duration, Instant};

use ppnpack_packing::grid::ContainerSize;
use ppnpack_protocol::session::{Closing, Container};
use ppnpack_service::rpc::Incoming;
use ppnpack_wire::{header, v1};

use super::CellPlanner;
use super::answers::read_regions;
use super::refusal::Refusal;

/// How long to wait before a container that could not be closed is looked at again.
const PAUSE: Duration = Duration::from_millis(500);

/// Whether containers are looked at that may be closed.
#[derive(Debug)]
pub(super) struct Done {
    /// When; `None` until something changes.
    next_look: Option<Instant>,
}

impl Default for Done {
    /// At the start they are: what was closed last may not be on disk.
    fn default() -> Self {
        Self {
            next_look: Some(Instant::now()),
        }
    }
}

impl Done {
    pub(super) fn next_look(&self) -> Option<Instant> {
        self.next_look
    }

    pub(super) fn look_again(&mut self) {
        self.look_after(Duration::ZERO);
    }

    fn look_after(&mut self, pause: Duration) {
        self.next_look = Some(Instant::now() + pause);
    }

    fn take_due(&mut self) -> bool {
        self.next_look.take_if(|at| *at <= Instant::now()).is_some()
    }
}

impl CellPlanner {
    pub(super) fn open(
        &mut self,
        incoming: &Incoming<v1::OpenRequest>,
    ) -> Result<v1::OpenReply, Refusal> {
        let request = incoming.message();
        let start = request.start.as_ref();
        let start =
            start.ok_or_else(|| Refusal::invalid("start is missing: say which container"))?;
        self.open_container(Container {
            sequence: request.sequence,
            ..read_start(start)?
        })?;
        Ok(v1::OpenReply {
            session: Some(self.message()),
            ..v1::OpenReply::default()
        })
    }

    /// Has the session go on with an empty container.
    pub(super) fn open_container(&mut self, start: Container) -> Result<(), Refusal> {
        let Container { name, sequence, .. } = start.clone();
        self.change(|session| session.open(start))?;
        tracing::info!(cell = %self.cell, container = name, sequence, "a container is open");
        self.automatic.go_on();
        self.place_of(&name)?.changed(None);
        Ok(())
    }

    pub(super) fn close(
        &mut self,
        incoming: &Incoming<v1::CloseRequest>,
    ) -> Result<v1::CloseReply, Refusal> {
        let request = incoming.message();
        let closing = Closing::Request(header::text(&request.text));
        let sequence = request.sequence;
        self.close_container(&request.container, sequence, closing, request.is_renewed)?;
        Ok(v1::CloseReply {
            session: Some(self.message()),
            ..v1::CloseReply::default()
        })
    }

    fn close_container(
        &mut self,
        name: &str,
        sequence: u64,
        closing: Closing,
        is_renewed: bool,
    ) -> Result<(), Refusal> {
        let renewal_id = is_renewed.then(|| format!("{:032x}", rand::random::<u128>()));
        let why = closing.clone();
        self.change(|session| session.close(name, sequence, closing, renewal_id))?;
        tracing::info!(cell = %self.cell, container = name, sequence, ?why, "a container is closed");
        Ok(())
    }

    /// Closes the fullest container, as nothing of the buffer fits into any; says whether there is one. Not where one is empty: what
    /// does not fit into that fits into none.
    pub(super) fn close_fullest(&mut self) -> Result<bool, Refusal> {
        if !self.settings.closing.renews {
            return Ok(false);
        }
        let open = self.open_by_fullness();
        let is_empty = |name: &String| self.session.packed_in(name).next().is_none();
        if open.iter().any(is_empty) {
            return Ok(false);
        }
        let Some(name) = open.into_iter().next() else {
            return Ok(false);
        };
        let sequence = self.session.container(&name)?.sequence;
        self.close_container(&name, sequence, Closing::NothingFits, true)?;
        Ok(true)
    }

    /// Closes the containers that are as full as the cell is set to, or that hold all of their order, where anything changed.
    pub(super) fn close_done(&mut self) {
        if !self.closing.take_due() {
            return;
        }
        let containers = self.session.containers().iter();
        let open = containers.filter(|container| container.is_open);
        let open: Vec<(String, u64)> = open
            .map(|container| (container.name.clone(), container.sequence))
            .collect();
        for (name, sequence) in open {
            if let Err(refusal) = self.close_where_done(&name, sequence) {
                tracing::warn!(cell = %self.cell, container = name, reason = refusal.message, "not closed yet");
                self.closing.look_after(PAUSE);
            }
        }
    }

    fn close_where_done(&mut self, name: &str, sequence: u64) -> Result<(), Refusal> {
        let pending = self.session.pending();
        if pending.is_some_and(|pending| pending.container == name) {
            return Ok(());
        }
        let closing = if self.is_full(name)? {
            Closing::Full
        } else if self.is_complete(name) {
            Closing::OrderComplete
        } else {
            return Ok(());
        };
        let renews = self.settings.closing.renews;
        self.close_container(name, sequence, closing, renews)
    }

    fn is_full(&mut self, name: &str) -> Result<bool, Refusal> {
        let Some(percent) = self.settings.closing.fill_percent else {
            return Ok(false);
        };
        let ContainerSize { x_m, y_m, z_m } = self.place_of(name)?.planning.grid().container();
        Ok(self.filled_m3(name) * 100.0 >= percent * x_m * y_m * z_m)
    }

    /// Whether a container is for one order of which all that was announced lies in it.
    fn is_complete(&mut self, name: &str) -> bool {
        if !self.settings.closing.order_complete {
            return false;
        }
        let orders = self.orders(&[name.to_owned()]);
        orders.is_some_and(|orders| orders.complete() == Some(0))
    }

    /// The open containers, that with the greatest volume of items first; of equal ones in the order of the cell.
    pub(super) fn open_by_fullness(&mut self) -> Vec<String> {
        let containers = self.session.containers().iter();
        let open = containers.filter(|container| container.is_open);
        let names: Vec<String> = open.map(|container| container.name.clone()).collect();
        if names.len() < 2 {
            return names;
        }
        let open = names.into_iter().map(|name| (self.filled_m3(&name), name));
        let mut open: Vec<(f64, String)> = open.collect();
        open.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        open.into_iter().map(|(_, name)| name).collect()
    }

    /// The volume of the items in an open container, in cubic metres; without those whose shape is not known any more.
    fn filled_m3(&mut self, name: &str) -> f64 {
        let items: Vec<_> = self.session.packed_in(name).cloned().collect();
        let volumes_m3 = items.iter().filter_map(|item| {
            let shape = self.shape(item).ok()?;
            Some(shape.item.mesh_volume_m3())
        });
        volumes_m3.sum()
    }
}

/// A container that is opened, the first that stands there.
pub(super) fn read_start(start: &v1::ContainerStart) -> Result<Container, Refusal> {
    let keep_out = read_regions(&start.keep_out)?;
    let name = start.container.clone();
    Ok(Container::open(name, keep_out, start.least_state_number))
}
