//! Streams into several open containers, recomputed from all that happened.

use ppnpack_packing::streams::closing::{Closing, ClosingError, ClosingRules, Fill, fullest};
use ppnpack_packing::streams::episode::{IdealCell, PackingCell};
use ppnpack_packing::streams::orders::{ContainerRules, Orders, Sharing};
use ppnpack_packing::streams::stream::{Filled, StreamPlay, play_stream};

use crate::support::*;

/// An empty container without physics, in which placements pass a check.
pub(crate) fn ideal(grid: &Grid, check: BoxedCheck) -> (Planner, IdealCell) {
    (planner(grid, vec![check]), IdealCell::new(grid))
}

fn published() -> BoxedCheck {
    Box::new(PublishedStability::default())
}

/// A container as the slow stream knows it.
struct Slow {
    number: usize,
    cell: IdealCell,
    packed: Vec<usize>,
    items_m3: f64,
}

/// Containers closed, with what and why; then those open at the end; and what fits nowhere.
type Told = (Vec<(usize, Vec<usize>, Option<Closing>)>, Vec<usize>);

/// Packs a stream without orders, and looks at everything anew in each step.
fn slowly(grid: &Grid, mut waiting: Vec<Candidate>, how: StreamPlay) -> Told {
    let size = grid.container();
    let percent = |slow: &Slow| 100.0 * slow.items_m3 / size.volume_m3();
    let opened = |number: usize| Slow {
        number,
        cell: IdealCell::new(grid),
        packed: Vec::new(),
        items_m3: 0.0,
    };
    let (mut told, mut unplaceable) = (Vec::new(), Vec::new());
    let mut open: Vec<Slow> = (0..how.open).map(opened).collect();
    while !waiting.is_empty() {
        let buffer: Vec<Candidate> = waiting.iter().take(how.buffer).cloned().collect();
        let mut order: Vec<usize> = (0..open.len()).collect();
        order.sort_by(|a, b| percent(&open[*b]).total_cmp(&percent(&open[*a])));
        let placed = order.iter().find_map(|at| {
            let slow = &mut open[*at];
            let scene = slow.cell.scan().unwrap();
            let mut planner = planner(grid, vec![published()]);
            let plan = planner.plan(&StepInput::new(grid, &scene, &buffer));
            let choice = plan.unwrap().choice()?;
            let held = &buffer[choice.candidate];
            slow.cell
                .place(held, &choice.resting, &Evidence::default())
                .unwrap();
            slow.packed.push(held.arrival);
            slow.items_m3 += held.item.mesh_volume_m3();
            Some(held.arrival)
        });
        let mut closed = Vec::new();
        if let Some(arrival) = placed {
            waiting.retain(|other| other.arrival != arrival);
        } else if open.iter().any(|slow| slow.packed.is_empty()) {
            unplaceable.push(waiting.remove(0).arrival);
        } else {
            let slow = open.remove(order[0]);
            closed.push((slow.number, slow.packed, Some(Closing::NothingFits)));
        }
        open.retain_mut(|slow| {
            let percent = percent(slow);
            let full_at = how.closing.fill_percent;
            let Some(full_at) = full_at.filter(|full_at| percent >= *full_at) else {
                return true;
            };
            let why = Closing::Full { percent, full_at };
            closed.push((slow.number, std::mem::take(&mut slow.packed), Some(why)));
            false
        });
        open.extend(
            closed
                .iter()
                .zip(how.open + told.len()..)
                .map(|(_, number)| opened(number)),
        );
        told.extend(closed);
    }
    told.extend(
        open.into_iter()
            .map(|slow| (slow.number, slow.packed, None)),
    );
    (told, unplaceable)
}

/// A grid and items with volumes, in percent of its container.
fn cases() -> impl Strategy<Value = (Grid, Vec<Candidate>)> {
    grids().prop_flat_map(|grid| {
        let items = items(grid.resolution().yaws().count());
        let items = proptest::collection::vec((items, 1.0..20.0_f64), 4..20);
        let size = grid.container();
        let one_percent_m3 = size.x_m * size.y_m * size.z_m / 100.0;
        let items = items.prop_map(move |items| {
            let items = items.into_iter().map(|(item, percent)| {
                let views = item.views().iter().map(|view| view.surfaces().clone());
                let volume_m3 = percent * one_percent_m3;
                Arc::new(Item::new("item", views.collect(), volume_m3).unwrap())
            });
            Candidate::sequence(items)
        });
        (Just(grid), items)
    })
}

proptest! {
    #[test]
    fn items_go_where_and_containers_are_closed_as_all_that_happened_says(
        (grid, items) in cases(),
        fill_percent in proptest::option::of(10.0..100.0_f64),
        open in 1_usize..4,
        buffer in 1_usize..4,
    ) {
        let closing = ClosingRules { fill_percent, ..ClosingRules::default() };
        let how = StreamPlay { open, buffer, closing };
        let supply = |_| Ok(ideal(&grid, published()));
        let stream = play_stream(&grid, supply, items.clone(), Orders::default(), how).unwrap();
        let told = |filled: &Filled<IdealCell>| {
            assert_eq!(filled.packed().items, filled.steps.len());
            let arrivals = filled.steps.iter().map(|step| step.candidate.arrival);
            (filled.number, arrivals.collect(), filled.closing.clone())
        };
        prop_assert_eq!(stream.open.len(), open);
        let found = stream.closed.iter().chain(&stream.open).map(told).collect();
        let unplaceable = stream.unplaceable.iter().map(|held| held.arrival).collect();
        prop_assert_eq!((found, unplaceable), slowly(&grid, items, how));
    }
}

#[test]
fn the_fullest_is_that_with_the_greatest_share_of_its_volume() {
    let fill = |(items_m3, container_m3)| Fill {
        items_m3,
        container_m3,
    };
    // The first holds most, but is large.
    for (fills, expected) in [
        (&[(2.0, 10.0), (1.0, 3.0)][..], Some(1)),
        (&[(2.0, 10.0), (0.5, 3.0)], Some(0)),
        (&[(1.0, 2.0), (2.0, 4.0)], Some(0)),
        (&[], None),
    ] {
        let fills: Vec<Fill> = fills.iter().copied().map(fill).collect();
        assert_eq!(fullest(&fills), expected);
    }
}

#[test]
fn rules_that_do_not_go_together_are_refused_with_what_to_do() {
    let shared = ContainerRules::default();
    let one_order = ContainerRules {
        sharing: Sharing::OneOrder,
        ..ContainerRules::default()
    };
    let none = ClosingRules::default();
    assert_eq!(none.validate(&shared), Ok(()));
    let complete = ClosingRules {
        order_complete: true,
        ..none
    };
    assert_eq!(complete.validate(&shared), Err(ClosingError::SharedOrders));
    assert_eq!(complete.validate(&one_order), Ok(()));
    let percent = ClosingRules {
        fill_percent: Some(f64::NAN),
        ..none
    };
    let refused = percent.validate(&shared).unwrap_err();
    assert!(refused.to_string().contains("1 to 100"));
}
