//! Orders: which items belong together, and which of the open containers an item may go into, wherever it would lie there.
//!
//! Some rules are never broken; others say what is better, and give way where nothing else could be packed.

mod attempts;
mod bar;
mod ties;

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

pub use attempts::Attempt;
pub use bar::Bar;
pub use ties::Tie;
use ties::{Counts, Unit, Units};

use crate::candidate::Candidate;

/// Sums of masses that differ by less than this are the same, in kilograms.
const SAME_KG: f64 = 1e-9;

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
    /// Whether each order lies in one container. It is begun only where the mass and the groups of all that is known of it are possible.
    pub undivided: bool,
    /// Pairs of groups that never travel in one container.
    pub apart: Vec<(String, String)>,
    /// Pairs of groups that travel together: all items of an order that are of either lie in one container.
    pub together: Vec<(String, String)>,
    /// The greatest mass of what one holds, in kilograms.
    pub most_kg: Option<f64>,
}

impl ContainerRules {
    /// A pair of groups that would have to travel together and must not, where there is one: none of them could be packed.
    pub fn contradiction(&self) -> Option<&(String, String)> {
        let mut together = self.together.iter();
        together.find(|(a, b)| self.are_apart(a, b))
    }

    fn are_apart(&self, a: &str, b: &str) -> bool {
        let mut pairs = self.apart.iter();
        pairs.any(|(one, other)| {
            let pair = (one.as_str(), other.as_str());
            pair == (a, b) || pair == (b, a)
        })
    }

    /// Two of these groups that must not travel together, the first of one list and the second of the other.
    fn apart<'a>(
        &self,
        ones: impl IntoIterator<Item = &'a Arc<str>>,
        others: &Counts,
    ) -> Option<Bar> {
        let mut ones = ones.into_iter();
        ones.find_map(|one| {
            let other = others.keys().find(|other| self.are_apart(one, other))?;
            Some(Bar::GroupsApart(Arc::clone(one), Arc::clone(other)))
        })
    }
}

/// What is known of an item beside its shape.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderItem {
    /// Its order.
    pub order: Arc<str>,
    /// Its group, where it is of one.
    pub group: Option<Arc<str>>,
    /// The bundle of items that it travels with in one container, of whatever orders, where it is of one.
    pub bundle: Option<Arc<str>>,
    /// Its mass, in kilograms; unknown ones count nothing.
    pub mass_kg: Option<f64>,
    /// Of the items of a buffer those with the greatest number are packed first, as long as one of them can be.
    pub urgency: u32,
}

impl OrderItem {
    /// An item of an order, of which no more is known.
    pub fn new(order: Arc<str>) -> Self {
        Self {
            order,
            group: None,
            bundle: None,
            mass_kg: None,
            urgency: 0,
        }
    }
}

/// What a container holds, as far as rules are concerned.
#[derive(Debug, Clone, Default)]
struct Held {
    items: BTreeSet<usize>,
    orders: BTreeSet<Arc<str>>,
    groups: Counts,
    ties: BTreeSet<Tie>,
    /// Those that something in it is of.
    units: BTreeSet<usize>,
    mass_kg: f64,
}

/// What is left of an order.
#[derive(Debug, Clone, Copy, Default)]
struct Rest {
    items: usize,
    /// How many were known of from the beginning.
    known: usize,
    /// How many more it is said to have than were known of.
    unannounced: usize,
}

/// The orders of a stream, and what the open containers hold of them. Items of no order have no rules.
#[derive(Debug, Clone, Default)]
pub struct Orders {
    rules: ContainerRules,
    items: BTreeMap<usize, OrderItem>,
    left: BTreeMap<Arc<str>, Rest>,
    open: Vec<Held>,
    /// Items that will not come, or left with their container: nothing waits for them.
    away: BTreeSet<usize>,
    /// What must have travelled with something in a container that was closed.
    closed_ties: BTreeSet<Tie>,
    units: Units,
    /// Whether the units are those of the items that are here.
    are_units_found: bool,
    /// The first order in the buffer that no open container holds anything of, of the most urgent items.
    next: Option<Arc<str>>,
}

impl Orders {
    /// Orders whose items arrive so: by their place in the sequence of arrivals.
    pub fn new(rules: ContainerRules, items: impl IntoIterator<Item = (usize, OrderItem)>) -> Self {
        let items: BTreeMap<usize, OrderItem> = items.into_iter().collect();
        let mut left: BTreeMap<Arc<str>, Rest> = BTreeMap::new();
        for item in items.values() {
            let rest = left.entry(Arc::clone(&item.order)).or_default();
            rest.items += 1;
            rest.known += 1;
        }
        Self {
            units: Units::new(&rules, &items),
            rules,
            items,
            left,
            ..Self::default()
        }
    }

