//! Orders: which items belong together, and which of the open containers an item may go into, wherever it would lie there.
//!
//! Some rules are never broken; others say what is better, and give way where nothing else could be packed.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::candidate::Candidate;
use crate::capacity::Capacity;
use crate::closing::Closing;

/// How orders share containers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sharing {
    /// A container holds items of one order. It is closed when the order is complete.
    OneOrder,
    /// Several orders share a container; each goes into as few as possible.
    #[default]
    Shared,
}

/// What containers may hold.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ContainerRules {
    /// How orders share them.
    pub sharing: Sharing,
    /// Pairs of groups that never travel in one container.
    pub apart: Vec<(String, String)>,
    /// The greatest mass of what one holds, in kilograms.
    pub most_kg: Option<f64>,
    /// The volume of items that a container is expected to hold, in cubic metres. Only where the rest of an order fits into that is it
    /// begun in a container that is not empty; without, anywhere.
    pub expected_m3: Option<f64>,
    /// By how much containers differ in that: the standard deviation, in cubic metres; 0 where it is not given. With `certainty_percent`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spread_m3: Option<f64>,
    /// With how much certainty the rest of an order has to fit into a container that is not empty, to be begun there, in percent. What
    /// containers come to hold is learned from those into which nothing went any more, as soon as they are enough; before, it is
    /// `expected_m3` with `spread_m3`. Without, `expected_m3` is taken as it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub certainty_percent: Option<f64>,
}

/// What is known of an item beside its shape.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderItem {
    /// Its order.
    pub order: Arc<str>,
    /// Its group, where it is of one.
    pub group: Option<Arc<str>>,
    /// Its mass, in kilograms; unknown ones count nothing.
    pub mass_kg: Option<f64>,
    /// The volume of its mesh, in cubic metres.
    pub volume_m3: f64,
}

/// Why an item may not go into a container.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Bar {
    /// The container is for one order, and this is another one's.
    #[error("the container is for order {0}")]
    OtherOrder(Arc<str>),
    /// It must not travel with what is in there.
    #[error("{0} must not travel with {1}")]
    GroupsApart(Arc<str>, Arc<str>),
    /// The container would be too heavy.
    #[error("the container would be {over_kg:.2} kg too heavy")]
    TooHeavy {
        /// By how much.
        over_kg: f64,
    },
    /// Other items of its order lie in another open container. Gives way.
    #[error("order {0} is in another container")]
    OrderElsewhere(Arc<str>),
    /// The rest of its order is not expected to fit. Gives way.
    #[error("the rest of order {order} is not expected to fit: {over_m3:.4} m³ too much")]
    NoRoomForOrder {
        /// The order.
        order: Arc<str>,
        /// By how much.
        over_m3: f64,
    },
    /// The rest of its order is not certain enough to fit. Gives way.
    #[error("the rest of order {order} ({rest_m3:.4} m³) fits with {percent:.0} % certainty")]
    OrderUnlikely {
        /// The order.
        order: Arc<str>,
        /// The volume of what is left of it, in cubic metres.
        rest_m3: f64,
        /// With which certainty that fits.
        percent: f64,
    },
    /// Orders are packed one after another, and one before it waits. Gives way.
    #[error("order {0} comes before")]
    EarlierOrder(Arc<str>),
}

impl Bar {
    /// Whether it is broken where nothing else could be packed.
    pub fn gives_way(&self) -> bool {
        matches!(
            self,
            Self::OrderElsewhere(_)
                | Self::NoRoomForOrder { .. }
                | Self::OrderUnlikely { .. }
                | Self::EarlierOrder(_)
        )
    }
}

/// What a container holds, as far as rules are concerned.
#[derive(Debug, Clone, Default)]
struct Held {
    orders: BTreeSet<Arc<str>>,
    groups: BTreeSet<Arc<str>>,
    mass_kg: f64,
    volume_m3: f64,
}

/// What is left of an order.
#[derive(Debug, Clone, Copy, Default)]
struct Rest {
    items: usize,
    volume_m3: f64,
}

/// The orders of a stream, and what the open containers hold of them. Items of no order have no rules.
#[derive(Debug, Clone, Default)]
pub struct Orders {
    rules: ContainerRules,
    items: BTreeMap<usize, OrderItem>,
    left: BTreeMap<Arc<str>, Rest>,
    open: Vec<Held>,
    /// The first order in the buffer that no open container holds anything of.
    next: Option<Arc<str>>,
    /// What containers held into which nothing went any more, in cubic metres.
    filled_m3: Vec<f64>,
}

