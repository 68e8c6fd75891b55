//! When containers are closed: by rules that are recomputed here from all that happened.
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
use ppnpack_packing::capacity::{Capacity, LEAST_LEARNED};
use ppnpack_packing::closing::{Closing, ClosingError, ClosingRules, Fill};
use ppnpack_packing::containers::ContainerChoice;
use ppnpack_packing::episode::{IdealCell, PackingCell};
use ppnpack_packing::grid::{ContainerSize, Grid, Resolution, Yaws};
use ppnpack_packing::item::{Item, ViewSurfaces};
use ppnpack_packing::objective::Heuristic;
use ppnpack_packing::orders::{Bar, ContainerRules, OrderItem, Orders, Sharing};
use ppnpack_packing::plan::StepInput;
use ppnpack_packing::sizes::size_to_open;
use ppnpack_packing::stream::{Filled, StreamPlay, play_stream};
use proptest::prelude::*;
use support::ideal::{Ideal, planner};

/// The share of standard normal variables that are greater: the sum of narrow strips under the curve.
fn survival(deviations: f64) -> f64 {
    const STRIP: f64 = 1e-3;
    let strips = ((12.0 - deviations) / STRIP) as usize;
    let density = |x: f64| (-0.5 * x * x).exp() / (2.0 * std::f64::consts::PI).sqrt();
    let strips = (0..strips).map(|strip| density(deviations + (strip as f64 + 0.5) * STRIP));
    strips.sum::<f64>() * STRIP
}

/// A container as the slow stream knows it.
struct Slow {
    number: usize,
    cell: IdealCell,
    packed: Vec<usize>,
    items_m3: f64,
    /// The arrivals of all items that were looked at in vain since the last was packed, as often as they were.
    looked_at: Vec<usize>,
}

impl Slow {
    fn new(number: usize, grid: &Grid) -> Self {
        Self {
            number,
            cell: IdealCell::new(grid),
            packed: Vec::new(),
            items_m3: 0.0,
            looked_at: Vec::new(),
        }
    }

    fn percent(&self, grid: &Grid) -> f64 {
        let size = grid.container();
        100.0 * self.items_m3 / (size.x_m * size.y_m * size.z_m)
    }
}

/// Which containers were closed, with what, and why; and those that were open at the end.
type Told = Vec<(usize, Vec<usize>, Option<Closing>)>;

/// Packs a stream without orders, and looks at everything anew in each step.
fn slowly(grid: &Grid, items: Vec<Candidate>, how: StreamPlay) -> Told {
    let rules = how.closing;
    let least = rules.least_fill_percent.unwrap_or(0.0);
    let (mut waiting, mut told) = (items, Told::new());
    let mut open: Vec<Slow> = (0..how.open)
        .map(|number| Slow::new(number, grid))
        .collect();
    let mut opened = how.open;
    while !waiting.is_empty() {
        let buffer: Vec<Candidate> = waiting.iter().take(how.buffer).cloned().collect();
        let mut order: Vec<usize> = (0..open.len()).collect();
        order.sort_by(|a, b| open[*b].items_m3.total_cmp(&open[*a].items_m3));
        let mut is_placed = false;
        for at in order {
            let slow = &mut open[at];
            let scene = slow.cell.scan().unwrap();
            let mut planner = planner(grid, Heuristic::Sdfm);
            let plan = planner
                .plan(&StepInput::new(grid, &scene, &buffer))
                .unwrap();
            let Some(choice) = plan.choice() else {
                slow.looked_at
                    .extend(buffer.iter().map(|held| held.arrival));
                continue;
            };
            let held = &buffer[choice.candidate];
            let evidence = plan.evidence().cloned().unwrap_or_default();
            slow.cell.place(held, &choice.resting, &evidence).unwrap();
            slow.packed.push(held.arrival);
            slow.items_m3 += held.item.mesh_volume_m3();
            slow.looked_at.clear();
            waiting.retain(|other| other.arrival != held.arrival);
            is_placed = true;
            break;
        }
        let mut closed = Vec::new();
        if !is_placed && open.iter().any(|slow| slow.packed.is_empty()) {
            waiting.remove(0);
        } else if !is_placed {
            let enough = open.iter().any(|slow| slow.percent(grid) >= least);
            let may_leave =
                (0..open.len()).filter(|at| !enough || open[*at].percent(grid) >= least);
            let fullest = may_leave.min_by(|a, b| open[*b].items_m3.total_cmp(&open[*a].items_m3));
            let slow = open.remove(fullest.unwrap());
            closed.push((slow.number, slow.packed, Some(Closing::NothingFits)));
        }
        open.retain_mut(|slow| {
            let percent = slow.percent(grid);
            let looked_at: BTreeSet<usize> = slow.looked_at.iter().copied().collect();
            let is_missed = rules
                .none_of_last
                .is_some_and(|count| looked_at.len() >= count);
            let why =
                if let Some(full_at) = rules.fill_percent.filter(|full_at| percent >= *full_at) {
                    Closing::Full { percent, full_at }
                } else if is_missed && !slow.packed.is_empty() && percent >= least {
                    Closing::NoneOfLast(rules.none_of_last.unwrap())
                } else {
                    return true;
                };
            closed.push((slow.number, std::mem::take(&mut slow.packed), Some(why)));
            false
        });
        for _ in &closed {
            open.push(Slow::new(opened, grid));
            opened += 1;
        }
        told.extend(closed);
    }
    told.extend(
        open.into_iter()
            .map(|slow| (slow.number, slow.packed, None)),
    );
    told
}

