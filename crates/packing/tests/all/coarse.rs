//! Coarse proposals against the plain meaning of their regions.

use std::collections::HashSet;

use ppnpack_packing::kernel::item::ItemView;
use ppnpack_packing::ranking::coarse::{CoarseGrid, CoarseToFine, Coarsening};
use ppnpack_packing::ranking::proposals::possible_count;

use crate::support::*;

/// Whether no other coarse corner along a side has a nearer footprint centre; all in cells.
fn is_nearest(
    cells: usize,
    fine: (usize, usize),
    coarse: (usize, usize),
    coarse_cells: usize,
) -> bool {
    let twice_apart =
        |corner: usize| (2 * fine.0 + fine.1).abs_diff((2 * corner + coarse.1) * cells);
    (0..=coarse_cells - coarse.1).all(|other| twice_apart(coarse.0) <= twice_apart(other))
}

fn has_room(grid: &Grid, view: &ItemView) -> bool {
    view.nx() <= grid.nx() && view.ny() <= grid.ny()
}

fn random(percent: f64) -> ProposeRandom {
    ProposeRandom::new(Percent::new(percent).unwrap(), 3)
}

/// What is proposed of a share of what is drawn on the coarse grid.
fn proposed(
    grids: CoarseGrid,
    input: &StepInput<'_>,
    order: Order,
    [percent, wide]: [f64; 2],
) -> Proposals {
    let settings = SearchSettings {
        order,
        ..SearchSettings::default()
    };
    let share = Percent::new(percent).unwrap();
    let wide = Box::new(random(wide));
    let mut proposer = CoarseToFine::new(grids, &settings, share, wide).unwrap();
    let mut proposals = Proposals::default();
    proposer.propose(input, &mut proposals).unwrap();
    proposals
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn regions_partition_all_placements_by_the_nearest_footprint_centre(
        (grid, _, items) in scenes(2),
        cells in 1_usize..4,
    ) {
        let Ok(grids) = CoarseGrid::new(&grid, Coarsening { cells, yaws: 1 }) else {
            return Ok(());
        };
        for item in &items {
            let coarse = grids.item(item).unwrap();
            let mut found = HashSet::new();
            for at in possible_placements(grids.coarse(), &coarse) {
                for fine in grids.region(item.views(), coarse.views(), at) {
                    prop_assert!(found.insert(fine), "{fine:?} belongs to two regions");
                    prop_assert_eq!(fine.yaw, at.yaw);
                    let (view, pooled) = (&item.views()[fine.yaw], &coarse.views()[at.yaw]);
                    let (nx, ny) = (grids.coarse().nx(), grids.coarse().ny());
                    prop_assert!(is_nearest(cells, (fine.x, view.nx()), (at.x, pooled.nx()), nx));
                    prop_assert!(is_nearest(cells, (fine.y, view.ny()), (at.y, pooled.ny()), ny));
                }
            }
            let expected: HashSet<Placement> = possible_placements(&grid, item)
                .filter(|at| has_room(grids.coarse(), &coarse.views()[at.yaw]))
                .collect();
            prop_assert_eq!(found, expected);
        }
    }

    #[test]
    fn all_coarse_placements_propose_all_fine_ones(
        (grid, _, items) in scenes(3),
        cells in 1_usize..4,
        yaws in 1_usize..3,
    ) {
        let Ok(grids) = CoarseGrid::new(&grid, Coarsening { cells, yaws }) else {
            return Ok(());
        };
        let floor = vec![0; grid.nx() * grid.ny()];
        let floor = Heightmap::from_units(grid.nx(), grid.ny(), floor).unwrap();
        let scene = Scene::from_heightmap(floor);
        let held = Candidate::sequence(items);
        let input = StepInput::new(&grid, &scene, &held);
        let coarse: Vec<Item> = held.iter().map(|held| grids.item(&held.item).unwrap()).collect();
        let coarse_grid = grids.coarse().clone();
        let proposals = proposed(grids, &input, Order::Balance, [100.0, 100.0]);
        for (index, coarse) in coarse.iter().enumerate() {
            let CandidateProposals::Some(placements) = proposals.of(index) else {
                prop_assert_eq!(possible_count(&coarse_grid, coarse), 0);
                continue;
            };
            let found: HashSet<_> = placements.iter().copied().collect();
            prop_assert_eq!(found.len(), placements.len());
            // What fits the container and not the coarse one, by a rounded footprint, may be left
            // out.
            let fits = |view| has_room(&coarse_grid, view) && view.fits_at(&coarse_grid, 0);
            if coarse.views().iter().all(fits) {
                let expected = possible_placements(&grid, &held[index].item);
                prop_assert_eq!(found, expected.collect::<HashSet<_>>());
            }
        }
    }

    #[test]
    fn a_shared_budget_goes_to_the_first_of_the_ranking_of_all(
        (grid, heightmap, items) in scenes(3),
        percent in 1.0_f64..100.0,
        wide in 1.0_f64..100.0,
        order in prop_oneof![Just(Order::Balance), Just(Order::Arrival)],
    ) {
        let scene = Scene::from_heightmap(heightmap);
        let held = Candidate::sequence(items);
        let input = StepInput::new(&grid, &scene, &held);
        // On a grid that is no coarser a region is one placement.
        let same = CoarseGrid::new(&grid, Coarsening { cells: 1, yaws: 1 }).unwrap();
        let proposals = proposed(same, &input, order, [percent, wide]);

        let share = Percent::new(percent).unwrap();
        let mut all = Proposals::default();
        random(wide).propose(&input, &mut all).unwrap();
        let wanted = |index: &usize| share.of(all_count(&grid, &held[*index].item)) as usize;
        let everybody: Vec<usize> = (0..held.len()).collect();
        // Where items do not compete, each has its own.
        let together = if order == Order::Balance { held.len() } else { 1 };
        let mut expected = vec![Vec::new(); held.len()];
        for group in everybody.chunks(together) {
            let mut search = searching(&grid, Heuristic::Sdfm, order, false);
            search.rank(&input, group, &all).unwrap();
            for found in rest(&mut search, &input).take(group.iter().map(wanted).sum()) {
                expected[found.candidate].push(found.resting.placement);
            }
        }
        for (index, expected) in expected.iter().enumerate() {
            let expected = match possible_count(&grid, &held[index].item) {
                0 => CandidateProposals::All,
                _ => CandidateProposals::Some(&expected[..]),
            };
            prop_assert_eq!(proposals.of(index), expected);
        }
    }
}