impl Orders {
    /// Orders whose items arrive so: by their place in the sequence of arrivals.
    pub fn new(rules: ContainerRules, items: impl IntoIterator<Item = (usize, OrderItem)>) -> Self {
        let items: BTreeMap<usize, OrderItem> = items.into_iter().collect();
        let mut left: BTreeMap<Arc<str>, Rest> = BTreeMap::new();
        for item in items.values() {
            let rest = left.entry(Arc::clone(&item.order)).or_default();
            rest.items += 1;
            rest.volume_m3 += item.volume_m3;
        }
        Self {
            rules,
            items,
            left,
            ..Self::default()
        }
    }

    /// A container is opened; it stands behind the others.
    pub fn opened(&mut self) {
        self.open.push(Held::default());
    }

    /// A container is closed. Those behind it move up.
    pub fn closed(&mut self, container: usize) {
        if container < self.open.len() {
            self.open.remove(container);
        }
    }

    /// A step begins, with these items in the buffer.
    pub fn begin(&mut self, candidates: &[Candidate]) {
        self.begin_with(candidates.iter().map(|held| held.arrival));
    }

    /// A step begins, with the items of these arrivals in the buffer.
    pub fn begin_with(&mut self, arrivals: impl Iterator<Item = usize>) {
        let orders = arrivals.filter_map(|arrival| Some(&self.items.get(&arrival)?.order));
        let mut unbegun = orders.filter(|order| self.homes(order).next().is_none());
        self.next = unbegun.next().cloned();
    }

    /// An item was placed in a container.
    pub fn packed(&mut self, container: usize, arrival: usize) {
        let item = self.items.get(&arrival).cloned();
        let (Some(held), Some(item)) = (self.open.get_mut(container), item) else {
            return;
        };
        held.mass_kg += item.mass_kg.unwrap_or(0.0);
        held.volume_m3 += item.volume_m3;
        held.orders.insert(Arc::clone(&item.order));
        held.groups.extend(item.group.clone());
        self.gone(&item);
    }

    /// An item that fits nowhere will not come.
    pub fn dropped(&mut self, arrival: usize) {
        if let Some(item) = self.items.get(&arrival).cloned() {
            self.gone(&item);
        }
    }

    fn gone(&mut self, item: &OrderItem) {
        if let Some(rest) = self.left.get_mut(&item.order) {
            rest.items = rest.items.saturating_sub(1);
            rest.volume_m3 = (rest.volume_m3 - item.volume_m3).max(0.0);
        }
    }

    /// What is left of the first order that waits and was begun nowhere, in cubic metres.
    pub fn next_m3(&self) -> Option<f64> {
        let next = self.next.as_ref()?;
        Some(self.rest(next).volume_m3)
    }

    /// The order of an item.
    pub fn order_of(&self, arrival: usize) -> Option<&Arc<str>> {
        self.items.get(&arrival).map(|item| &item.order)
    }

    /// The first container that is for one order which is complete.
    pub fn complete(&self) -> Option<usize> {
        if self.rules.sharing != Sharing::OneOrder {
            return None;
        }
        self.open.iter().position(|held| self.is_complete(held))
    }

    /// Whether something lies in a container, and nothing is to come of its orders.
    fn is_complete(&self, held: &Held) -> bool {
        !held.orders.is_empty() && held.orders.iter().all(|order| self.rest(order).items == 0)
    }

    /// Whether a container is for another order than this one.
    fn is_for_other(&self, held: &Held, order: &Arc<str>) -> bool {
        self.rules.sharing == Sharing::OneOrder && held.orders.iter().any(|other| other != order)
    }

    /// A container held so much, in cubic metres, when nothing went into it any more: from that it is learned what they come to hold.
    pub fn learn(&mut self, held_m3: f64) {
        self.filled_m3.push(held_m3);
    }

    /// What containers come to hold, as far as that is known.
    pub fn capacity(&self) -> Option<Capacity> {
        Capacity::learned(&self.filled_m3).or_else(|| {
            Some(Capacity {
                mean_m3: self.rules.expected_m3?,
                spread_m3: self.rules.spread_m3.unwrap_or_default(),
            })
        })
    }

    /// The open containers that would be closed for the first order that waits and was begun nowhere, each with why: those whose orders are
    /// complete, where no open container takes all of that order with the certainty that is asked for, but an empty one would.
    pub fn closed_for_next(&self) -> Vec<(usize, Closing)> {
        let wanted = self.rules.certainty_percent.zip(self.capacity());
        let Some(((wanted, capacity), next)) = wanted.zip(self.next.as_ref()) else {
            return Vec::new();
        };
        let percents = self
            .open
            .iter()
            .map(|held| match self.is_for_other(held, next) {
                true => 0.0,
                false => self.percent(&capacity, held, next),
            });
        let percents: Vec<f64> = percents.collect();
        let empty = self.percent(&capacity, &Held::default(), next);
        if empty < wanted || percents.iter().any(|percent| *percent >= wanted) {
            return Vec::new();
        }
        let open = self.open.iter().enumerate().zip(percents);
        let complete = open.filter(|((_, held), _)| self.is_complete(held));
        let closings = complete.map(|((container, _), percent)| {
            let closing = Closing::RestOfOrder {
                order: Arc::clone(next),
                rest_m3: self.rest(next).volume_m3,
                percent,
            };
            (container, closing)
        });
        closings.collect()
    }

