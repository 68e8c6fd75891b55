//! Random orders with all rules at once, against a plain recomputation from what lies where.

use std::cmp::Reverse;
use std::collections::BTreeSet;

use ppnpack_packing::checks::sequence::Sequence;
use ppnpack_packing::planning::containers::plan_over;
use ppnpack_packing::scene::leaving::{Leaving, Stop};
use ppnpack_packing::streams::closing::{Closing, ClosingRules};
use ppnpack_packing::streams::episode::IdealCell;
use ppnpack_packing::streams::orders::{Bar, ContainerRules, OrderItem, Orders, Sharing};
use ppnpack_packing::streams::stream::{Filled, Stream, StreamPlay, play_stream};

use crate::streams::ideal;
use crate::support::*;

const GROUPS: [&str; 3] = ["food", "chemicals", "toys"];
const NEAR: f64 = 1e-7;

/// A container of 6 x 6 cells, 12 units high, one yaw.
fn grid() -> Grid {
    grid_of([6, 6], 0.01, 12, 1)
}

/// An item, what is known of it, and at which stop it leaves.
#[derive(Debug, Clone)]
struct Arriving {
    /// Along x and y in cells, and its height in units.
    size: (usize, usize, Units),
    line: OrderItem,
    stop: Stop,
}

/// These as they arrive.
fn candidates(items: &[Arriving]) -> Vec<Candidate> {
    let candidate = |(arrival, item): (usize, &Arriving)| Candidate {
        stop: item.stop,
        ..Candidate::new(
            arrival,
            block(&grid(), [item.size.0, item.size.1], item.size.2),
        )
    };
    items.iter().enumerate().map(candidate).collect()
}

/// What is known of them.
fn orders_of(rules: &ContainerRules, items: &[Arriving]) -> Orders {
    let lines = items.iter().map(|item| item.line.clone()).enumerate();
    Orders::new(rules.clone(), lines)
}

