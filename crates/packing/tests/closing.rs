//! When containers are closed: by rules that are recomputed here from all that happened.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

mod support;

use std::sync::Arc;

use ppnpack_packing::candidate::Candidate;
use ppnpack_packing::closing::{Closing, ClosingError, ClosingRules, Fill, fullest};
use ppnpack_packing::containers::ContainerChoice;
use ppnpack_packing::episode::{IdealCell, PackingCell};
use ppnpack_packing::grid::Grid;
use ppnpack_packing::item::Item;
use ppnpack_packing::objective::Heuristic;
use ppnpack_packing::orders::{ContainerRules, Orders, Sharing};
use ppnpack_packing::plan::StepInput;
use ppnpack_packing::stream::{Filled, StreamPlay, play_stream};
use proptest::prelude::*;
use support::ideal::{Ideal, planner};

/// A container as the slow stream knows it.
struct Slow {
    number: usize,
    cell: IdealCell,
    packed: Vec<usize>,
    items_m3: f64,
}

impl Slow {
    fn new(number: usize, grid: &Grid) -> Self {
        Self {
            number,
            cell: IdealCell::new(grid),
            packed: Vec::new(),
            items_m3: 0.0,
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
    let (mut waiting, mut told) = (items, Told::new());
    let mut open: Vec<Slow> = (0..how.open)
        .map(|number| Slow::new(number, grid))
        .collect();
    let mut opened = how.open;
    while !waiting.is_empty() {
        let buffer: Vec<Candidate> = waiting.iter().take(how.buffer).cloned().collect();
        let mut order: Vec<usize> = (0..open.len()).collect();
        order.sort_by(|a, b| open[*b].percent(grid).total_cmp(&open[*a].percent(grid)));
        let mut is_placed = false;
        for at in order {
            let slow = &mut open[at];
            let scene = slow.cell.scan().unwrap();
            let mut planner = planner(grid, Heuristic::Sdfm);
            let plan = planner
                .plan(&StepInput::new(grid, &scene, &buffer))
                .unwrap();
            let Some(choice) = plan.choice() else {
                continue;
            };
            let held = &buffer[choice.candidate];
            let evidence = plan.evidence().cloned().unwrap_or_default();
            slow.cell.place(held, &choice.resting, &evidence).unwrap();
            slow.packed.push(held.arrival);
            slow.items_m3 += held.item.mesh_volume_m3();
            waiting.retain(|other| other.arrival != held.arrival);
            is_placed = true;
            break;
        }
        let mut closed = Vec::new();
        if !is_placed && open.iter().any(|slow| slow.packed.is_empty()) {
            waiting.remove(0);
        } else if !is_placed {
            let fullest = (0..open.len())
                .min_by(|a, b| open[*b].percent(grid).total_cmp(&open[*a].percent(grid)));
            let slow = open.remove(fullest.unwrap());
            closed.push((slow.number, slow.packed, Some(Closing::NothingFits)));
        }
        open.retain_mut(|slow| {
            let percent = slow.percent(grid);
            let Some(full_at) = rules.fill_percent.filter(|full_at| percent >= *full_at) else {
                return true;
            };
            let why = Closing::Full { percent, full_at };
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

fn closing_rules() -> impl Strategy<Value = ClosingRules> {
    let full = proptest::option::of(10.0..100.0_f64);
    full.prop_map(|fill_percent| ClosingRules {
        fill_percent,
        ..ClosingRules::default()
    })
}

proptest! {
    #[test]
    fn containers_are_closed_as_all_that_happened_says(
        (grid, items) in streams(),
        closing in closing_rules(),
        open in 1_usize..4,
        buffer in 1_usize..4,
    ) {
        let how = StreamPlay { open, buffer, choice: ContainerChoice::Fullest, closing };
        let mut supply = Ideal;
        let arriving = Candidate::sequence(items);
        let stream = play_stream(&grid, &mut supply, arriving.clone(), Orders::default(), how).unwrap();
        let found: Told = stream.closed.iter().chain(&stream.open).map(told).collect();
        prop_assert_eq!(found, slowly(&grid, arriving, how));
    }
}

#[test]
fn the_fullest_is_that_with_the_greatest_share_of_its_volume() {
    let fill = |items_m3, container_m3| Fill {
        items_m3,
        container_m3,
    };
    // The first holds most, but is large.
    assert_eq!(fullest(&[fill(2.0, 10.0), fill(1.0, 3.0)]), Some(1));
    assert_eq!(fullest(&[fill(2.0, 10.0), fill(0.5, 3.0)]), Some(0));
    assert_eq!(fullest(&[fill(1.0, 2.0), fill(2.0, 4.0)]), Some(0));
    assert_eq!(fullest(&[]), None);
}

#[test]
fn rules_that_do_not_go_together_are_refused_with_what_to_do() {
    let shared = ContainerRules::default();
    let none = ClosingRules::default();
    assert_eq!(none.validate(&shared), Ok(()));
    let complete = ClosingRules {
        order_complete: true,
        ..none
    };
    assert_eq!(complete.validate(&shared), Err(ClosingError::SharedOrders));
    let one_order = ContainerRules {
        sharing: Sharing::OneOrder,
        ..ContainerRules::default()
    };
    assert_eq!(complete.validate(&one_order), Ok(()));
    let percent = ClosingRules {
        fill_percent: Some(f64::NAN),
        ..none
    };
    let refused = percent.validate(&shared).unwrap_err();
    assert!(refused.to_string().contains("1 to 100"));
}
