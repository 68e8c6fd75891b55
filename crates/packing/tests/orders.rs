//! Orders: what may go into which of the open containers.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

mod support;

use std::collections::BTreeSet;
use std::sync::Arc;

use ppnpack_packing::candidate::Candidate;
use ppnpack_packing::closing::{Closing, ClosingRules};
use ppnpack_packing::containers::ContainerChoice;
use ppnpack_packing::episode::IdealCell;
use ppnpack_packing::orders::{Bar, ContainerRules, OrderItem, Orders, Sharing};
use ppnpack_packing::stream::{Filled, Stream, StreamPlay, play_stream};
use proptest::prelude::*;
use support::ideal::Ideal;

const GROUPS: [&str; 3] = ["food", "chemicals", "toys"];

/// What is known of an item, with little to choose from: its order, its group, its mass.
fn order_items() -> impl Strategy<Value = OrderItem> {
    let group = prop_oneof![
        Just(None),
        proptest::sample::select(&GROUPS[..]).prop_map(Some)
    ];
    let mass = prop_oneof![Just(None), (0.0..3.0).prop_map(Some)];
    (0..4_u8, group, mass).prop_map(|(order, group, mass_kg)| OrderItem {
        group: group.map(Arc::from),
        mass_kg,
        ..OrderItem::new(order.to_string().into())
    })
}

fn rules() -> impl Strategy<Value = ContainerRules> {
    let sharing = prop_oneof![Just(Sharing::OneOrder), Just(Sharing::Shared)];
    let group = || proptest::sample::select(&GROUPS[..]).prop_map(str::to_owned);
    let apart = proptest::collection::vec((group(), group()), 0..3);
    let most_kg = prop_oneof![Just(None), (2.0..8.0).prop_map(Some)];
    (sharing, apart, most_kg).prop_map(|(sharing, apart, most_kg)| ContainerRules {
        sharing,
        apart,
        most_kg,
        ..ContainerRules::default()
    })
}

fn is_apart(rules: &ContainerRules, a: &OrderItem, b: &OrderItem) -> bool {
    let (Some(a), Some(b)) = (&a.group, &b.group) else {
        return false;
    };
    let mut pairs = rules.apart.iter();
    pairs.any(|(one, other)| (**one == **a && **other == **b) || (**one == **b && **other == **a))
}

fn mass_kg<'a>(items: impl IntoIterator<Item = &'a OrderItem>) -> f64 {
    let masses = items.into_iter().filter_map(|item| item.mass_kg);
    masses.sum()
}

/// Whether a rule is broken by what a container holds.
fn breaks(rules: &ContainerRules, held: &[&OrderItem]) -> Option<&'static str> {
    let orders: BTreeSet<&str> = held.iter().map(|item| &*item.order).collect();
    let mut pairs = held.iter().flat_map(|a| held.iter().map(move |b| (a, b)));
    let is_heavy = |most_kg: f64| mass_kg(held.iter().copied()) > most_kg + 1e-9;
    if rules.sharing == Sharing::OneOrder && orders.len() > 1 {
        Some("one order")
    } else if pairs.any(|(a, b)| !std::ptr::eq(*a, *b) && is_apart(rules, a, b)) {
        Some("groups apart")
    } else if rules.most_kg.is_some_and(is_heavy) {
        Some("mass")
    } else {
        None
    }
}

/// Whether this reason is true of an item and a container, given all that the open containers hold and what waits.
fn is_true(
    bar: &Bar,
    rules: &ContainerRules,
    open: &[Vec<&OrderItem>],
    container: usize,
    item: &OrderItem,
    waiting: &[&OrderItem],
) -> bool {
    let held = &open[container];
    let has = |held: &[&OrderItem], order: &str| held.iter().any(|item| *item.order == *order);
    match bar {
        Bar::OtherOrder(other) => {
            rules.sharing == Sharing::OneOrder && has(held, other) && *other != item.order
        }
        Bar::GroupsApart(_, _) => held.iter().any(|other| is_apart(rules, item, other)),
        Bar::TooHeavy { over_kg } => {
            let all_kg = mass_kg(held.iter().copied()) + item.mass_kg.unwrap();
            (all_kg - rules.most_kg.unwrap() - over_kg).abs() < 1e-9 && *over_kg > 0.0
        }
        Bar::OrderElsewhere(order) => {
            *order == item.order && !has(held, order) && open.iter().any(|other| has(other, order))
        }
        Bar::EarlierOrder(order) => {
            let first = waiting
                .iter()
                .find(|held| !open.iter().any(|other| has(other, &held.order)));
            rules.sharing == Sharing::OneOrder
                && first.is_some_and(|first| first.order == *order)
                && *order != item.order
        }
        _ => false,
    }
}

/// Blocks that arrive, with their orders.
fn arrivals(items: &[OrderItem]) -> (Vec<Candidate>, Vec<(usize, OrderItem)>) {
    let blocks = support::blocks::blocks(items.len());
    (blocks, items.iter().cloned().enumerate().collect())
}

fn pack(rules: &ContainerRules, items: &[OrderItem], open: usize) -> Stream<IdealCell> {
    let grid = support::blocks::grid();
    let (blocks, order_items) = arrivals(items);
    let orders = Orders::new(rules.clone(), order_items);
    let how = StreamPlay {
        open,
        buffer: 3,
        choice: ContainerChoice::Fullest,
        closing: ClosingRules {
            order_complete: rules.sharing == Sharing::OneOrder,
            ..ClosingRules::default()
        },
    };
    play_stream(&grid, &mut Ideal, blocks, orders, how).unwrap()
}