    /// An order has so many items altogether: it is not complete before as many are known. The greatest number counts that is said.
    pub fn expect(&mut self, order: &str, items: usize) {
        if let Some(rest) = self.left.get_mut(order) {
            let unannounced = items.saturating_sub(rest.known);
            rest.unannounced = unannounced.max(rest.unannounced);
        }
    }

    /// A container is opened; it stands behind the others.
    pub fn opened(&mut self) {
        self.open.push(Held::default());
    }

    /// A container is closed. Those behind it move up.
    pub fn closed(&mut self, container: usize) {
        if container < self.open.len() {
            let held = self.open.remove(container);
            self.away.extend(held.items);
            self.closed_ties.extend(held.ties);
            self.are_units_found = false;
        }
    }

    /// A step begins, with these items in the buffer.
    pub fn begin(&mut self, candidates: &[Candidate]) {
        if !self.are_units_found {
            self.find_units();
        }
        let waiting = candidates.iter();
        let waiting = waiting.filter_map(|held| self.items.get(&held.arrival));
        let unbegun = waiting.filter(|item| self.homes(&item.order).next().is_none());
        // Of equal ones, `min_by_key` gives the first.
        let next = unbegun.min_by_key(|item| Reverse(item.urgency));
        self.next = next.map(|item| Arc::clone(&item.order));
    }

    fn find_units(&mut self) {
        let open = self.open.iter();
        let packed: BTreeSet<usize> = open.flat_map(|held| held.items.iter().copied()).collect();
        let is_packed = |arrival: usize| packed.contains(&arrival);
        self.units.find(&self.items, &self.away, is_packed);
        for held in &mut self.open {
            let units = held.items.iter();
            let units = units.filter_map(|arrival| self.units.unit_of(*arrival));
            held.units = units.collect();
        }
        self.are_units_found = true;
    }

    /// An item was placed in a container.
    pub fn packed(&mut self, container: usize, arrival: usize) {
        let item = self.items.get(&arrival).cloned();
        let (Some(held), Some(item)) = (self.open.get_mut(container), item) else {
            return;
        };
        held.mass_kg += item.mass_kg.unwrap_or(0.0);
        held.orders.insert(Arc::clone(&item.order));
        if let Some(group) = &item.group {
            *held.groups.entry(Arc::clone(group)).or_default() += 1;
        }
        held.items.insert(arrival);
        held.ties.extend(self.units.ties(arrival).cloned());
        held.units.extend(self.units.unit_of(arrival));
        self.units.packed(arrival, &item);
        self.gone(&item);
    }

    /// An item that fits nowhere will not come.
    pub fn dropped(&mut self, arrival: usize) {
        if let Some(item) = self.items.get(&arrival).cloned() {
            self.away.insert(arrival);
            self.are_units_found = false;
            self.gone(&item);
        }
    }

    /// An item lies in a container that was closed before any of these was opened.
    pub fn left_with_its_container(&mut self, arrival: usize) {
        self.closed_ties.extend(self.units.ties(arrival).cloned());
        self.dropped(arrival);
    }

    fn gone(&mut self, item: &OrderItem) {
        if let Some(rest) = self.left.get_mut(&item.order) {
            rest.items = rest.items.saturating_sub(1);
        }
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
        let is_done = |order: &Arc<str>| {
            let rest = self.rest(order);
            rest.items + rest.unannounced == 0
        };
        !held.orders.is_empty() && held.orders.iter().all(is_done)
    }

    /// Why the item of this arrival may not go into an open container, where it may not. Rules that give way come last. To be asked after
    /// the step began.
    pub fn bar(&self, container: usize, arrival: usize) -> Option<Bar> {
        let item = self.items.get(&arrival)?;
        let held = self.open.get(container)?;
        self.other_order(held, item)
            .or_else(|| self.groups_apart(held, item))
            .or_else(|| self.too_heavy(held, item.mass_kg?))
            .or_else(|| self.tied_elsewhere(container, held, arrival))
            .or_else(|| self.with_others(held, arrival))
            .or_else(|| self.kept_for(held, arrival, item))
            .or_else(|| self.elsewhere(held, item))
    }

    fn other_order(&self, held: &Held, item: &OrderItem) -> Option<Bar> {
        let other = held.orders.iter().find(|order| **order != item.order)?;
        let is_barred = self.rules.sharing == Sharing::OneOrder;
        is_barred.then(|| Bar::OtherOrder(Arc::clone(other)))
    }

    fn groups_apart(&self, held: &Held, item: &OrderItem) -> Option<Bar> {
        self.rules.apart(&item.group, &held.groups)
    }

