//! Random orders with all rules at once, against a slow and plain recomputation from what lies where.
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
use ppnpack_packing::check::BoxedCheck;
use ppnpack_packing::containers::{
    Chosen, ContainerChoice, ContainersStep, OpenContainer, OpenContainers,
};
use ppnpack_packing::grid::{ContainerSize, Grid, Resolution, Yaws};
use ppnpack_packing::heightmap::{Heightmap, Scene};
use ppnpack_packing::item::{Item, ViewSurfaces};
use ppnpack_packing::leaving::{Leaving, Sequence, Stop};
use ppnpack_packing::objective::Order;
use ppnpack_packing::orders::{Bar, ContainerRules, OrderItem, Orders, Sharing, Tie};
use ppnpack_packing::placement::RestingPlacement;
use ppnpack_packing::plan::Planner;
use ppnpack_packing::proposals::ProposeAll;
use ppnpack_packing::search::{Search, SearchSettings};
use proptest::prelude::*;

const GROUPS: [&str; 3] = ["food", "chemicals", "toys"];
const NEAR: f64 = 1e-7;

/// A container of 6 x 6 cells, 12 units high, one yaw.
fn grid() -> Grid {
    let resolution = Resolution::new(0.01, 0.002, Yaws::half_turn(1).unwrap());
    let container = ContainerSize {
        x_m: 0.06,
        y_m: 0.06,
        z_m: 0.024,
    };
    Grid::new(container, resolution.unwrap()).unwrap()
}

/// An item, what is known of it, and at which stop it leaves.
#[derive(Debug, Clone)]
struct Arriving {
    /// Along x and y in cells, and its height in units.
    size: (usize, usize, i16),
    line: OrderItem,
    stop: Stop,
}

impl Arriving {
    fn candidate(&self, arrival: usize) -> Candidate {
        let (nx, ny, height) = self.size;
        let view = ViewSurfaces::of_cells(nx, ny, vec![height; nx * ny], vec![0; nx * ny]);
        let item = Arc::new(Item::new("box", vec![view], 0.0).unwrap());
        Candidate {
            stop: self.stop,
            ..Candidate::new(arrival, item)
        }
    }
}

fn arriving() -> impl Strategy<Value = Arriving> {
    let maybe = |of: &'static [&'static str]| {
        prop_oneof![
            2 => Just(None),
            1 => proptest::sample::select(of).prop_map(|name| Some(Arc::<str>::from(name)))
        ]
    };
    let mass = prop_oneof![Just(None), (0.1..3.0).prop_map(Some)];
    let stop = prop_oneof![Just(None), (1..4_u32).prop_map(Some)];
    (
        (1..5_usize, 1..5_usize, 1..7_i16),
        0..4_u8,
        maybe(&GROUPS),
        maybe(&["x", "y"]),
        mass,
        0..3_u32,
        stop,
    )
        .prop_map(
            |(size, order, group, bundle, mass_kg, urgency, stop)| Arriving {
                size,
                line: OrderItem {
                    group,
                    bundle,
                    mass_kg,
                    urgency,
                    ..OrderItem::new(order.to_string().into())
                },
                stop: Stop::new(stop),
            },
        )
}

fn rules() -> impl Strategy<Value = ContainerRules> {
    let sharing = prop_oneof![1 => Just(Sharing::OneOrder), 2 => Just(Sharing::Shared)];
    let pairs = || {
        let group = || proptest::sample::select(&GROUPS[..]).prop_map(str::to_owned);
        proptest::collection::vec((group(), group()), 0..2)
    };
    let most_kg = prop_oneof![Just(None), (3.0..9.0).prop_map(Some)];
    (sharing, any::<bool>(), pairs(), pairs(), most_kg).prop_map(
        |(sharing, undivided, apart, together, most_kg)| ContainerRules {
            sharing,
            undivided,
            apart,
            together,
            most_kg,
        },
    )
}

/// An item that was placed.
#[derive(Debug, Clone, Copy)]
struct Lying {
    arrival: usize,
    at: RestingPlacement,
}