fn told(filled: &Filled<IdealCell>) -> (usize, Vec<usize>, Option<Closing>) {
    let packed = filled.steps.iter().map(|step| step.candidate.arrival);
    (filled.number, packed.collect(), filled.closing.clone())
}

/// A grid and items with volumes, in percent of its container.
fn streams() -> impl Strategy<Value = (Grid, Vec<Arc<Item>>)> {
    support::grids().prop_flat_map(|grid| {
        let items = support::items(grid.resolution().yaws().count());
        let items = proptest::collection::vec((items, 1.0..20.0_f64), 6..20);
        let size = grid.container();
        let one_percent_m3 = size.x_m * size.y_m * size.z_m / 100.0;
        let items = items.prop_map(move |items| {
            let items = items.into_iter().map(|(item, percent)| {
                let views = item.views().iter().map(|view| view.surfaces().clone());
                let volume_m3 = percent * one_percent_m3;
                Arc::new(Item::new("item", views.collect(), volume_m3).unwrap())
            });
            items.collect()
        });
        (Just(grid), items)
    })
}

/// A container of so many centimetres, in cells of one and heights of 2 mm.
fn sized(x: usize, y: usize, z: usize) -> Grid {
    let resolution = Resolution::new(0.01, 0.002, Yaws::half_turn(1).unwrap());
    let container = ContainerSize {
        x_m: x as f64 * 0.01,
        y_m: y as f64 * 0.01,
        z_m: z as f64 * 0.01,
    };
    Grid::new(container, resolution.unwrap()).unwrap()
}

fn block(nx: usize, ny: usize, height: u16) -> Arc<Item> {
    let cells = nx * ny;
    let view = ViewSurfaces::of_cells(nx, ny, vec![height as _; cells], vec![0; cells]);
    Arc::new(Item::new("block", vec![view], 0.0).unwrap())
}

fn closing_rules() -> impl Strategy<Value = ClosingRules> {
    let least = proptest::option::of(1.0..40.0_f64);
    let full = proptest::option::of(40.0..100.0_f64);
    let count = proptest::option::of(1..6_usize);
    (least, full, count).prop_map(
        |(least_fill_percent, fill_percent, none_of_last)| ClosingRules {
            least_fill_percent,
            fill_percent,
            none_of_last,
            ..ClosingRules::default()
        },
    )
}