fn arriving() -> impl Strategy<Value = Arriving> {
    let maybe = |of: &'static [&'static str]| {
        prop_oneof![
            2 => Just(None),
            1 => proptest::sample::select(of).prop_map(|name| Some(Arc::<str>::from(name)))
        ]
    };
    let of_order = (0..4_u8, maybe(&GROUPS));
    let mass = prop_oneof![Just(None), (0.1..3.0).prop_map(Some)];
    let stop = prop_oneof![Just(None), (1..4_u32).prop_map(Some)];
    ((1..5_usize, 1..5_usize, 1..7_i16), of_order, mass, stop).prop_map(
        |(size, (order, group), mass_kg, stop)| Arriving {
            size,
            line: OrderItem {
                group,
                mass_kg,
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

    fn arrivals<'b>(containers: impl IntoIterator<Item = &'b Vec<Lying>>) -> Vec<usize> {
        let lying = containers.into_iter().flatten();
        lying.map(|lying| lying.arrival).collect()
    }

    fn held(&self, container: usize) -> Vec<usize> {
        Self::arrivals([&self.open[container]])
    }

    fn in_others(&self, container: usize) -> Vec<usize> {
        let open = self.open.iter().enumerate();
        let others = open.filter(|(other, _)| *other != container);
        Self::arrivals(others.map(|(_, held)| held))
    }

    /// Items that are to be packed.
    fn to_come(&self) -> Vec<usize> {
        let packed = Self::arrivals(self.open.iter().chain(&self.closed));
        let is_away = |arrival: &usize| packed.contains(arrival) || self.dropped.contains(arrival);
        let all = 0..self.items.len();
        all.filter(|arrival| !is_away(arrival)).collect()
    }

    fn are_tied(&self, a: usize, b: usize) -> bool {
        let (a, b) = (self.line(a), self.line(b));
        let is_of = |item: &OrderItem, pair: &(String, String)| {
            let group = item.group.as_deref();
            group == Some(&pair.0) || group == Some(&pair.1)
        };
        let mut pairs = self.rules.together.iter();
        let mut is_of_pair = || pairs.any(|pair| is_of(a, pair) && is_of(b, pair));
        a.order == b.order && (self.rules.undivided || is_of_pair())
    }

    /// All that hangs together with an item, of what is to come or lies in open containers.
    fn unit(&self, of: usize) -> BTreeSet<usize> {
        let mut here = Self::arrivals(&self.open);
        here.extend(self.to_come());
        let mut unit = BTreeSet::new();
        let mut next: Vec<usize> = self.are_tied(of, of).then_some(of).into_iter().collect();
        while let Some(one) = next.pop() {
            if unit.insert(one) {
                next.extend(here.iter().filter(|other| self.are_tied(one, **other)));
            }
        }
        unit
    }

    /// What must follow into a container.
    fn follows(&self, container: usize) -> Vec<usize> {
        let held = self.held(container);
        let to_come = self.to_come().into_iter();
        let follows = to_come.filter(|one| {
            let unit = self.unit(*one);
            held.iter().any(|held| unit.contains(held))
        });
        follows.collect()
    }

    fn is_apart(&self, a: &str, b: &str) -> bool {
        let mut pairs = self.rules.apart.iter();
        pairs.any(|(x, y)| (x == a && y == b) || (x == b && y == a))
    }

    fn mass_kg(&self, items: &[usize]) -> f64 {
        let masses = items.iter().filter_map(|item| self.line(*item).mass_kg);
        masses.sum()
    }

    fn orders(&self, items: &[usize]) -> BTreeSet<&'a str> {
        items.iter().map(|item| &*self.line(*item).order).collect()
    }

    /// The rule that is broken by these in one container, where one is.
    fn broken_by(&self, held: &[usize]) -> Option<&'static str> {
        let is_heavy = |most_kg| self.mass_kg(held) > most_kg + NEAR;
        let is_one_order = self.rules.sharing == Sharing::OneOrder;
        let mut pairs = held.iter().flat_map(|a| held.iter().map(move |b| (*a, *b)));
        let are_apart = |(a, b): (usize, usize)| {
            let groups = self.line(a).group.as_ref().zip(self.line(b).group.as_ref());
            a != b && groups.is_some_and(|(a, b)| self.is_apart(a, b))
        };
        if is_one_order && self.orders(held).len() > 1 {
            Some("one order")
        } else if self.rules.most_kg.is_some_and(is_heavy) {
            Some("mass")
        } else {
            pairs.any(are_apart).then_some("groups apart")
        }
    }

    /// The rule that is broken by what lies in the containers, where one is.
    fn broken(&self) -> Option<String> {
        let containers: Vec<&Vec<Lying>> = self.open.iter().chain(&self.closed).collect();
        for (container, lying) in containers.iter().enumerate() {
            let held = Self::arrivals([*lying]);
            if let Some(rule) = self.broken_by(&held) {
                return Some(format!("{rule} in {held:?}"));
            }
            let others = Self::arrivals(containers[container + 1..].iter().copied());
            for a in held {
                if let Some(b) = others.iter().find(|b| self.are_tied(a, **b)) {
                    return Some(format!("{a} and {b} travel together"));
                }
            }
            for (place, above) in lying.iter().enumerate() {
                for below in &lying[..place] {
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
            let at = resting([x, y], 0);
            let below = self.open[container].iter();
            let below = below.filter(|below| self.overlap(Lying { arrival, at }, **below));
            let mut resting_height = 0;
            let mut is_in_order = true;
            for Lying { arrival: below, at } in below {
                let below = &self.items[*below];
                resting_height = resting_height.max(at.resting_height + below.size.2);
                is_in_order &= below.stop >= self.items[arrival].stop;
            }
            is_in_order && resting_height + height <= grid.rim()
        })
    }

    /// Whether there is a cause for a bar of an item and a container: for one that never gives way,
    /// that the item, all that has to travel with it and all that has to follow into the container
    /// break a rule there, or that some of it is elsewhere.
    fn has_cause(&self, bar: &Bar, container: usize, arrival: usize, waiting: &[usize]) -> bool {
        let held = self.held(container);
        let item = self.line(arrival);
        match bar {
            Bar::OrderElsewhere(order) => {
                let others = self.orders(&self.in_others(container));
                let is_here = self.orders(&held).contains(&**order);
                *order == item.order && !is_here && others.contains(&**order)
            }
            Bar::EarlierOrder(order) => {
                let begun = self.orders(&Self::arrivals(&self.open));
                let unbegun = waiting.iter().map(|one| self.line(*one));
                let mut unbegun = unbegun.filter(|line| !begun.contains(&*line.order));
                let first = unbegun.next();
                let is_first = first.is_some_and(|line| line.order == *order);
                let is_one_order = self.rules.sharing == Sharing::OneOrder;
                is_one_order && is_first && *order != item.order
            }
            _ => {
                let unit = self.unit(arrival);
                let mut elsewhere = self.in_others(container).into_iter();
                let is_elsewhere = elsewhere.any(|other| unit.contains(&other));
                let mut closed = Self::arrivals(&self.closed).into_iter();
                let is_closed = closed.any(|other| self.are_tied(arrival, other));
                let to_come = self.to_come().into_iter();
                let rest: Vec<usize> = to_come.filter(|one| unit.contains(one)).collect();
                let all = [held, self.follows(container), rest, vec![arrival]].concat();
                let all: BTreeSet<usize> = all.into_iter().collect();
                let is_broken = self.broken_by(&Vec::from_iter(all)).is_some();
                is_elsewhere || is_closed || is_broken
            }
        }
    }

    /// Whether a container may take an item without breaking what is never broken.
    fn breaks_nothing(&self, container: usize, arrival: usize) -> bool {
        let with = [self.held(container), vec![arrival]].concat();
        let mut others = self.in_others(container);
        others.extend(Self::arrivals(&self.closed));
        let is_tied = others.iter().any(|other| self.are_tied(arrival, *other));
        self.broken_by(&with).is_none() && !is_tied
    }
}

