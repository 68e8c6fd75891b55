//! What an order needs of a container, what containers come to hold, and which of them make room for an order.

use std::sync::Arc;

use super::ties::Unit;
use super::{Bar, Held, OrderItem, Orders, Sharing};
use crate::capacity::Capacity;
use crate::closing::Closing;

impl Orders {
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

    /// What is left of the first order that waits and was begun nowhere, in cubic metres.
    pub fn next_m3(&self) -> Option<f64> {
        let next = self.next.as_ref()?;
        Some(self.rest(next).volume_m3)
    }

    /// The open containers that would be closed for the first order that waits and was begun nowhere, each with why: those whose orders are
    /// complete and that are kept for nothing, where no open container takes all of that order with the certainty that is asked for, but an
    /// empty one would. To be asked after the step began.
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
        let has_room = percents.iter().any(|percent| *percent >= wanted);
        if empty < wanted || has_room || self.has_to_follow(next) {
            return Vec::new();
        }
        let open = self.open.iter().enumerate().zip(percents);
        let done = open.filter(|((_, held), _)| self.is_complete(held) && !self.is_kept(held));
        let closings = done.map(|((container, _), percent)| {
            let closing = Closing::RestOfOrder {
                order: Arc::clone(next),
                rest_m3: self.rest(next).volume_m3,
                percent,
            };
            (container, closing)
        });
        closings.collect()
    }

    /// Whether a container is for another order than this one.
    fn is_for_other(&self, held: &Held, order: &Arc<str>) -> bool {
        self.rules.sharing == Sharing::OneOrder && held.orders.iter().any(|other| other != order)
    }

    /// Whether something has to follow what lies in a container.
    fn is_kept(&self, held: &Held) -> bool {
        let units = held.units.iter();
        let mut units = units.filter_map(|unit| self.units.units.get(*unit));
        units.any(|unit| !unit.is_done())
    }

    /// Whether something of an order has to follow what lies in a container, so that an empty one could not take all of it.
    fn has_to_follow(&self, order: &Arc<str>) -> bool {
        let must_follow = |arrival: usize| {
            let unit = self.units.unit_of(arrival);
            let is_begun = |unit| self.open.iter().any(|held| held.units.contains(&unit));
            let mut ties = self.units.ties(arrival);
            unit.is_some_and(is_begun) || ties.any(|tie| self.closed_ties.contains(tie))
        };
        let items = self.items.iter();
        let mut items =
            items.filter(|(arrival, item)| item.order == *order && !self.away.contains(*arrival));
        items.any(|(arrival, _)| must_follow(*arrival))
    }

    /// Where an item would be the first of its order, and the rest of that would not fit.
    pub(super) fn no_room(&self, held: &Held, item: &OrderItem) -> Option<Bar> {
        if held.orders.is_empty() || held.orders.contains(&item.order) {
            return None;
        }
        self.over(held, &item.order, self.needed_m3(held, &item.order))
    }

    /// Where an item would be the first of what must travel together, and the rest of that would not fit.
    pub(super) fn no_room_for(&self, held: &Held, unit: &Unit, item: &OrderItem) -> Option<Bar> {
        if held.orders.is_empty() {
            return None;
        }
        let further = unit.volumes_m3.iter();
        let further = further.filter(|(order, _)| !held.orders.contains(*order));
        let further = further.map(|(_, volume_m3)| volume_m3);
        let needed_m3 = self.promised_m3(held) + further.sum::<f64>();
        self.over(held, &item.order, needed_m3)
    }

    /// Where so much more, in cubic metres, is not expected to fit into a container that holds something, for an item of an order.
    fn over(&self, held: &Held, order: &Arc<str>, needed_m3: f64) -> Option<Bar> {
        if let Some(wanted) = self.rules.certainty_percent {
            let percent = certainty_percent(&self.capacity()?, held, needed_m3);
            return (percent < wanted).then(|| Bar::OrderUnlikely {
                order: Arc::clone(order),
                rest_m3: self.rest(order).volume_m3,
                percent,
            });
        }
        let over_m3 = held.volume_m3 + needed_m3 - self.rules.expected_m3?;
        (over_m3 > 0.0).then(|| Bar::NoRoomForOrder {
            order: Arc::clone(order),
            over_m3,
        })
    }

    /// With which certainty a container that does not hold anything of an order takes all that is left of it, in percent.
    fn percent(&self, capacity: &Capacity, held: &Held, order: &Arc<str>) -> f64 {
        certainty_percent(capacity, held, self.needed_m3(held, order))
    }

    /// What is to come into a container if an order is begun there: the rest of that, and of those that it holds.
    fn needed_m3(&self, held: &Held, order: &Arc<str>) -> f64 {
        self.promised_m3(held) + self.rest(order).volume_m3
    }

    /// The rest of the orders that a container holds.
    fn promised_m3(&self, held: &Held) -> f64 {
        let promised = held.orders.iter().map(|order| self.rest(order).volume_m3);
        promised.sum()
    }
}

/// With which certainty a container takes so much more, in percent.
fn certainty_percent(capacity: &Capacity, held: &Held, needed_m3: f64) -> f64 {
    100.0 * capacity.certainty(held.volume_m3, needed_m3)
}
