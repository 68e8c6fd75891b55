//! What has to travel in one container.
//!
//! Items with a tie in common have to travel together, and so have those that are tied to these. What hangs together so is a [`Unit`].

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::sync::Arc;

use super::{ContainerRules, OrderItem};

/// What ties items to each other, so that they travel in one container.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Tie {
    /// Their order, which must not be divided.
    Order(Arc<str>),
    /// Two groups of an order that must travel together.
    Groups {
        /// The order.
        order: Arc<str>,
        /// The groups.
        groups: (String, String),
    },
    /// A bundle that they are of.
    Bundle(Arc<str>),
}

impl fmt::Display for Tie {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Order(order) => {
                write!(formatter, "the items of order {order} must not be divided")
            }
            Self::Groups {
                order,
                groups: (a, b),
            } => write!(
                formatter,
                "the items of {a} and {b} of order {order} must travel together"
            ),
            Self::Bundle(bundle) => {
                write!(
                    formatter,
                    "the items of bundle {bundle} must travel together"
                )
            }
        }
    }
}

impl ContainerRules {
    /// What ties an item to others.
    pub(super) fn ties(&self, item: &OrderItem) -> BTreeSet<Tie> {
        let order = || Arc::clone(&item.order);
        // What is of no order is no order that could be divided.
        let whole = self.undivided && !item.order.is_empty();
        let whole = whole.then(|| Tie::Order(order()));
        let group = item.group.as_deref();
        let pairs = self.together.iter();
        let pairs = pairs.filter(|(a, b)| group.is_some_and(|group| group == a || group == b));
        let pairs = pairs.map(|groups| Tie::Groups {
            order: order(),
            groups: groups.clone(),
        });
        let bundle = item.bundle.clone().map(Tie::Bundle);
        whole.into_iter().chain(pairs).chain(bundle).collect()
    }
}

/// What is still to be packed of items that hang together.
#[derive(Debug, Clone, Default)]
pub(super) struct Unit {
    pub(super) orders: Counts,
    pub(super) groups: Counts,
    pub(super) mass_kg: f64,
    /// One of the ties, to name them all.
    pub(super) tie: Option<Tie>,
}

/// How many there are of each.
pub(super) type Counts = BTreeMap<Arc<str>, usize>;

fn one_less(counts: &mut Counts, of: &Arc<str>) {
    if let Some(count) = counts.get_mut(of) {
        *count -= 1;
        if *count == 0 {
            counts.remove(of);
        }
    }
}

impl Unit {
    fn add(&mut self, item: &OrderItem) {
        *self.orders.entry(Arc::clone(&item.order)).or_default() += 1;
        if let Some(group) = &item.group {
            *self.groups.entry(Arc::clone(group)).or_default() += 1;
        }
        self.mass_kg += item.mass_kg.unwrap_or(0.0);
    }

    /// One of its items was packed.
    pub(super) fn remove(&mut self, item: &OrderItem) {
        one_less(&mut self.orders, &item.order);
        if let Some(group) = &item.group {
            one_less(&mut self.groups, group);
        }
        self.mass_kg = (self.mass_kg - item.mass_kg.unwrap_or(0.0)).max(0.0);
    }

    /// Whether all of it is packed.
    pub(super) fn is_done(&self) -> bool {
        self.orders.is_empty()
    }
}

/// The items that are tied, and what hangs together of them.
#[derive(Debug, Clone, Default)]
pub(super) struct Units {
    ties: BTreeMap<usize, BTreeSet<Tie>>,
    unit_of_tie: BTreeMap<Tie, usize>,
    pub(super) units: Vec<Unit>,
}

impl Units {
    /// The ties of all items.
    pub(super) fn new(rules: &ContainerRules, items: &BTreeMap<usize, OrderItem>) -> Self {
        let tied = items.iter().filter_map(|(arrival, item)| {
            let ties = rules.ties(item);
            (!ties.is_empty()).then_some((*arrival, ties))
        });
        Self {
            ties: tied.collect(),
            ..Self::default()
        }
    }

    /// What ties an item to others.
    pub(super) fn ties(&self, arrival: usize) -> impl Iterator<Item = &Tie> {
        self.ties.get(&arrival).into_iter().flatten()
    }

    /// The unit of an item; `None` of one without ties.
    pub(super) fn unit_of(&self, arrival: usize) -> Option<usize> {
        let tie = self.ties.get(&arrival)?.first()?;
        self.unit_of_tie.get(tie).copied()
    }

    /// One of the items of a unit was packed.
    pub(super) fn packed(&mut self, arrival: usize, item: &OrderItem) {
        let unit = self.unit_of(arrival);
        if let Some(unit) = unit.and_then(|unit| self.units.get_mut(unit)) {
            unit.remove(item);
        }
    }

    /// Finds what hangs together of the tied items but for those that are away; `is_packed` says which lie in an open container.
    pub(super) fn find(
        &mut self,
        items: &BTreeMap<usize, OrderItem>,
        away: &BTreeSet<usize>,
        is_packed: impl Fn(usize) -> bool,
    ) {
        self.unit_of_tie.clear();
        self.units.clear();
        let here = || {
            let tied = self.ties.iter();
            tied.filter(|(arrival, _)| !away.contains(*arrival))
        };
        for (_, ties) in here() {
            let known = ties.iter().filter_map(|tie| self.unit_of_tie.get(tie));
            let known: BTreeSet<usize> = known.copied().collect();
            let unit = known.first().copied().unwrap_or_else(|| {
                self.units.push(Unit {
                    tie: ties.first().cloned(),
                    ..Unit::default()
                });
                self.units.len() - 1
            });
            if known.len() > 1 {
                let joined = self.unit_of_tie.values_mut();
                joined
                    .filter(|of| known.contains(of))
                    .for_each(|of| *of = unit);
            }
            let ties = ties.iter().map(|tie| (tie.clone(), unit));
            self.unit_of_tie.extend(ties);
        }
        for (arrival, ties) in here() {
            let unit = ties.first().and_then(|tie| self.unit_of_tie.get(tie));
            let unit = unit.and_then(|unit| self.units.get_mut(*unit));
            let rest = unit.zip(items.get(arrival));
            if let Some((unit, item)) = rest.filter(|_| !is_packed(*arrival)) {
                unit.add(item);
            }
        }
    }
}