    /// Why the item of this arrival may not go into an open container, where it may not. Rules that give way come last.
    pub fn bar(&self, container: usize, arrival: usize) -> Option<Bar> {
        let item = self.items.get(&arrival)?;
        let held = self.open.get(container)?;
        self.other_order(held, item)
            .or_else(|| self.groups_apart(held, item))
            .or_else(|| self.too_heavy(held, item))
            .or_else(|| self.elsewhere(held, item))
            .or_else(|| self.no_room(held, item))
    }

    fn other_order(&self, held: &Held, item: &OrderItem) -> Option<Bar> {
        let other = held.orders.iter().find(|order| **order != item.order)?;
        let is_barred = self.rules.sharing == Sharing::OneOrder;
        is_barred.then(|| Bar::OtherOrder(Arc::clone(other)))
    }

    fn groups_apart(&self, held: &Held, item: &OrderItem) -> Option<Bar> {
        let group = item.group.as_ref()?;
        let is_apart = |other: &&Arc<str>| {
            let mut pairs = self.rules.apart.iter();
            pairs.any(|(a, b)| {
                let pair = (a.as_str(), b.as_str());
                pair == (group, other) || pair == (other, group)
            })
        };
        let other = held.groups.iter().find(is_apart)?;
        Some(Bar::GroupsApart(Arc::clone(group), Arc::clone(other)))
    }

    fn too_heavy(&self, held: &Held, item: &OrderItem) -> Option<Bar> {
        let over_kg = held.mass_kg + item.mass_kg? - self.rules.most_kg?;
        (over_kg > 0.0).then_some(Bar::TooHeavy { over_kg })
    }

    /// Where others of its order are, or orders before it are to be begun.
    fn elsewhere(&self, held: &Held, item: &OrderItem) -> Option<Bar> {
        if held.orders.contains(&item.order) {
            return None;
        }
        if self.homes(&item.order).next().is_some() {
            return Some(Bar::OrderElsewhere(Arc::clone(&item.order)));
        }
        let next = self.next.as_ref().filter(|next| **next != item.order)?;
        let is_barred = self.rules.sharing == Sharing::OneOrder;
        is_barred.then(|| Bar::EarlierOrder(Arc::clone(next)))
    }

    fn no_room(&self, held: &Held, item: &OrderItem) -> Option<Bar> {
        if held.orders.is_empty() || held.orders.contains(&item.order) {
            return None;
        }
        if let Some(wanted) = self.rules.certainty_percent {
            return self.unlikely(held, &item.order, wanted);
        }
        let over_m3 = held.volume_m3 + self.needed_m3(held, &item.order) - self.rules.expected_m3?;
        (over_m3 > 0.0).then(|| Bar::NoRoomForOrder {
            order: Arc::clone(&item.order),
            over_m3,
        })
    }

    fn unlikely(&self, held: &Held, order: &Arc<str>, wanted: f64) -> Option<Bar> {
        let percent = self.percent(&self.capacity()?, held, order);
        (percent < wanted).then(|| Bar::OrderUnlikely {
            order: Arc::clone(order),
            rest_m3: self.rest(order).volume_m3,
            percent,
        })
    }

    /// With which certainty a container that does not hold anything of an order takes all that is left of it, in percent.
    fn percent(&self, capacity: &Capacity, held: &Held, order: &Arc<str>) -> f64 {
        100.0 * capacity.certainty(held.volume_m3, self.needed_m3(held, order))
    }

    /// What is to come into a container if an order is begun there: the rest of that, and of those that it holds.
    fn needed_m3(&self, held: &Held, order: &Arc<str>) -> f64 {
        let promised = held.orders.iter().map(|order| self.rest(order).volume_m3);
        promised.sum::<f64>() + self.rest(order).volume_m3
    }

    /// The open containers that hold something of an order.
    fn homes<'a>(&'a self, order: &'a Arc<str>) -> impl Iterator<Item = usize> + 'a {
        let open = self.open.iter().enumerate();
        open.filter_map(move |(container, held)| held.orders.contains(order).then_some(container))
    }

    fn rest(&self, order: &Arc<str>) -> Rest {
        self.left.get(order).copied().unwrap_or_default()
    }
}
