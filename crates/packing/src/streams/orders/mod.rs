//! Orders: which items belong together, and which open containers an item may go into at all.
//!
//! Some rules are never broken; others give way where nothing else could be packed.

mod bar;
mod ties;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

pub use bar::Bar;
pub use ties::Tie;
use ties::{Counts, Unit, Units, count};

use crate::planning::containers::Attempt;
use crate::ranking::step::Candidate;

/// Sums of masses that differ by less than this are the same, in kilograms.
const SAME_KG: f64 = 1e-9;

/// Sharing of containers by orders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sharing {
    /// A container holds items of one order. It is closed when the order is complete.
    OneOrder,
    /// Several orders share a container; each goes into as few as possible.
    #[default]
    Shared,
}

/// Rules of containers.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ContainerRules {
    /// Sharing by orders.
    pub sharing: Sharing,
    /// Whether each order lies in one container. It is begun only where the mass and the groups of
    /// all that is known of it are possible.
    pub undivided: bool,
    /// Pairs of groups that never travel in one container.
    pub apart: Vec<(String, String)>,
    /// Pairs of groups that travel together: an order's items of either lie in one container.
    pub together: Vec<(String, String)>,
    /// The greatest mass of what one holds, in kilograms.
    pub most_kg: Option<f64>,
}

impl ContainerRules {
    /// A pair of groups that would have to travel together and must not, where there is one.
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

    /// Two groups, of one list and of the other, that must not travel together.
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

/// Order, group and mass of an item.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderItem {
    /// Its order.
    pub order: Arc<str>,
    /// Its group, where it is of one.
    pub group: Option<Arc<str>>,
    /// Its mass, in kilograms; unknown ones count nothing.
    pub mass_kg: Option<f64>,
}

impl OrderItem {
    /// An item of an order, of which no more is known.
    pub fn new(order: Arc<str>) -> Self {
        Self {
            order,
            group: None,
            mass_kg: None,
        }
    }
}

#[derive(Debug, Clone)]
struct Line {
    item: OrderItem,
    ties: BTreeSet<Tie>,
    place: Place,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    ToCome,
    /// In the open container with this number, in the order in which they were opened.
    In(usize),
    Closed,
    /// It will not come: nothing waits for it.
    Gone,
}

#[derive(Debug, Clone, Default)]
struct Held {
    orders: BTreeSet<Arc<str>>,
    groups: Counts,
    ties: BTreeSet<Tie>,
    /// Units of which something is in it.
    units: BTreeSet<usize>,
    mass_kg: f64,
}

/// The orders of a stream, and what open containers hold of them. Other items have no rules.
#[derive(Debug, Clone, Default)]
pub struct Orders {
    rules: ContainerRules,
    lines: BTreeMap<usize, Line>,
    /// How many items an order is said to have, where that is said.
    expected: BTreeMap<Arc<str>, usize>,
    open: Vec<usize>,
    opened: usize,
    /// Content of each open container, as the step began.
    held: Vec<Held>,
    /// Ties of the items in closed containers, as the step began.
    closed_ties: BTreeSet<Tie>,
    /// Items that hang together, as the step began.
    units: Units,
    /// The first order in the buffer that no open container holds anything of.
    next: Option<Arc<str>>,
}

impl Orders {
    /// Orders whose items arrive so: by their place in the sequence of arrivals.
    pub fn new(rules: ContainerRules, items: impl IntoIterator<Item = (usize, OrderItem)>) -> Self {
        let lines = items.into_iter().map(|(arrival, item)| {
            let line = Line {
                ties: rules.ties(&item),
                item,
                place: Place::ToCome,
            };
            (arrival, line)
        });
        Self {
            lines: lines.collect(),
            rules,
            ..Self::default()
        }
    }

    /// An order has so many items altogether: it is not complete before as many are known. The
    /// greatest number counts that is said.
    pub fn expect(&mut self, order: &str, items: usize) {
        let expected = self.expected.entry(order.into()).or_default();
        *expected = items.max(*expected);
    }

    /// A container is opened; it stands behind the others.
    pub fn opened(&mut self) {
        self.open.push(self.opened);
        self.opened += 1;
    }

    /// A container is closed. Those behind it move up.
    pub fn closed(&mut self, container: usize) {
        if container < self.open.len() {
            let closed = Place::In(self.open.remove(container));
            let held = self.lines.values_mut().filter(|line| line.place == closed);
            held.for_each(|line| line.place = Place::Closed);
        }
    }