/// Orders, planners of the open containers, and the world that both ought to follow.
struct Game<'a> {
    grid: Grid,
    all: Vec<Candidate>,
    orders: Orders,
    planners: Vec<Planner>,
    world: World<'a>,
}

impl<'a> Game<'a> {
    fn new(rules: &'a ContainerRules, items: &'a [Arriving], open: usize) -> Self {
        let mut game = Self {
            grid: grid(),
            all: candidates(items),
            orders: orders_of(rules, items),
            planners: Vec::new(),
            world: World {
                rules,
                items,
                open: Vec::new(),
                closed: Vec::new(),
                dropped: BTreeSet::new(),
            },
        };
        (0..open).for_each(|_| game.open());
        game
    }

    fn open(&mut self) {
        self.orders.opened();
        self.planners
            .push(planner(&self.grid, vec![Box::new(Sequence)]));
        self.world.open.push(Vec::new());
    }

    /// Closes a container, and opens an empty one.
    fn exchange(&mut self, container: usize) {
        self.orders.closed(container);
        self.planners.remove(container);
        let held = self.world.open.remove(container);
        self.world.closed.push(held);
        self.open();
    }

    fn scene(&self, held: &[Lying]) -> Scene {
        let mut heightmap = Heightmap::empty(&self.grid);
        let mut leaving = Leaving::empty(&self.grid);
        for Lying { arrival, at } in held {
            let view = &self.all[*arrival].item.views()[0];
            for (x, y, _, top) in view.cells() {
                let (x, y) = (at.placement.x + x, at.placement.y + y);
                heightmap.raise(x, y, at.resting_height + top);
            }
            leaving.place(view, at, self.all[*arrival].stop);
        }
        Scene::from_heightmap(heightmap).with_leaving(leaving)
    }

    /// Plans a step as a stream does: the container, what lies there then, whether rules gave way.
    fn plan(&mut self, waiting: &[Candidate]) -> Option<(usize, Lying, bool)> {
        let open = self.world.open.iter();
        let scenes: Vec<Scene> = open.map(|held| self.scene(held)).collect();
        let mut places: Vec<usize> = (0..scenes.len()).collect();
        places.sort_by_key(|place| Reverse(self.world.open[*place].len()));
        let attempts = self.orders.attempts(&places, waiting);
        let found = plan_over(&attempts, waiting, |at, admitted| {
            let place = places[at];
            let input = StepInput::new(&self.grid, &scenes[place], admitted);
            self.planners[place].plan(&input).cloned()
        });
        let found = found.unwrap()?;
        let choice = found.plan.choice()?;
        let (container, arrival) = (
            places[found.container],
            found.candidates[choice.candidate].arrival,
        );
        let lying = Lying {
            arrival,
            at: choice.resting,
        };
        let gave_way = self.orders.bar(container, arrival).is_some();
        Some((container, lying, gave_way))
    }