/// What lies where, and what became of the others.
struct World<'a> {
    rules: &'a ContainerRules,
    items: &'a [Arriving],
    open: Vec<Vec<Lying>>,
    closed: Vec<Vec<Lying>>,
    dropped: BTreeSet<usize>,
}

impl<'a> World<'a> {
    fn line(&self, arrival: usize) -> &'a OrderItem {
        &self.items[arrival].line
    }

    fn arrivals(lying: &[Lying]) -> Vec<usize> {
        lying.iter().map(|lying| lying.arrival).collect()
    }

    fn held(&self, container: usize) -> Vec<usize> {
        Self::arrivals(&self.open[container])
    }

    fn in_closed(&self) -> Vec<usize> {
        self.closed
            .iter()
            .flat_map(|held| Self::arrivals(held))
            .collect()
    }

    fn in_others(&self, container: usize) -> Vec<usize> {
        let others = (0..self.open.len()).filter(|other| *other != container);
        others.flat_map(|other| self.held(other)).collect()
    }

    /// Items that are to be packed.
    fn to_come(&self) -> Vec<usize> {
        let lying: BTreeSet<usize> = self.in_others(usize::MAX).into_iter().collect();
        let closed: BTreeSet<usize> = self.in_closed().into_iter().collect();
        let all = 0..self.items.len();
        all.filter(|arrival| {
            !lying.contains(arrival) && !closed.contains(arrival) && !self.dropped.contains(arrival)
        })
        .collect()
    }

    fn are_tied(&self, a: usize, b: usize) -> bool {
        let (a, b) = (self.line(a), self.line(b));
        let is_of = |item: &OrderItem, one: &str, other: &str| {
            let group = item.group.as_deref();
            group == Some(one) || group == Some(other)
        };
        let mut pairs = self.rules.together.iter();
        (self.rules.undivided && a.order == b.order)
            || (a.bundle.is_some() && a.bundle == b.bundle)
            || (a.order == b.order && pairs.any(|(x, y)| is_of(a, x, y) && is_of(b, x, y)))
    }

    /// All that hangs together with an item, of what is to come or lies in open containers.
    fn unit(&self, of: usize) -> BTreeSet<usize> {
        let here: Vec<usize> = self
            .in_others(usize::MAX)
            .into_iter()
            .chain(self.to_come())
            .collect();
        let mut unit = BTreeSet::new();
        let mut next: Vec<usize> = if self.are_tied(of, of) {
            vec![of]
        } else {
            vec![]
        };
        while let Some(one) = next.pop() {
            if unit.insert(one) {
                next.extend(here.iter().filter(|other| self.are_tied(one, **other)));
            }
        }
        unit
    }

    fn is_apart(&self, a: &str, b: &str) -> bool {
        let mut pairs = self.rules.apart.iter();
        pairs.any(|(x, y)| (x == a && y == b) || (x == b && y == a))
    }

    fn has_group(&self, items: &[usize], group: &str) -> usize {
        let groups = items.iter().map(|item| self.line(*item).group.as_deref());
        groups.filter(|of| *of == Some(group)).count()
    }

    fn mass_kg(&self, items: &[usize]) -> f64 {
        let masses = items.iter().filter_map(|item| self.line(*item).mass_kg);
        masses.sum()
    }

    fn orders(&self, items: &[usize]) -> BTreeSet<&'a str> {
        items.iter().map(|item| &*self.line(*item).order).collect()
    }

    /// The rule that is broken by what lies in the containers, where one is.
    fn broken(&self) -> Option<String> {
        let containers: Vec<Vec<usize>> = self
            .open
            .iter()
            .chain(&self.closed)
            .map(|held| Self::arrivals(held))
            .collect();
        for (container, held) in containers.iter().enumerate() {
            if self.rules.sharing == Sharing::OneOrder && self.orders(held).len() > 1 {
                return Some(format!("one order in {held:?}"));
            }
            if let Some(most_kg) = self.rules.most_kg
                && self.mass_kg(held) > most_kg + NEAR
            {
                return Some(format!("mass of {held:?}"));
            }
            for a in held {
                for b in held.iter().filter(|b| *b != a) {
                    let groups = self
                        .line(*a)
                        .group
                        .as_ref()
                        .zip(self.line(*b).group.as_ref());
                    if groups.is_some_and(|(a, b)| self.is_apart(a, b)) {
                        return Some(format!("groups of {a} and {b}"));
                    }
                }
                for other in &containers[container + 1..] {
                    if let Some(b) = other.iter().find(|b| self.are_tied(*a, **b)) {
                        return Some(format!("{a} and {b} travel together"));
                    }
                }
            }
        }
        for held in self.open.iter().chain(&self.closed) {
            for (place, above) in held.iter().enumerate() {
                for below in &held[..place] {
                    let is_late = self.items[above.arrival].stop > self.items[below.arrival].stop;
                    if is_late && self.overlap(*above, *below) {
                        return Some(format!("{above:?} lies above {below:?}"));
                    }
                }
            }
        }
        None
    }

    /// Whether two boxes share a cell of the floor.
    fn overlap(&self, a: Lying, b: Lying) -> bool {
        let reach = |lying: Lying| {
            let (nx, ny, _) = self.items[lying.arrival].size;
            let at = lying.at.placement;
            (at.x..at.x + nx, at.y..at.y + ny)
        };
        let ((ax, ay), (bx, by)) = (reach(a), reach(b));
        ax.start < bx.end && bx.start < ax.end && ay.start < by.end && by.start < ay.end
    }

    /// Whether an item has a valid placement in a container: every place is tried.
    fn has_place(&self, grid: &Grid, container: usize, arrival: usize) -> bool {
        let (nx, ny, height) = self.items[arrival].size;
        let corners = (0..=grid.nx() - nx).flat_map(|x| (0..=grid.ny() - ny).map(move |y| (x, y)));
        let mut corners = corners;
        corners.any(|(x, y)| {
            let mut at = RestingPlacement {
                placement: ppnpack_packing::placement::Placement { yaw: 0, x, y },
                resting_height: 0,
            };
            let here = Lying { arrival, at };
            let below = self.open[container].iter();
            let below: Vec<&Lying> = below.filter(|below| self.overlap(here, **below)).collect();
            for lying in &below {
                let top = lying.at.resting_height + self.items[lying.arrival].size.2;
                at.resting_height = at.resting_height.max(top);
            }
            let mut below = below.iter();
            at.resting_height + height <= grid.rim()
                && below.all(|below| self.items[below.arrival].stop >= self.items[arrival].stop)
        })
    }

    /// Whether this reason is true of an item and a container.
    fn is_true(&self, bar: &Bar, container: usize, arrival: usize, waiting: &[usize]) -> bool {
        let held = self.held(container);
        let item = self.line(arrival);
        let unit = self.unit(arrival);
        let to_come = self.to_come();
        let rest: Vec<usize> = unit
            .iter()
            .copied()
            .filter(|one| to_come.contains(one))
            .collect();
        let ties =
            |tie: &Tie, one: usize| self.is_tied_by(tie, one) && self.is_tied_by(tie, arrival);
        let is_begun = held.iter().any(|one| unit.contains(one));
        let over = |needed: f64, most: Option<f64>, over: f64| {
            (needed - most.unwrap() - over).abs() < NEAR && over > 0.0
        };
        match bar {
            Bar::OtherOrder(other) => {
                self.rules.sharing == Sharing::OneOrder
                    && self.orders(&held).contains(&**other)
                    && *other != item.order
            }
            Bar::GroupsApart(a, b) => {
                item.group.as_ref() == Some(a)
                    && self.has_group(&held, b) > 0
                    && self.is_apart(a, b)
            }
            Bar::TooHeavy { over_kg } => {
                let needed_kg = self.mass_kg(&held) + item.mass_kg.unwrap();
                over(needed_kg, self.rules.most_kg, *over_kg)
            }
            Bar::TiedElsewhere { tie, is_closed } => {
                let others = match is_closed {
                    true => self.in_closed(),
                    false => self.in_others(container),
                };
                others.iter().any(|other| ties(tie, *other))
            }
            Bar::ChainedElsewhere(tie) => {
                let others = self.in_others(container);
                self.is_tied_by(tie, arrival)
                    && !is_begun
                    && others.iter().any(|other| unit.contains(other))
            }
            Bar::WithOthers { tie, bar } => {
                let all: Vec<usize> = held.iter().chain(&rest).copied().collect();
                let is_so = match &**bar {
                    Bar::OtherOrder(_) => {
                        self.rules.sharing == Sharing::OneOrder && self.orders(&all).len() > 1
                    }
                    Bar::GroupsApart(a, b) => {
                        let needed = if a == b { 2 } else { 1 };
                        self.is_apart(a, b)
                            && self.has_group(&rest, a) > 0
                            && self.has_group(&all, b) >= needed
                    }
                    Bar::TooHeavy { over_kg } => {
                        over(self.mass_kg(&all), self.rules.most_kg, *over_kg)
                    }
                    _ => false,
                };
                self.is_tied_by(tie, arrival) && !is_begun && is_so
            }
            Bar::KeptFor { tie, bar } => {
                let kept = to_come.iter().copied().filter(|one| {
                    let theirs = self.unit(*one);
                    held.iter().any(|held| theirs.contains(held))
                });
                let kept: Vec<usize> = kept.collect();
                let own = if rest.is_empty() { vec![arrival] } else { rest };
                let is_so = match &**bar {
                    Bar::GroupsApart(a, b) => {
                        self.is_apart(a, b)
                            && self.has_group(&own, a) > 0
                            && self.has_group(&kept, b) > 0
                    }
                    Bar::TooHeavy { over_kg } => {
                        let all: Vec<usize> =
                            held.iter().chain(&kept).chain(&own).copied().collect();
                        over(self.mass_kg(&all), self.rules.most_kg, *over_kg)
                    }
                    _ => false,
                };
                let names = kept.iter().flat_map(|one| self.unit(*one));
                let mut names = names.filter(|one| self.is_tied_by(tie, *one));
                !is_begun && is_so && names.next().is_some()
            }
            Bar::OrderElsewhere(order) => {
                *order == item.order
                    && !self.orders(&held).contains(&**order)
                    && self.orders(&self.in_others(container)).contains(&**order)
            }
            Bar::EarlierOrder(order) => {
                let begun = self.orders(&self.in_others(usize::MAX));
                let unbegun = waiting.iter().map(|one| self.line(*one));
                let unbegun: Vec<&OrderItem> = unbegun
                    .filter(|line| !begun.contains(&*line.order))
                    .collect();
                let most = unbegun.iter().map(|line| line.urgency).max();
                let first = unbegun.iter().find(|line| Some(line.urgency) == most);
                self.rules.sharing == Sharing::OneOrder
                    && first.is_some_and(|line| line.order == *order)
                    && *order != item.order
            }
            _ => false,
        }
    }

    fn is_tied_by(&self, tie: &Tie, arrival: usize) -> bool {
        let line = self.line(arrival);
        match tie {
            Tie::Order(order) => self.rules.undivided && line.order == *order,
            Tie::Groups { order, groups } => {
                let group = line.group.as_deref();
                self.rules.together.contains(groups)
                    && line.order == *order
                    && (group == Some(&groups.0) || group == Some(&groups.1))
            }
            Tie::Bundle(bundle) => line.bundle.as_ref() == Some(bundle),
        }
    }

    /// Whether a container may take an item without breaking what is never broken, as things lie now.
    fn breaks_nothing(&self, container: usize, arrival: usize) -> bool {
        let held = self.held(container);
        let item = self.line(arrival);
        let with: Vec<usize> = held.iter().copied().chain([arrival]).collect();
        let one_order = self.rules.sharing == Sharing::OneOrder && self.orders(&with).len() > 1;
        let is_heavy = self
            .rules
            .most_kg
            .is_some_and(|most_kg| item.mass_kg.is_some() && self.mass_kg(&with) > most_kg + NEAR);
        let is_apart = held.iter().any(|one| {
            let groups = self.line(*one).group.as_ref().zip(item.group.as_ref());
            groups.is_some_and(|(a, b)| self.is_apart(a, b))
        });
        let mut others = self.in_others(container);
        others.extend(self.in_closed());
        let is_tied = others.iter().any(|other| self.are_tied(arrival, *other));
        !one_order && !is_heavy && !is_apart && !is_tied
    }
}

