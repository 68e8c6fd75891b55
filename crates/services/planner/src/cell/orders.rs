//! Which container may take an item at all, by the rules of the cell.

use std::collections::BTreeSet;
use std::sync::Arc;

use ppnpack_packing::orders::{ContainerRules, OrderItem, Orders, Sharing};
use ppnpack_protocol::session::{ItemState, OrderLine, SessionItem};

use super::CellPlanner;

impl CellPlanner {
    /// The orders of the session, and what these open containers hold of them; `None` where there are no rules to keep.
    pub(super) fn orders(&mut self, open: &[String]) -> Option<Orders> {
        let rules = self.settings.rules.clone();
        let items = self.session.items().iter();
        let items = items.filter(|item| has_rules(&rules, item));
        let items: Vec<SessionItem> = items.cloned().collect();
        if items.is_empty() {
            return None;
        }
        let known = items.iter().map(|item| {
            let order_item = self.order_item(rules.sharing, item);
            (item.arrival, order_item)
        });
        let known: Vec<(usize, OrderItem)> = known.collect();
        let mut orders = Orders::new(rules, known);
        let mut lying = BTreeSet::new();
        for (container, name) in open.iter().enumerate() {
            orders.opened();
            for item in self.session.packed_in(name) {
                orders.packed(container, item.arrival);
                lying.insert(item.arrival);
            }
        }
        for item in items.iter().filter(|item| !lying.contains(&item.arrival)) {
            match item.state {
                ItemState::Packed { .. } => orders.left_with_its_container(item.arrival),
                ItemState::Gone | ItemState::Withdrawn => orders.dropped(item.arrival),
                ItemState::Waiting | ItemState::Decided | ItemState::SetAside { .. } => {}
            }
        }
        for item in &items {
            let OrderLine {
                order, order_items, ..
            } = &item.order_line;
            if let Some((order, items)) = order.as_ref().zip(*order_items) {
                orders.expect(order, usize::try_from(items).unwrap_or(usize::MAX));
            }
        }
        Some(orders)
    }

    fn order_item(&mut self, sharing: Sharing, item: &SessionItem) -> OrderItem {
        let OrderLine {
            order,
            group,
            bundle,
            urgency,
            ..
        } = &item.order_line;
        // What is of no order belongs together where each container is for one, and to nothing where they are shared. No order has a
        // name with a blank.
        let none = || match sharing {
            Sharing::OneOrder => Arc::from(""),
            Sharing::Shared => Arc::from(format!("of item {}", item.item_id)),
        };
        OrderItem {
            order: order.as_deref().map_or_else(none, Arc::from),
            group: group.as_deref().map(Arc::from),
            bundle: bundle.as_deref().map(Arc::from),
            mass_kg: self.mass_kg(item),
            urgency: *urgency,
        }
    }
}

/// Whether a rule can say anything of an item.
fn has_rules(rules: &ContainerRules, item: &SessionItem) -> bool {
    let is_of_all = rules.most_kg.is_some() || rules.sharing == Sharing::OneOrder;
    is_of_all || item.order_line != OrderLine::default()
}
