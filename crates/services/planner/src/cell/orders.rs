//! Which container may take an item at all, by the rules of the cell.

use std::collections::BTreeSet;
use std::sync::Arc;

use ppnpack_packing::orders::{ContainerRules, OrderItem, Orders, Sharing};
use ppnpack_protocol::session::{ItemState, SessionItem};
use ppnpack_wire::v1;

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
            let v1::OrderLine {
                order, order_items, ..
            } = &item.order_line;
            if *order_items > 0 {
                orders.expect(order, usize::try_from(*order_items).unwrap_or(usize::MAX));
            }
        }
        Some(orders)
    }

    fn order_item(&mut self, sharing: Sharing, item: &SessionItem) -> OrderItem {
        let v1::OrderLine { order, group, .. } = &item.order_line;
        // What is of no order belongs together where each container is for one, and to nothing where they are shared. No order has a
        // name with a blank.
        let order: Arc<str> = match sharing {
            Sharing::Shared if order.is_empty() => format!("of item {}", item.item_id).into(),
            _ => order.as_str().into(),
        };
        OrderItem {
            group: (!group.is_empty()).then(|| group.as_str().into()),
            mass_kg: self.mass_kg(item),
            ..OrderItem::new(order)
        }
    }
}

/// Whether a rule can say anything of an item.
fn has_rules(rules: &ContainerRules, item: &SessionItem) -> bool {
    let is_of_all = rules.most_kg.is_some() || rules.sharing == Sharing::OneOrder;
    is_of_all || item.order_line != v1::OrderLine::default()
}