/// The scene of what lies in a container.
fn scene(grid: &Grid, candidates: &[Candidate], held: &[Lying]) -> Scene {
    let mut heightmap = Heightmap::empty(grid);
    let mut leaving = Leaving::empty(grid);
    for Lying { arrival, at } in held {
        let view = &candidates[*arrival].item.views()[0];
        for (x, y, _, top) in view.cells() {
            let (x, y) = (at.placement.x + x, at.placement.y + y);
            heightmap.raise(x, y, at.resting_height + top);
        }
        leaving.place(view, at, candidates[*arrival].stop);
    }
    Scene::from_heightmap(heightmap).with_leaving(leaving)
}

fn planner(grid: &Grid) -> Planner {
    let search = Search::new(grid, &SearchSettings::default()).unwrap();
    let checks: Vec<BoxedCheck> = vec![Box::new(Sequence)];
    let search = Box::new(search.bounded());
    Planner::new(Box::new(ProposeAll), search, checks, Order::Balance, 0)
}

/// Plans a step as a stream does; whether rules that give way did so.
fn plan(
    planners: &mut OpenContainers,
    orders: &Orders,
    open: &[OpenContainer<'_>],
    waiting: &[Candidate],
    choice: ContainerChoice,
) -> Option<(Chosen, bool)> {
    let containers: Vec<usize> = (0..open.len()).collect();
    orders
        .attempts(&containers, waiting)
        .into_iter()
        .find_map(|attempt| {
            let step = ContainersStep {
                choice,
                admits: &|at, held| orders.admits(attempt, at, held.arrival),
                ..ContainersStep::new(open, waiting)
            };
            let (chosen, _) = planners.plan(&step).unwrap();
            Some((chosen?, attempt.gives_way))
        })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn no_rule_is_broken_every_bar_is_true_and_what_gives_way_does_so_for_want_of_anything_else(
        rules in rules(),
        items in proptest::collection::vec(arriving(), 1..18),
        count in 1_usize..4,
        buffer in 1_usize..5,
        is_best in any::<bool>(),
        events in proptest::collection::vec(0..12_u8, 60),
    ) {
        let grid = grid();
        let all: Vec<Candidate> = items
            .iter()
            .enumerate()
            .map(|(arrival, item)| item.candidate(arrival))
            .collect();
        let lines = items.iter().map(|item| item.line.clone()).enumerate();
        let mut orders = Orders::new(rules.clone(), lines);
        let mut planners = OpenContainers::default();
        for _ in 0..count {
            orders.opened();
            planners.open(planner(&grid));
        }
        let mut world = World {
            rules: &rules,
            items: &items,
            open: vec![Vec::new(); count],
            closed: Vec::new(),
            dropped: BTreeSet::new(),
        };
        let choice = if is_best { ContainerChoice::Best } else { ContainerChoice::Fullest };
        for event in events {
            let to_come = world.to_come();
            let waiting: Vec<Candidate> =
                to_come.iter().take(buffer).map(|arrival| all[*arrival].clone()).collect();
            let arrivals: Vec<usize> = waiting.iter().map(|held| held.arrival).collect();
            if waiting.is_empty() {
                break;
            }
            orders.begin(&waiting);
            // By hand: a container leaves, or an item never comes.
            if event < 2 {
                let container = usize::from(event) % count;
                orders.closed(container);
                orders.opened();
                planners.close(container);
                planners.open(planner(&grid));
                let held = world.open.remove(container);
                world.closed.push(held);
                world.open.push(Vec::new());
                continue;
            }
            if event == 2 {
                orders.dropped(arrivals[0]);
                world.dropped.insert(arrivals[0]);
                continue;
            }
            for container in 0..count {
                for arrival in &arrivals {
                    let bar = orders.bar(container, *arrival);
                    if let Some(bar) = &bar {
                        let is_true = world.is_true(bar, container, *arrival, &arrivals);
                        prop_assert!(is_true, "{bar} ({bar:?}) of {arrival} in {container}");
                    }
                    if bar.is_none_or(|bar| bar.gives_way()) {
                        prop_assert!(world.breaks_nothing(container, *arrival), "{arrival} in {container}");
                    }
                }
            }
            let scenes: Vec<Scene> =
                world.open.iter().map(|held| scene(&grid, &all, held)).collect();
            let open = scenes.iter().zip(&world.open).map(|(scene, held)| OpenContainer {
                grid: &grid,
                scene,
                filled_percent: held.len() as f64,
            });
            let open: Vec<OpenContainer<'_>> = open.collect();
            let chosen = plan(&mut planners, &orders, &open, &waiting, choice);
            // What could be packed, by brute force: by all rules, and by those that never give way.
            let placeable = |gives_way: bool| -> Vec<usize> {
                let may = |arrival: &&usize| {
                    (0..count).any(|container| {
                        let bar = orders.bar(container, **arrival);
                        bar.is_none_or(|bar| gives_way && bar.gives_way())
                            && world.has_place(&grid, container, **arrival)
                    })
                };
                arrivals.iter().filter(may).copied().collect()
            };
            let possible = placeable(true);
            let Some((chosen, gave_way)) = chosen else {
                prop_assert!(possible.is_empty(), "{possible:?} could be packed");
                let container = 0;
                orders.closed(container);
                orders.opened();
                planners.close(container);
                planners.open(planner(&grid));
                let held = world.open.remove(container);
                world.closed.push(held);
                world.open.push(Vec::new());
                continue;
            };
            let arrival = arrivals[chosen.placement.candidate];
            let urgency = |arrival: &usize| world.line(*arrival).urgency;
            let most = possible.iter().map(urgency).max();
            prop_assert_eq!(Some(urgency(&arrival)), most, "{} of {:?}", arrival, possible);
            if gave_way {
                let strict = placeable(false);
                let strict: Vec<_> =
                    strict.iter().filter(|other| Some(urgency(other)) == most).collect();
                prop_assert!(strict.is_empty(), "{strict:?} needed no rule to give way");
            }
            let lying = Lying { arrival, at: chosen.placement.resting };
            world.open[chosen.container].push(lying);
            orders.packed(chosen.container, arrival);
            planners.changed(chosen.container);
            prop_assert_eq!(world.broken(), None);
            // What must follow into a container can, as far as masses are concerned.
            if let Some(most_kg) = rules.most_kg {
                for container in 0..count {
                    let held = world.held(container);
                    let follows = world.to_come().into_iter().filter(|one| {
                        let unit = world.unit(*one);
                        held.iter().any(|held| unit.contains(held))
                    });
                    let follows: Vec<usize> = follows.collect();
                    let all_kg = world.mass_kg(&held) + world.mass_kg(&follows);
                    prop_assert!(all_kg <= most_kg + NEAR, "{all_kg} kg in {container}");
                }
            }
        }
    }
}

fn item(order: &str) -> OrderItem {
    OrderItem::new(order.into())
}

fn begun(rules: ContainerRules, items: &[OrderItem], containers: usize) -> Orders {
    let mut orders = Orders::new(rules, items.iter().cloned().enumerate());
    for _ in 0..containers {
        orders.opened();
    }
    orders.begin(&[]);
    orders
}

fn told(orders: &Orders, container: usize, arrival: usize) -> String {
    let bar = orders.bar(container, arrival).unwrap();
    assert!(!bar.gives_way(), "{bar}");
    bar.to_string()
}

#[test]
fn an_undivided_order_stays_in_its_container_and_cannot_follow_into_a_closed_one() {
    let rules = ContainerRules {
        undivided: true,
        ..ContainerRules::default()
    };
    let mut orders = begun(rules, &["7", "7", "8"].map(item), 2);
    orders.packed(0, 0);
    assert_eq!(orders.bar(0, 1), None);
    assert_eq!(
        told(&orders, 1, 1),
        "the items of order 7 must not be divided, and others of them are in another container"
    );
    orders.closed(0);
    orders.begin(&[]);
    assert_eq!(
        told(&orders, 0, 1),
        "the items of order 7 must not be divided, and others of them are in a container that was closed"
    );
    assert_eq!(orders.bar(0, 2), None);
}

#[test]
fn an_undivided_order_is_begun_only_where_all_of_it_is_possible() {
    let rules = ContainerRules {
        undivided: true,
        most_kg: Some(5.0),
        apart: vec![("food".to_owned(), "soap".to_owned())],
        ..ContainerRules::default()
    };
    let heavy = |order: &str, mass_kg: f64| OrderItem {
        mass_kg: Some(mass_kg),
        ..item(order)
    };
    let soap = OrderItem {
        group: Some("soap".into()),
        ..item("9")
    };
    let food = OrderItem {
        group: Some("food".into()),
        ..item("9")
    };
    let items = [
        heavy("7", 2.0),
        heavy("7", 2.0),
        heavy("8", 2.0),
        heavy("8", 0.5),
        soap,
        food,
    ];
    let mut orders = begun(rules, &items, 1);
    assert_eq!(orders.bar(0, 0), None);
    orders.packed(0, 0);
    // 2 kg are in it, 2 kg have to follow.
    assert_eq!(
        told(&orders, 0, 2),
        "the items of order 7 must not be divided, and others of them have to follow into this container: \
         the container would be 1.50 kg too heavy"
    );
    assert_eq!(
        told(&orders, 0, 4),
        "the items of order 9 must not be divided, and of all of them together: food must not travel with soap"
    );
}

#[test]
fn groups_and_bundles_travel_together_and_what_is_tied_to_them_follows() {
    let rules = ContainerRules {
        together: vec![("device".to_owned(), "charger".to_owned())],
        ..ContainerRules::default()
    };
    let of = |order: &str, group: &str, bundle: Option<&str>| OrderItem {
        group: Some(group.into()),
        bundle: bundle.map(Arc::from),
        ..item(order)
    };
    let items = [
        of("7", "device", None),
        of("7", "charger", Some("gift")),
        of("8", "card", Some("gift")),
        of("7", "toy", None),
        of("9", "device", None),
    ];
    let mut orders = begun(rules, &items, 2);
    orders.packed(0, 0);
    assert_eq!(
        told(&orders, 1, 1),
        "the items of device and charger of order 7 must travel together, and others of them are in another container"
    );
    assert_eq!(
        told(&orders, 1, 2),
        "the items of bundle gift must travel together, and others of them have to follow items in another container"
    );
    assert!(orders.bar(1, 3).is_none_or(|bar| bar.gives_way()));
    assert_eq!(orders.bar(1, 4), None);
    // One that never comes holds nothing together.
    orders.dropped(1);
    orders.begin(&[]);
    assert_eq!(orders.bar(1, 2), None);
}

#[test]
fn an_order_that_expects_more_items_is_not_complete() {
    let rules = ContainerRules {
        sharing: Sharing::OneOrder,
        ..ContainerRules::default()
    };
    let mut orders = begun(rules.clone(), &["7", "7"].map(item), 1);
    orders.expect("7", 3);
    // The greatest number counts.
    orders.expect("7", 2);
    let mut as_many = begun(rules, &["7", "7"].map(item), 1);
    as_many.expect("7", 2);
    for orders in [&mut orders, &mut as_many] {
        orders.packed(0, 0);
        orders.packed(0, 1);
    }
    assert_eq!(orders.complete(), None);
    assert_eq!(as_many.complete(), Some(0));
}
