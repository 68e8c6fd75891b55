//! Rules of the cell by which a container may take an item at all.

use std::collections::BTreeSet;
use std::sync::Arc;

use ppnpack_packing::streams::orders::{ContainerRules, OrderItem, Orders, Sharing};
use ppnpack_protocol::session::Session;
use ppnpack_protocol::session::item::arrival;
use ppnpack_wire::v1::{self, ItemState};

use crate::shapes::ItemShapes;

/// Gives the orders of a session, and what these open containers hold of them; `None` where there
/// are no rules to keep.
pub(crate) fn orders(
    rules: &ContainerRules,
    session: &Session,
    shapes: &mut ItemShapes,
    open: &[String],
) -> Option<Orders> {
    let items = session.items().iter();
    let items = items.filter(|item| has_rules(rules, item));
    let items: Vec<&v1::SessionItem> = items.collect();
    if items.is_empty() {
        return None;
    }
    let known = items.iter().map(|item| {
        let mass_kg = shapes.mass_kg(item);
        (arrival(item), order_item(rules.sharing, item, mass_kg))
    });
    let known: Vec<(usize, OrderItem)> = known.collect();
    let mut orders = Orders::new(rules.clone(), known);
    let mut lying = BTreeSet::new();
    for (container, name) in open.iter().enumerate() {
        orders.opened();
        for item in session.packed_in(name) {
            orders.packed(container, arrival(item));
            lying.insert(arrival(item));
        }
    }
    for item in items.iter().filter(|item| !lying.contains(&arrival(item))) {
        match item.state() {
            ItemState::Packed => orders.left_with_its_container(arrival(item)),
            ItemState::Gone | ItemState::Withdrawn => orders.dropped(arrival(item)),
            _ => {}
        }
    }
    let lines = items.iter().filter_map(|item| item.order_line.as_deref());
    for line in lines.filter(|line| line.order_items > 0) {
        let items = usize::try_from(line.order_items).unwrap_or(usize::MAX);
        orders.expect(&line.order, items);
    }
    Some(orders)
}

fn order_item(sharing: Sharing, item: &v1::SessionItem, mass_kg: Option<f64>) -> OrderItem {
    let line = item.order_line.as_deref();
    let order = line.map_or("", |line| line.order.as_str());
    let group = line.map_or("", |line| line.group.as_str());
    // Items without an order belong together where each container is for one order, and to nothing
    // where containers are shared. No order has a name with a blank.
    let order: Arc<str> = match sharing {
        Sharing::Shared if order.is_empty() => format!("of item {}", item.item_id).into(),
        _ => order.into(),
    };
    OrderItem {
        group: (!group.is_empty()).then(|| group.into()),
        mass_kg,
        ..OrderItem::new(order)
    }
}

/// Says whether a rule can apply to an item.
fn has_rules(rules: &ContainerRules, item: &v1::SessionItem) -> bool {
    let is_of_all = rules.most_kg.is_some() || rules.sharing == Sharing::OneOrder;
    is_of_all || item.order_line.is_some()
}