fn all(stream: &Stream<IdealCell>) -> impl Iterator<Item = &Filled<IdealCell>> {
    stream.closed.iter().chain(&stream.open)
}

fn held<'a>(items: &'a [OrderItem], filled: &Filled<IdealCell>) -> Vec<&'a OrderItem> {
    let steps = filled.steps.iter();
    steps.map(|step| &items[step.candidate.arrival]).collect()
}

fn orders_in<'a>(
    items: &'a [OrderItem],
    filled: &Filled<IdealCell>,
) -> impl Iterator<Item = &'a str> {
    held(items, filled).into_iter().map(|item| &*item.order)
}

proptest! {
    #[test]
    fn what_is_barred_would_break_the_rule_that_is_named_and_nothing_else_is(
        rules in rules(),
        items in proptest::collection::vec(order_items(), 1..12),
        open in 1_usize..4,
        moves in proptest::collection::vec((any::<bool>(), 0..4_usize), 0..24),
    ) {
        let (blocks, order_items) = arrivals(&items);
        let mut orders = Orders::new(rules.clone(), order_items);
        let mut held: Vec<Vec<&OrderItem>> = vec![Vec::new(); open];
        for _ in 0..open {
            orders.opened();
        }
        let mut arrival = 0;
        for (is_closed, container) in moves {
            let container = container % open;
            let waiting = &blocks[arrival..];
            let to_come: Vec<&OrderItem> = items[arrival..].iter().collect();
            orders.begin(waiting);
            for at in 0..open {
                for candidate in waiting {
                    let item = &items[candidate.arrival];
                    let with: Vec<&OrderItem> = held[at].iter().copied().chain([item]).collect();
                    match orders.bar(at, candidate.arrival) {
                        Some(bar) => {
                            let is_true = is_true(&bar, &rules, &held, at, item, &to_come);
                            prop_assert!(is_true, "{bar} of {item:?} in {:?}", held[at]);
                        }
                        // What is there may break a rule already: the moves here ask nobody.
                        None if breaks(&rules, &held[at]).is_none() => {
                            prop_assert_eq!(breaks(&rules, &with), None);
                        }
                        None => {}
                    }
                }
            }
            if is_closed {
                orders.closed(container);
                orders.opened();
                held.remove(container);
                held.push(Vec::new());
            } else if arrival < items.len() {
                orders.packed(container, arrival);
                held[container].push(&items[arrival]);
                arrival += 1;
            }
        }
    }

    #[test]
    fn no_container_of_a_stream_breaks_a_rule_and_every_item_is_somewhere(
        rules in rules(),
        items in proptest::collection::vec(order_items(), 1..16),
        open in 1_usize..4,
    ) {
        let stream = pack(&rules, &items, open);
        for filled in all(&stream) {
            prop_assert_eq!(breaks(&rules, &held(&items, filled)), None);
        }
        let placed: usize = all(&stream).map(|filled| filled.steps.len()).sum();
        prop_assert_eq!(placed + stream.unplaceable.len(), items.len());
        for dropped in &stream.unplaceable {
            let item = &items[dropped.arrival];
            prop_assert!(breaks(&rules, &[item]).is_some(), "{item:?} fits into an empty container");
        }
        for closed in stream.closed.iter().filter(|closed| closed.closing == Some(Closing::OrderComplete)) {
            let order = &held(&items, closed)[0].order;
            let later = all(&stream).filter(|filled| filled.number > closed.number);
            let mut later = later.flat_map(|filled| held(&items, filled));
            let is_alone = !stream.closed.iter().any(|other| {
                other.number != closed.number && held(&items, other).iter().any(|item| item.order == *order)
            });
            prop_assert!(!is_alone || later.all(|item| item.order != *order));
        }
    }
}

fn item(order: &str) -> OrderItem {
    OrderItem::new(order.into())
}

#[test]
fn with_one_order_a_container_orders_follow_one_another_and_each_closes_its_own() {
    let items = ["a", "b", "a", "b", "a"].map(item);
    let rules = ContainerRules {
        sharing: Sharing::OneOrder,
        ..ContainerRules::default()
    };
    let stream = pack(&rules, &items, 1);
    let orders: Vec<Vec<&str>> = stream
        .closed
        .iter()
        .map(|filled| orders_in(&items, filled).collect())
        .collect();
    assert_eq!(orders, [vec!["a"; 3], vec!["b"; 2]]);
    assert!(
        stream
            .closed
            .iter()
            .all(|filled| filled.closing == Some(Closing::OrderComplete))
    );
}

#[test]
fn groups_that_must_not_travel_together_close_a_container() {
    let mut items = ["a", "a"].map(item);
    items[0].group = Some("food".into());
    items[1].group = Some("chemicals".into());
    let rules = ContainerRules {
        apart: vec![("chemicals".to_owned(), "food".to_owned())],
        ..ContainerRules::default()
    };
    let stream = pack(&rules, &items, 1);
    assert_eq!((stream.closed.len(), stream.open[0].steps.len()), (1, 1));
    let bar = {
        let mut orders = Orders::new(rules, items.into_iter().enumerate());
        orders.opened();
        orders.packed(0, 0);
        orders.bar(0, 1).unwrap()
    };
    assert_eq!(bar.to_string(), "chemicals must not travel with food");
    assert!(!bar.gives_way());
}