    fn too_heavy(&self, held: &Held, mass_kg: f64) -> Option<Bar> {
        let over_kg = held.mass_kg + mass_kg - self.rules.most_kg?;
        (over_kg > 0.0).then_some(Bar::TooHeavy { over_kg })
    }

    /// Where it must travel with items that lie, or have to go, elsewhere.
    fn tied_elsewhere(&self, container: usize, held: &Held, arrival: usize) -> Option<Bar> {
        let elsewhere = |has: &dyn Fn(&Held) -> bool| {
            let mut open = self.open.iter().enumerate();
            open.any(|(other, held)| other != container && has(held))
        };
        for tie in self.units.ties(arrival) {
            let is_closed = self.closed_ties.contains(tie);
            if is_closed || elsewhere(&|held| held.ties.contains(tie)) {
                let tie = tie.clone();
                return Some(Bar::TiedElsewhere { tie, is_closed });
            }
        }
        let unit = self.units.unit_of(arrival)?;
        let is_begun_here = held.units.contains(&unit);
        if is_begun_here || !elsewhere(&|held| held.units.contains(&unit)) {
            return None;
        }
        let tie = self.units.ties(arrival).next()?;
        Some(Bar::ChainedElsewhere(tie.clone()))
    }

    /// Where it would be the first of items that must travel together, and the container may not take them all.
    fn with_others(&self, held: &Held, arrival: usize) -> Option<Bar> {
        let unit = self.units.unit_of(arrival)?;
        if held.units.contains(&unit) {
            return None;
        }
        let unit = self.units.units.get(unit)?;
        let bar = self
            .other_orders(held, unit)
            .or_else(|| self.rules.apart(unit.groups.keys(), &held.groups))
            .or_else(|| self.apart_within(unit))
            .or_else(|| self.too_heavy(held, unit.mass_kg - SAME_KG))?;
        let tie = self.units.ties(arrival).next()?.clone();
        let bar = Box::new(bar);
        Some(Bar::WithOthers { tie, bar })
    }

    /// One of the orders of items that travel together, where the container is for another one.
    fn other_orders(&self, held: &Held, unit: &Unit) -> Option<Bar> {
        let orders = held.orders.iter().chain(unit.orders.keys());
        let orders: BTreeSet<&Arc<str>> = orders.collect();
        let first = orders.first().filter(|_| orders.len() > 1)?;
        let is_barred = self.rules.sharing == Sharing::OneOrder;
        is_barred.then(|| Bar::OtherOrder(Arc::clone(first)))
    }

    /// Two groups of items that travel together which must not.
    fn apart_within(&self, unit: &Unit) -> Option<Bar> {
        unit.groups.iter().find_map(|(group, count)| {
            let mut others = unit.groups.keys();
            let other = others.find(|other| {
                let is_another = *other != group || *count > 1;
                is_another && self.rules.are_apart(group, other)
            })?;
            Some(Bar::GroupsApart(Arc::clone(group), Arc::clone(other)))
        })
    }

    /// Where the container could not take any more what has to follow others into it. What itself has to follow was counted when those
    /// were begun.
    fn kept_for(&self, held: &Held, arrival: usize, item: &OrderItem) -> Option<Bar> {
        let own = self.units.unit_of(arrival);
        if own.is_some_and(|own| held.units.contains(&own)) {
            return None;
        }
        let own = own.and_then(|own| self.units.units.get(own));
        let kept = held.units.iter();
        let kept = kept.filter_map(|unit| self.units.units.get(*unit));
        let kept: Vec<&Unit> = kept.filter(|unit| !unit.is_done()).collect();
        let apart = kept.iter().find_map(|unit| {
            let bar = match own {
                Some(own) => self.rules.apart(own.groups.keys(), &unit.groups),
                None => self.rules.apart(&item.group, &unit.groups),
            };
            Some((*unit, bar?))
        });
        let (unit, bar) = match apart {
            Some(found) => found,
            None => {
                let first = kept.first()?;
                let kept_kg: f64 = kept.iter().map(|unit| unit.mass_kg).sum();
                let needed_kg = own.map_or(item.mass_kg, |own| Some(own.mass_kg))?;
                let all_kg = kept_kg + needed_kg - SAME_KG;
                (*first, self.too_heavy(held, all_kg)?)
            }
        };
        Some(Bar::KeptFor {
            tie: unit.tie.clone()?,
            bar: Box::new(bar),
        })
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

    /// The open containers that hold something of an order.
    fn homes<'a>(&'a self, order: &'a Arc<str>) -> impl Iterator<Item = usize> + 'a {
        let open = self.open.iter().enumerate();
        open.filter_map(move |(container, held)| held.orders.contains(order).then_some(container))
    }

    fn rest(&self, order: &Arc<str>) -> Rest {
        self.left.get(order).copied().unwrap_or_default()
    }
}