    /// A step begins, with these items in the buffer.
    pub fn begin(&mut self, candidates: &[Candidate]) {
        let here = self.lines.values();
        let here = here.filter(|line| matches!(line.place, Place::ToCome | Place::In(_)));
        self.units = Units::of(here.map(|line| &line.ties));
        self.held = self.open.iter().map(|_| Held::default()).collect();
        self.closed_ties.clear();
        for line in self.lines.values() {
            match line.place {
                Place::ToCome => self.units.add(line),
                Place::In(number) => {
                    let container = self.open.iter().position(|open| *open == number);
                    if let Some(held) = container.and_then(|at| self.held.get_mut(at)) {
                        held.add(line, self.units.number_of(line));
                    }
                }
                Place::Closed => self.closed_ties.extend(line.ties.iter().cloned()),
                Place::Gone => {}
            }
        }
        let waiting = candidates.iter();
        let waiting = waiting.filter_map(|held| self.lines.get(&held.arrival));
        let mut unbegun = waiting.filter(|line| !self.is_begun(&line.item.order));
        let next = unbegun.next();
        self.next = next.map(|line| Arc::clone(&line.item.order));
    }

    fn set_place(&mut self, arrival: usize, place: Place) {
        if let Some(line) = self.lines.get_mut(&arrival) {
            line.place = place;
        }
    }

    /// An item was placed in a container.
    pub fn packed(&mut self, container: usize, arrival: usize) {
        if let Some(number) = self.open.get(container) {
            self.set_place(arrival, Place::In(*number));
        }
    }

    /// An item that fits nowhere will not come.
    pub fn dropped(&mut self, arrival: usize) {
        self.set_place(arrival, Place::Gone);
    }

    /// An item lies in a container that was closed before any of these was opened.
    pub fn left_with_its_container(&mut self, arrival: usize) {
        self.set_place(arrival, Place::Closed);
    }

    /// The first container of one order that is complete: something lies in it, nothing is to come.
    pub fn complete(&self) -> Option<usize> {
        if self.rules.sharing != Sharing::OneOrder {
            return None;
        }
        self.open.iter().position(|number| {
            let lines = self.lines.values();
            let held = lines.filter(|line| line.place == Place::In(*number));
            let orders: BTreeSet<&Arc<str>> = held.map(|line| &line.item.order).collect();
            !orders.is_empty() && orders.into_iter().all(|order| self.is_complete(order))
        })
    }

    fn is_complete(&self, order: &Arc<str>) -> bool {
        let lines = || self.lines.values().filter(|line| line.item.order == *order);
        let expected = self.expected.get(order).copied().unwrap_or(0);
        expected <= lines().count() && lines().all(|line| line.place != Place::ToCome)
    }

    /// Why the item of this arrival may not go into an open container, where it may not. Rules that
    /// give way come last. To be asked after the step began.
    pub fn bar(&self, container: usize, arrival: usize) -> Option<Bar> {
        debug_assert_eq!(self.held.len(), self.open.len(), "no step began");
        let line = self.lines.get(&arrival)?;
        let Some(held) = self.held.get(container) else {
            return Some(Bar::NotOpen(container));
        };
        let item = &line.item;
        self.other_order(held.orders.iter().filter(|order| **order != item.order))
            .or_else(|| self.rules.apart(&item.group, &held.groups))
            .or_else(|| self.too_heavy(held, item.mass_kg?))
            .or_else(|| self.tied_elsewhere(container, held, line))
            .or_else(|| self.with_others(held, line))
            .or_else(|| self.kept_for(held, line))
            .or_else(|| self.elsewhere(held, item))
    }

    /// The attempts of a step: by all rules, then, where any gives way, without those. Whatever has
    /// a valid placement has one in the last: where that finds nothing, nothing can be packed.
    pub fn attempts(&self, containers: &[usize], candidates: &[Candidate]) -> Vec<Attempt> {
        let attempt = |gives_way: bool| -> Attempt {
            let admitted = |container: &usize| {
                let candidates = candidates.iter().enumerate();
                let admitted =
                    candidates.filter(|(_, held)| self.admits(gives_way, *container, held.arrival));
                admitted.map(|(index, _)| index).collect()
            };
            containers.iter().map(admitted).collect()
        };
        let mut attempts = vec![attempt(false), attempt(true)];
        attempts.dedup();
        attempts
    }

    /// Whether a container may take an item by all rules, or by those that never give way.
    pub fn admits(&self, gives_way: bool, container: usize, arrival: usize) -> bool {
        let bar = self.bar(container, arrival);
        bar.is_none_or(|bar| gives_way && bar.gives_way())
    }

