//! Containers that are opened and closed while the session goes on.

use std::time::{Duration, Instant};

use ppnpack_packing::closing::{self, ClosingRules, Fill, Missed};
use ppnpack_protocol::session::{Closing, Container, SessionItem};
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

/// The items that were looked at in vain in a container, since its content is what it is.
#[derive(Debug, Default)]
pub(super) struct MissedIn {
    /// Which of the containers that stand there, and the arrivals of what lies in it.
    content: (u64, Vec<usize>),
    items: Missed,
}

/// A domain's reason as the session has it.
fn as_told(why: &closing::Closing) -> Closing {
    match why {
        closing::Closing::NothingFits => Closing::NothingFits,
        closing::Closing::Full { .. } => Closing::Full,
        closing::Closing::NoneOfLast(_) => Closing::NoneOfLast(why.to_string()),
        closing::Closing::RestOfOrder { .. } => Closing::RestOfOrder(why.to_string()),
        closing::Closing::OrderComplete => Closing::OrderComplete,
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

    /// Has the session go on with an empty container, now or when it is its turn.
    pub(super) fn open_container(&mut self, start: Container) -> Result<(), Refusal> {
        let Container {
            name,
            sequence,
            stand,
            ..
        } = start.clone();
        self.change(|session| session.open(start))?;
        tracing::info!(cell = %self.cell, container = name, sequence, ?stand, "an empty container stands there");
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

    /// Closes the fullest container, as nothing of the buffer fits into any; says whether there is one. Not where one is empty: that is
    /// exchanged for another size, and what does not fit into any empty one fits nowhere.
    pub(super) fn close_fullest(&mut self) -> Result<bool, Refusal> {
        if !self.settings.closing.renews {
            return Ok(false);
        }
        let open = self.open_by_fullness();
        let is_empty = |name: &String| self.session.packed_in(name).next().is_none();
        if open.iter().any(is_empty) {
            return self.exchange_empty(&open);
        }
        let fills = open.iter().map(|name| self.fill(name));
        let fills = fills.collect::<Result<Vec<Fill>, Refusal>>()?;
        let fullest = self.settings.closing.rules.fullest(&fills);
        let Some(name) = fullest.and_then(|at| open.into_iter().nth(at)) else {
            return Ok(false);
        };
        let sequence = self.session.container(&name)?.sequence;
        self.close_container(&name, sequence, Closing::NothingFits, true)?;
        Ok(true)
    }

    /// Closes the containers that a rule of the cell closes, where anything changed.
    pub(super) fn close_done(&mut self) {
        let has_rules = self.settings.closing.rules != ClosingRules::default();
        if !self.closing.take_due() || !has_rules {
            return;
        }
        let containers = self.session.containers().iter();
        let open = containers.filter(|container| container.is_open());
        let open: Vec<(String, u64)> = open
            .map(|container| (container.name.clone(), container.sequence))
            .collect();
        for (name, sequence) in open {
            if let Err(refusal) = self.close_where_done(&name, sequence) {
                tracing::warn!(cell = %self.cell, container = name, reason = refusal.message, "not closed yet");
                self.closing.look_after(PAUSE);
            }
        }
        if let Err(refusal) = self.close_for_next() {
            tracing::warn!(cell = %self.cell, reason = refusal.message, "not closed yet");
            self.closing.look_after(PAUSE);
        }
    }

    fn close_where_done(&mut self, name: &str, sequence: u64) -> Result<(), Refusal> {
        let pending = self.session.pending();
        if pending.is_some_and(|pending| pending.container == name) {
            return Ok(());
        }
        let fill = self.fill(name)?;
        let rules = self.settings.closing.rules;
        let by_fill = rules.closing(&fill, &self.missed_in(name).items);
        let is_complete = by_fill.is_none() && self.is_complete(name);
        let closing = by_fill.or_else(|| is_complete.then_some(closing::Closing::OrderComplete));
        let Some(closing) = closing else {
            return Ok(());
        };
        let renews = self.settings.closing.renews;
        self.close_container(name, sequence, as_told(&closing), renews)
    }

    /// Closes a container where an order that waits fits whole into none that is open.
    fn close_for_next(&mut self) -> Result<(), Refusal> {
        // Where an item is on its way it is not known yet where its order is.
        if !self.settings.closing.rules.rest_of_order || self.session.pending().is_some() {
            return Ok(());
        }
        // An empty one that comes may take it.
        if self.is_renewing() {
            return Ok(());
        }
        let open = self.open_by_fullness();
        let Some(mut orders) = self.orders(&open) else {
            return Ok(());
        };
        let buffer = self.session.buffer(self.settings.method.buffer);
        orders.begin_with(buffer.map(|item| item.arrival));
        let fills = open.iter().map(|name| self.fill(name));
        let fills = fills.collect::<Result<Vec<Fill>, Refusal>>()?;
        let could_be = orders.closed_for_next().into_iter();
        let rules = &self.settings.closing.rules;
        let Some((at, closing)) = rules.fullest_that_may_leave(&fills, could_be) else {
            return Ok(());
        };
        let Some(name) = open.get(at) else {
            return Ok(());
        };
        let sequence = self.session.container(name)?.sequence;
        let renews = self.settings.closing.renews;
        self.close_container(name, sequence, as_told(&closing), renews)
    }

    /// Items of these arrivals were looked at in a container, and have no valid placement there. Not known any more after a restart:
    /// then they are counted anew.
    pub(super) fn note_missed(&mut self, name: &str, arrivals: &[usize]) {
        let rules = self.settings.closing.rules;
        if rules.none_of_last.is_none() {
            return;
        }
        let missed = self.missed_in(name);
        for arrival in arrivals {
            missed.items.note(*arrival, &rules);
        }
        self.closing.look_again();
    }

    /// What was looked at in vain in a container as it is now.
    fn missed_in(&mut self, name: &str) -> &mut MissedIn {
        let sequence = self.session.container(name);
        let sequence = sequence.map_or(0, |container| container.sequence);
        let lying = self.session.packed_in(name).map(|item| item.arrival);
        let content = (sequence, lying.collect());
        let missed = self.missed.entry(name.to_owned()).or_default();
        if missed.content != content {
            missed.items.forget();
            missed.content = content;
        }
        missed
    }

    fn fill(&mut self, name: &str) -> Result<Fill, Refusal> {
        let size = self.place_of(name)?.planning.grid().container();
        Ok(Fill::of(self.filled_m3(name), size))
    }

    /// Whether a container is for one order of which all that was announced lies in it.
    fn is_complete(&mut self, name: &str) -> bool {
        if !self.settings.closing.rules.order_complete {
            return false;
        }
        let orders = self.orders(&[name.to_owned()]);
        orders.is_some_and(|orders| orders.complete() == Some(0))
    }

    /// The open containers, that with the greatest volume of items first; of equal ones in the order of the cell.
    pub(super) fn open_by_fullness(&mut self) -> Vec<String> {
        let containers = self.session.containers().iter();
        let open = containers.filter(|container| container.is_open());
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
        self.volume_m3(&items)
    }

    /// The volume of items, in cubic metres; without those whose shape is not known any more.
    pub(super) fn volume_m3(&mut self, items: &[SessionItem]) -> f64 {
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