proptest! {
    #[test]
    fn containers_are_closed_as_all_that_happened_says(
        (grid, items) in streams(),
        closing in closing_rules(),
        open in 1_usize..4,
        buffer in 1_usize..4,
    ) {
        let how = StreamPlay { open, buffer, choice: ContainerChoice::Fullest, closing, expected_percent: 40.0 };
        let mut supply = Ideal;
        let arriving = Candidate::sequence(items);
        let stream = play_stream(std::slice::from_ref(&grid), &mut supply, arriving.clone(), Orders::default(), how).unwrap();
        let found: Told = stream.closed.iter().chain(&stream.open).map(told).collect();
        prop_assert_eq!(found, slowly(&grid, arriving, how));
    }

    #[test]
    fn the_size_to_open_is_the_smallest_of_those_that_take_all(
        sides in proptest::collection::vec((4_usize..9, 4_usize..9, 4_usize..9), 1..5),
        items in proptest::collection::vec((1_usize..12, 1_usize..12, 1_u16..60), 0..5),
        waiting_litres in 0.0..1.0_f64,
    ) {
        let sizes: Vec<Grid> = sides.iter().map(|(x, y, z)| sized(*x, *y, *z)).collect();
        let waiting: Vec<Arc<Item>> = items.iter().map(|(nx, ny, height)| block(*nx, *ny, *height)).collect();
        let waiting = Candidate::sequence(waiting);
        let found = size_to_open(&sizes, &waiting, waiting_litres * 1e-3, 50.0).unwrap();
        // In centimetres, of which a height has five units.
        let litres = |at: usize| (sides[at].0 * sides[at].1 * sides[at].2) as f64 * 1e-3;
        let takes = |at: usize, (nx, ny, height): (usize, usize, u16)| {
            nx <= sides[at].0 && ny <= sides[at].1 && usize::from(height) <= 5 * sides[at].2
        };
        let counted: Vec<_> = items.iter().filter(|item| (0..sizes.len()).any(|at| takes(at, **item))).collect();
        let able: Vec<usize> = (0..sizes.len()).filter(|at| counted.iter().all(|item| takes(*at, **item))).collect();
        let enough: Vec<usize> = able.iter().copied().filter(|at| litres(*at) * 0.5 >= waiting_litres).collect();
        if !enough.is_empty() {
            prop_assert!(enough.contains(&found));
            prop_assert!(enough.iter().all(|at| litres(*at) >= litres(found)));
        } else {
            let among = if able.is_empty() { (0..sizes.len()).collect() } else { able };
            prop_assert!(among.contains(&found));
            prop_assert!(among.iter().all(|at| litres(*at) <= litres(found)));
        }
    }

    #[test]
    fn the_certainty_is_the_share_of_containers_that_hold_that_much(
        mean in 1.0..10.0_f64,
        spread in 0.1..3.0_f64,
        held in 0.0..12.0_f64,
        further in 0.0..4.0_f64,
    ) {
        let capacity = Capacity { mean_m3: mean, spread_m3: spread };
        let deviations = |volume: f64| (volume - mean) / spread;
        prop_assume!(deviations(held) < 5.0);
        let expected = survival(deviations(held + further)) / survival(deviations(held));
        let found = capacity.certainty(held, further);
        prop_assert!((found - expected).abs() < 1e-4, "{found} {expected}");
        prop_assert!(capacity.certainty(held, further + 0.1) <= found);
    }
}

#[test]
fn a_stream_opens_the_size_that_its_next_order_needs() {
    let sizes = [sized(6, 6, 6), sized(9, 9, 9)];
    // 0.2 litres of order a, then 0.05 of order b; half of the small containers are 0.108 litres.
    let volumes = [("a", 1e-4), ("a", 1e-4), ("b", 5e-5)];
    let items = volumes.map(|(order, volume_m3)| item(order, volume_m3));
    let rules = ContainerRules {
        sharing: Sharing::OneOrder,
        ..ContainerRules::default()
    };
    let orders = Orders::new(rules, items.into_iter().enumerate());
    let how = StreamPlay {
        open: 1,
        buffer: 3,
        choice: ContainerChoice::Fullest,
        closing: ClosingRules {
            order_complete: true,
            ..ClosingRules::default()
        },
        expected_percent: 50.0,
    };
    let blocks = Candidate::sequence((0..3).map(|_| block(3, 3, 5)));
    let stream = play_stream(&sizes, &mut Ideal, blocks, orders, how).unwrap();
    let opened = stream.closed.iter().map(|filled| filled.grid.nx());
    assert_eq!(opened.collect::<Vec<usize>>(), [9, 6]);
    assert!(
        stream
            .closed
            .iter()
            .all(|filled| filled.closing == Some(Closing::OrderComplete))
    );
}