    /// The first of other orders, where a container is for one.
    fn other_order<'a>(&self, mut others: impl Iterator<Item = &'a Arc<str>>) -> Option<Bar> {
        let other = others.next()?;
        let is_barred = self.rules.sharing == Sharing::OneOrder;
        is_barred.then(|| Bar::OtherOrder(Arc::clone(other)))
    }

    fn too_heavy(&self, held: &Held, mass_kg: f64) -> Option<Bar> {
        let over_kg = held.mass_kg + mass_kg - self.rules.most_kg?;
        (over_kg > 0.0).then_some(Bar::TooHeavy { over_kg })
    }

    /// Refuses an item that must travel with items that lie, or have to go, elsewhere.
    fn tied_elsewhere(&self, container: usize, held: &Held, line: &Line) -> Option<Bar> {
        let elsewhere = |has: &dyn Fn(&Held) -> bool| {
            let mut open = self.held.iter().enumerate();
            open.any(|(other, held)| other != container && has(held))
        };
        for tie in &line.ties {
            let is_closed = self.closed_ties.contains(tie);
            if is_closed || elsewhere(&|held| held.ties.contains(tie)) {
                let tie = tie.clone();
                return Some(Bar::TiedElsewhere { tie, is_closed });
            }
        }
        let unit = self.units.number_of(line)?;
        let is_begun_here = held.units.contains(&unit);
        if is_begun_here || !elsewhere(&|held| held.units.contains(&unit)) {
            return None;
        }
        Some(Bar::ChainedElsewhere(line.ties.first()?.clone()))
    }

    /// Refuses the first of items that must travel together where they may not all be taken.
    fn with_others(&self, held: &Held, line: &Line) -> Option<Bar> {
        let unit = self.units.unit_of(line, held)?;
        let orders: BTreeSet<&Arc<str>> = held.orders.iter().chain(&unit.orders).collect();
        let are_several = orders.len() > 1;
        let bar = self
            .other_order(orders.into_iter().filter(|_| are_several))
            .or_else(|| self.rules.apart(unit.groups.keys(), &held.groups))
            .or_else(|| self.apart_within(unit))
            .or_else(|| self.too_heavy(held, unit.mass_kg - SAME_KG))?;
        let tie = line.ties.first()?.clone();
        let bar = Box::new(bar);
        Some(Bar::WithOthers { tie, bar })
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

    /// Refuses an item where the container could then no longer take what has to follow others into
    /// it. Followers of its own were counted when those were begun.
    fn kept_for(&self, held: &Held, line: &Line) -> Option<Bar> {
        let own = self.units.number_of(line);
        if own.is_some_and(|own| held.units.contains(&own)) {
            return None;
        }
        let own = self.units.unit_of(line, held);
        let kept = held.units.iter();
        let kept = kept.filter_map(|unit| self.units.units.get(*unit));
        let kept: Vec<&Unit> = kept.filter(|unit| !unit.orders.is_empty()).collect();
        let apart = kept.iter().find_map(|unit| {
            let bar = match own {
                Some(own) => self.rules.apart(own.groups.keys(), &unit.groups),
                None => self.rules.apart(&line.item.group, &unit.groups),
            };
            Some((*unit, bar?))
        });
        let (unit, bar) = match apart {
            Some(found) => found,
            None => {
                let first = kept.first()?;
                let kept_kg: f64 = kept.iter().map(|unit| unit.mass_kg).sum();
                let needed_kg = own.map_or(line.item.mass_kg, |own| Some(own.mass_kg))?;
                let all_kg = kept_kg + needed_kg - SAME_KG;
                (*first, self.too_heavy(held, all_kg)?)
            }
        };
        Some(Bar::KeptFor {
            tie: unit.tie.clone()?,
            bar: Box::new(bar),
        })
    }

    /// Refuses an item whose order lies elsewhere, or comes after one that is to be begun.
    fn elsewhere(&self, held: &Held, item: &OrderItem) -> Option<Bar> {
        if held.orders.contains(&item.order) {
            return None;
        }
        if self.is_begun(&item.order) {
            return Some(Bar::OrderElsewhere(Arc::clone(&item.order)));
        }
        let next = self.next.as_ref().filter(|next| **next != item.order)?;
        let is_barred = self.rules.sharing == Sharing::OneOrder;
        is_barred.then(|| Bar::EarlierOrder(Arc::clone(next)))
    }

    fn is_begun(&self, order: &Arc<str>) -> bool {
        self.held.iter().any(|held| held.orders.contains(order))
    }
}

impl Held {
    fn add(&mut self, Line { item, ties, .. }: &Line, unit: Option<usize>) {
        self.mass_kg += item.mass_kg.unwrap_or(0.0);
        self.orders.insert(Arc::clone(&item.order));
        count(&mut self.groups, item);
        self.ties.extend(ties.iter().cloned());
        self.units.extend(unit);
    }
}