    /// What of these could be packed, by brute force, by all rules or those that never give way.
    fn placeable(&self, arrivals: &[usize], gives_way: bool) -> Vec<usize> {
        let may = |arrival: &&usize| {
            (0..self.planners.len()).any(|container| {
                self.orders.admits(gives_way, container, **arrival)
                    && self.world.has_place(&self.grid, container, **arrival)
            })
        };
        arrivals.iter().filter(may).copied().collect()
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn no_rule_is_broken_every_bar_has_a_cause_and_what_gives_way_does_so_for_want_of_anything_else(
        rules in rules(),
        items in proptest::collection::vec(arriving(), 1..18),
        count in 1_usize..4,
        buffer in 1_usize..5,
        events in proptest::collection::vec(0..12_u8, 60),
    ) {
        let mut game = Game::new(&rules, &items, count);
        for event in events {
            let mut arrivals = game.world.to_come();
            arrivals.truncate(buffer);
            let waiting: Vec<Candidate> =
                arrivals.iter().map(|arrival| game.all[*arrival].clone()).collect();
            if waiting.is_empty() {
                break;
            }
            game.orders.begin(&waiting);
            // By hand: a container leaves, or an item never comes.
            if event < 2 {
                game.exchange(usize::from(event) % count);
                continue;
            }
            if event == 2 {
                game.orders.dropped(arrivals[0]);
                game.world.dropped.insert(arrivals[0]);
                continue;
            }
            for container in 0..count {
                for arrival in &arrivals {
                    let bar = game.orders.bar(container, *arrival);
                    if let Some(bar) = &bar {
                        let has_cause = game.world.has_cause(bar, container, *arrival, &arrivals);
                        prop_assert!(has_cause, "{bar} ({bar:?}) of {arrival} in {container}");
                    }
                    if game.orders.admits(true, container, *arrival) {
                        let is_sound = game.world.breaks_nothing(container, *arrival);
                        prop_assert!(is_sound, "{arrival} in {container}");
                    }
                }
            }
            let chosen = game.plan(&waiting);
            let possible = game.placeable(&arrivals, true);
            let Some((container, lying, gave_way)) = chosen else {
                prop_assert!(possible.is_empty(), "{possible:?} could be packed");
                game.exchange(0);
                continue;
            };
            prop_assert!(possible.contains(&lying.arrival), "{:?} of {:?}", lying, possible);
            if gave_way {
                let strict = game.placeable(&arrivals, false);
                prop_assert!(strict.is_empty(), "{strict:?} needed no rule to give way");
            }
            game.world.open[container].push(lying);
            game.orders.packed(container, lying.arrival);
            prop_assert_eq!(game.world.broken(), None);
            // What must follow into a container can, as far as masses are concerned.
            for container in 0..count {
                let all = [game.world.held(container), game.world.follows(container)].concat();
                let all_kg = game.world.mass_kg(&all);
                let is_possible = rules.most_kg.is_none_or(|most_kg| all_kg <= most_kg + NEAR);
                prop_assert!(is_possible, "{all_kg} kg in {container}");
            }
        }
    }

    #[test]
    fn no_container_of_a_stream_breaks_a_rule_and_every_item_is_somewhere(
        rules in rules(),
        items in proptest::collection::vec(arriving(), 1..16),
        open in 1_usize..4,
    ) {
        let stream = pack(&rules, &items, open);
        let lying = |filled: &Filled<IdealCell>| -> Vec<Lying> {
            let steps = filled.steps.iter();
            steps.map(|step| Lying {
                arrival: step.candidate.arrival,
                at: step.choice.resting,
            }).collect()
        };
        let world = World {
            rules: &rules,
            items: &items,
            open: stream.open.iter().map(lying).collect(),
            closed: stream.closed.iter().map(lying).collect(),
            dropped: stream.unplaceable.iter().map(|held| held.arrival).collect(),
        };
        prop_assert_eq!(world.broken(), None);
        let placed = World::arrivals(world.open.iter().chain(&world.closed));
        prop_assert_eq!(placed.len() + stream.unplaceable.len(), items.len());
        let is_tied = |arrival: usize| world.are_tied(arrival, arrival);
        for arrival in world.dropped.iter().filter(|arrival| !is_tied(**arrival)) {
            prop_assert!(world.broken_by(&[*arrival]).is_some(), "{arrival} fits when it is alone");
        }
        let has = |filled: &Filled<IdealCell>, order: &str| {
            let mut steps = filled.steps.iter();
            steps.any(|step| *items[step.candidate.arrival].line.order == *order)
        };
        let is_complete = |filled: &&Filled<IdealCell>| filled.closing == Some(Closing::OrderComplete);
        for closed in stream.closed.iter().filter(is_complete) {
            let order = &*items[closed.steps[0].candidate.arrival].line.order;
            let others = stream.closed.iter().filter(|other| other.number != closed.number);
            let is_alone = !others.clone().any(|other| has(other, order));
            let mut later = others.chain(&stream.open).filter(|other| other.number > closed.number);
            prop_assert!(!is_alone || !later.any(|later| has(later, order)));
        }
    }
}

/// Packs a stream; where containers are for one order, they are closed with it.
fn pack(rules: &ContainerRules, items: &[Arriving], open: usize) -> Stream<IdealCell> {
    let how = StreamPlay {
        open,
        buffer: 3,
        closing: ClosingRules {
            order_complete: rules.sharing == Sharing::OneOrder,
            ..ClosingRules::default()
        },
    };
    let orders = orders_of(rules, items);
    let supply = |_| Ok(ideal(&grid(), Box::new(Sequence)));
    play_stream(&grid(), supply, candidates(items), orders, how).unwrap()
}

fn item(order: &str) -> OrderItem {
    OrderItem::new(order.into())
}

fn of_group(order: &str, group: &str) -> OrderItem {
    OrderItem {
        group: Some(group.into()),
        ..item(order)
    }
}

fn begun(rules: ContainerRules, items: &[OrderItem], containers: usize) -> Orders {
    let mut orders = Orders::new(rules, items.iter().cloned().enumerate());
    (0..containers).for_each(|_| orders.opened());
    orders
}

/// Asserts which rules that never give way keep which arrivals out: container, arrival, why.
fn assert_barred(orders: &mut Orders, cases: &[(usize, usize, Option<&str>)]) {
    orders.begin(&[]);
    for (container, arrival, why) in cases {
        let bar = orders.bar(*container, *arrival);
        let bar = bar.filter(|bar| !bar.gives_way());
        assert_eq!(bar.map(|bar| bar.to_string()).as_deref(), *why);
    }
}

#[test]
fn an_undivided_order_is_begun_where_all_of_it_is_possible_and_stays_in_its_container() {
    let rules = ContainerRules {
        undivided: true,
        most_kg: Some(5.0),
        apart: vec![("food".to_owned(), "soap".to_owned())],
        ..ContainerRules::default()
    };
    let heavy = |(order, mass_kg)| OrderItem {
        mass_kg: Some(mass_kg),
        ..item(order)
    };
    let items = [("7", 2.0), ("7", 2.0), ("8", 2.0), ("8", 0.5)].map(heavy);
    let items = [
        &items[..],
        &["soap", "food"].map(|group| of_group("9", group)),
    ]
    .concat();
    let mut orders = begun(rules, &items, 2);
    assert_barred(&mut orders, &[(0, 0, None)]);
    orders.packed(0, 0);
    let elsewhere = "the items of order 7 must not be divided, and others of them are in ";
    let to_follow = "the items of order 7 must not be divided, and others of them have to follow into this container: \
                     the container would be 1.50 kg too heavy";
    let contradictory = "the items of order 9 must not be divided, and of all of them together: \
                         food must not travel with soap";
    assert_barred(
        &mut orders,
        &[
            (0, 1, None),
            (1, 1, Some(&format!("{elsewhere}another container"))),
            // 2 kg are in it, 2 kg have to follow.
            (0, 2, Some(to_follow)),
            (1, 2, None),
            (0, 4, Some(contradictory)),
        ],
    );
    orders.closed(0);
    let closed = format!("{elsewhere}a container that was closed");
    assert_barred(&mut orders, &[(0, 1, Some(&closed)), (0, 2, None)]);
}

#[test]
fn groups_travel_together_and_what_is_tied_to_them_follows() {
    let rules = ContainerRules {
        together: [("device", "charger"), ("charger", "card")]
            .map(|(one, other)| (one.to_owned(), other.to_owned()))
            .into(),
        ..ContainerRules::default()
    };
    let mut items = ["device", "charger", "card", "toy"]
        .map(|group| of_group("7", group))
        .to_vec();
    items.push(of_group("9", "device"));
    let mut orders = begun(rules, &items, 2);
    orders.packed(0, 0);
    let tied = "the items of device and charger of order 7 must travel together, \
                and others of them are in another container";
    let chained = "the items of charger and card of order 7 must travel together, \
                   and others of them have to follow items in another container";
    assert_barred(
        &mut orders,
        &[
            (1, 1, Some(tied)),
            (1, 2, Some(chained)),
            (1, 3, None),
            (1, 4, None),
        ],
    );
    // One that never comes holds nothing together.
    orders.dropped(1);
    assert_barred(&mut orders, &[(1, 2, None)]);
}

#[test]
fn with_one_order_a_container_orders_follow_one_another_and_each_closes_its_own() {
    let rules = ContainerRules {
        sharing: Sharing::OneOrder,
        ..ContainerRules::default()
    };
    let arriving = |order| Arriving {
        size: (2, 2, 2),
        line: item(order),
        stop: Stop::LAST,
    };
    let items = ["a", "b", "a", "b", "a"].map(arriving);
    let stream = pack(&rules, &items, 1);
    let told = stream.closed.iter().map(|filled| {
        assert_eq!(filled.closing, Some(Closing::OrderComplete));
        let steps = filled.steps.iter();
        let orders = steps.map(|step| &*items[step.candidate.arrival].line.order);
        orders.collect::<Vec<&str>>()
    });
    assert_eq!(told.collect::<Vec<_>>(), [vec!["a"; 3], vec!["b"; 2]]);
    let mut orders = begun(rules.clone(), &["7", "8"].map(item), 1);
    orders.packed(0, 0);
    assert_barred(&mut orders, &[(0, 1, Some("the container is for order 7"))]);
    // One that expects more items is not complete; the greatest number counts.
    for (expected, complete) in [(vec![3, 2], None), (vec![2], Some(0))] {
        let mut orders = begun(rules.clone(), &["7", "7"].map(item), 1);
        expected
            .into_iter()
            .for_each(|items| orders.expect("7", items));
        (0..2).for_each(|arrival| orders.packed(0, arrival));
        assert_eq!(orders.complete(), complete);
    }
}

#[test]
fn groups_that_must_not_travel_together_close_a_container() {
    let rules = ContainerRules {
        apart: vec![("chemicals".to_owned(), "food".to_owned())],
        ..ContainerRules::default()
    };
    let items = ["food", "chemicals"].map(|group| Arriving {
        size: (2, 2, 2),
        line: of_group("a", group),
        stop: Stop::LAST,
    });
    let stream = pack(&rules, &items, 1);
    assert_eq!((stream.closed.len(), stream.open[0].steps.len()), (1, 1));
    let mut orders = begun(rules, &items.map(|item| item.line), 1);
    orders.packed(0, 0);
    assert_barred(
        &mut orders,
        &[
            (0, 1, Some("chemicals must not travel with food")),
            (
                9,
                1,
                Some("broken invariant \"what may take an item is open\": there is no container 9"),
            ),
        ],
    );
}