#[test]
fn the_certainty_is_known_far_above_what_containers_hold() {
    let capacity = Capacity {
        mean_m3: 1.0,
        spread_m3: 0.01,
    };
    assert_eq!(capacity.certainty(2.0, 0.0), 1.0);
    let certainty = capacity.certainty(2.0, 0.000_1);
    assert!((0.3..0.4).contains(&certainty), "{certainty}");
    let exact = Capacity {
        spread_m3: 0.0,
        ..capacity
    };
    assert_eq!(exact.certainty(0.5, 0.5), 1.0);
    assert_eq!(exact.certainty(0.5, 0.6), 0.0);
}

#[test]
fn what_containers_hold_is_learned_from_enough_of_them() {
    let held_m3 = [1.0, 2.0, 3.0, 4.0, 5.0];
    assert_eq!(Capacity::learned(&held_m3[..LEAST_LEARNED - 1]), None);
    let learned = Capacity::learned(&held_m3).unwrap();
    assert_eq!((learned.mean_m3, learned.spread_m3), (3.0, 2.5_f64.sqrt()));
    assert!(Capacity::learned(&[1.0; 5]).unwrap().spread_m3 > 0.0);
}

fn item(order: &str, volume_m3: f64) -> OrderItem {
    OrderItem::new(order.into(), volume_m3)
}

/// One order of 4 lies in the first container of several; the next one is of 5 and waits.
fn before_the_next(certainty_percent: f64, open: usize) -> Orders {
    let items = [item("a", 4.0), item("b", 2.0), item("b", 3.0)];
    first_packed(certainty_percent, open, items.to_vec())
}

/// The first of these items lies in the first container of several, and the others wait.
fn first_packed(certainty_percent: f64, open: usize, items: Vec<OrderItem>) -> Orders {
    let rules = ContainerRules {
        expected_m3: Some(8.0),
        spread_m3: Some(1.0),
        certainty_percent: Some(certainty_percent),
        ..ContainerRules::default()
    };
    let count = items.len();
    let mut orders = Orders::new(rules, items.into_iter().enumerate());
    for _ in 0..open {
        orders.opened();
    }
    orders.begin_with(0..1);
    orders.packed(0, 0);
    orders.begin_with(1..count);
    orders
}

fn bundled(order: &str, volume_m3: f64) -> OrderItem {
    OrderItem {
        bundle: Some("gift".into()),
        ..item(order, volume_m3)
    }
}

#[test]
fn a_container_is_closed_where_the_next_order_fits_into_none_that_is_open() {
    let closed = before_the_next(50.0, 1).closed_for_next();
    assert_eq!(closed.len(), 1);
    // One standard deviation above the mean: 16 of 100 containers hold that.
    let text = closed[0].1.to_string();
    assert_eq!(
        text,
        "the rest of order b (5.0000 m³) fits with 16 % certainty"
    );
    assert_eq!(before_the_next(10.0, 1).closed_for_next(), []);
    // There is another place for it.
    assert_eq!(before_the_next(50.0, 2).closed_for_next(), []);
    // It would not fit into an empty one with that certainty either: 5 are three deviations below the mean, 99.87 %.
    assert_eq!(before_the_next(99.89, 1).closed_for_next(), []);
    assert_eq!(before_the_next(99.8, 1).closed_for_next().len(), 1);
}

#[test]
fn an_order_begins_where_it_is_certain_enough_to_fit() {
    let bar = before_the_next(50.0, 2).bar(0, 1).unwrap();
    assert!(matches!(bar, Bar::OrderUnlikely { .. }), "{bar}");
    assert!(bar.gives_way());
    assert_eq!(before_the_next(50.0, 2).bar(1, 1), None);
    assert_eq!(before_the_next(10.0, 2).bar(0, 1), None);
}

#[test]
fn what_is_learned_takes_the_place_of_what_was_expected() {
    let mut orders = before_the_next(50.0, 1);
    for held_m3 in [11.0, 12.0, 13.0, 12.5, 11.5] {
        assert_eq!(orders.capacity().unwrap().mean_m3, 8.0);
        orders.learn(held_m3);
    }
    assert_eq!(orders.capacity().unwrap().mean_m3, 12.0);
    assert_eq!(orders.bar(0, 1), None);
    assert_eq!(orders.closed_for_next(), []);
}

