//! Ties: which items have to travel in one container.
//!
//! Items with a tie in common have to travel together, and so have those that are tied to these.
//! What hangs together so is a [`Unit`].

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::sync::Arc;

use super::{ContainerRules, Held, Line, OrderItem};

/// Tie among items that travel in one container.
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
        }
    }
}

impl ContainerRules {
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
        whole.into_iter().chain(pairs).collect()
    }
}

pub(super) type Counts = BTreeMap<Arc<str>, usize>;

pub(super) fn count(groups: &mut Counts, item: &OrderItem) {
    if let Some(group) = &item.group {
        *groups.entry(Arc::clone(group)).or_default() += 1;
    }
}

/// Unpacked rest of items that hang together.
#[derive(Debug, Clone, Default)]
pub(super) struct Unit {
    pub(super) orders: BTreeSet<Arc<str>>,
    pub(super) groups: Counts,
    pub(super) mass_kg: f64,
    /// One of the ties, to name them all.
    pub(super) tie: Option<Tie>,
}

#[derive(Debug, Clone, Default)]
pub(super) struct Units {
    number_of_tie: BTreeMap<Tie, usize>,
    pub(super) units: Vec<Unit>,
}

impl Units {
    /// Finds what hangs together of items with these ties; nothing of it is counted yet.
    pub(super) fn of<'a>(items: impl Iterator<Item = &'a BTreeSet<Tie>>) -> Self {
        let mut found = Self::default();
        for ties in items.filter(|ties| !ties.is_empty()) {
            let known = ties.iter().filter_map(|tie| found.number_of_tie.get(tie));
            let known: BTreeSet<usize> = known.copied().collect();
            let number = known.first().copied().unwrap_or_else(|| {
                found.units.push(Unit {
                    tie: ties.first().cloned(),
                    ..Unit::default()
                });
                found.units.len() - 1
            });
            if known.len() > 1 {
                let joined = found.number_of_tie.values_mut();
                let joined = joined.filter(|of| known.contains(of));
                joined.for_each(|of| *of = number);
            }
            let ties = ties.iter().map(|tie| (tie.clone(), number));
            found.number_of_tie.extend(ties);
        }
        found
    }

    pub(super) fn number_of(&self, line: &Line) -> Option<usize> {
        self.number_of_tie.get(line.ties.first()?).copied()
    }

    /// The unit of an item, where a container holds nothing of it.
    pub(super) fn unit_of(&self, line: &Line, held: &Held) -> Option<&Unit> {
        let number = self.number_of(line)?;
        self.units
            .get(number)
            .filter(|_| !held.units.contains(&number))
    }

    pub(super) fn add(&mut self, line: &Line) {
        let number = self.number_of(line);
        if let Some(unit) = number.and_then(|number| self.units.get_mut(number)) {
            unit.orders.insert(Arc::clone(&line.item.order));
            count(&mut unit.groups, &line.item);
            unit.mass_kg += line.item.mass_kg.unwrap_or(0.0);
        }
    }
}