#[test]
fn a_container_that_is_not_filled_enough_stays_where_another_may_leave() {
    let rules = ClosingRules {
        least_fill_percent: Some(30.0),
        ..ClosingRules::default()
    };
    let fill = |items_m3, container_m3| Fill {
        items_m3,
        container_m3,
    };
    // The first holds most, but is large.
    assert_eq!(rules.fullest(&[fill(2.0, 10.0), fill(1.0, 3.0)]), Some(1));
    assert_eq!(rules.fullest(&[fill(2.0, 10.0), fill(0.5, 3.0)]), Some(0));
    assert_eq!(rules.fullest(&[]), None);
}

#[test]
fn rules_that_do_not_go_together_are_refused_with_what_to_do() {
    let refused = |closing: ClosingRules, choice| {
        let refused = closing.validate(&ContainerRules::default(), choice);
        refused.unwrap_err()
    };
    let none = ClosingRules::default();
    assert_eq!(
        none.validate(&ContainerRules::default(), ContainerChoice::Best),
        Ok(())
    );
    let fullest = ContainerChoice::Fullest;
    let least = ClosingRules {
        least_fill_percent: Some(80.0),
        fill_percent: Some(70.0),
        ..none
    };
    assert_eq!(refused(least, fullest), ClosingError::FullBeforeLeast);
    let count = |none_of_last| ClosingRules {
        none_of_last: Some(none_of_last),
        ..none
    };
    assert_eq!(refused(count(0), fullest), ClosingError::NoItems);
    assert_eq!(
        refused(count(3), ContainerChoice::Best),
        ClosingError::BestChoice
    );
    let rest = ClosingRules {
        rest_of_order: true,
        ..none
    };
    assert_eq!(refused(rest, fullest), ClosingError::NoCertainty);
    let complete = ClosingRules {
        order_complete: true,
        ..none
    };
    assert_eq!(refused(complete, fullest), ClosingError::SharedOrders);
    let one_order = ContainerRules {
        sharing: Sharing::OneOrder,
        ..ContainerRules::default()
    };
    assert_eq!(complete.validate(&one_order, fullest), Ok(()));
    let percent = ClosingRules {
        fill_percent: Some(f64::NAN),
        ..none
    };
    assert!(refused(percent, fullest).to_string().contains("1 to 100"));
}

#[test]
fn a_container_that_something_has_to_follow_into_is_not_closed_for_an_order() {
    let closed = |first, last| {
        let items = vec![first, item("b", 5.0), last];
        first_packed(50.0, 1, items).closed_for_next()
    };
    assert_eq!(closed(item("a", 4.0), item("c", 1.0)).len(), 1);
    assert_eq!(closed(bundled("a", 4.0), bundled("c", 1.0)), []);
}

#[test]
fn no_container_is_closed_for_an_order_that_has_to_follow_into_another_one() {
    let closed = |first, last| {
        let items = vec![first, item("b", 4.0), last];
        first_packed(50.0, 1, items).closed_for_next()
    };
    assert_eq!(closed(item("a", 4.0), item("b", 1.0)).len(), 1);
    // Another container has room for what must follow, but is not for it.
    let items = vec![
        bundled("a", 7.0),
        item("c", 7.0),
        item("b", 4.0),
        bundled("b", 1.0),
    ];
    let mut orders = first_packed(50.0, 2, items);
    orders.packed(1, 1);
    orders.begin_with(2..4);
    assert_eq!(orders.closed_for_next(), []);
}

#[test]
fn it_is_the_most_urgent_order_that_a_container_is_closed_for() {
    let urgent = OrderItem {
        urgency: 1,
        ..item("c", 5.0)
    };
    let items = vec![item("a", 4.0), item("b", 1.0), urgent];
    let closed = first_packed(50.0, 1, items).closed_for_next();
    let text = closed[0].1.to_string();
    assert!(text.contains("order c"), "{text}");
}

#[test]
fn what_must_travel_together_begins_where_all_of_it_is_certain_enough_to_fit() {
    let bar = |certainty_percent| {
        let items = vec![item("a", 4.0), bundled("b", 2.0), bundled("d", 3.0)];
        first_packed(certainty_percent, 1, items).bar(0, 1)
    };
    let unlikely = bar(50.0).unwrap();
    assert!(!unlikely.gives_way());
    let text = unlikely.to_string();
    assert!(text.ends_with("fits with 16 % certainty"), "{text}");
    assert_eq!(bar(10.0), None);
}
