//! The best-first search against a full sort, its caches, threads, bounds and proposals.

use ppnpack_packing::checks::check::Fits;
use ppnpack_packing::planning::survey::survey;
use ppnpack_packing::ranking::proposals::possible_count;

use crate::support::*;

fn settings(heuristic: Heuristic) -> SearchSettings {
    SearchSettings {
        heuristic,
        seed: 7,
        ..SearchSettings::default()
    }
}

fn heuristics() -> impl Strategy<Value = Heuristic> {
    proptest::sample::select(&HEURISTICS[..])
}

/// The content, where what reaches the rim is as high as items may reach.
fn walled(grid: &Grid, heightmap: &Heightmap, above_rim: Units) -> Heightmap {
    let mut walled = heightmap.clone();
    for (x, y) in (0..grid.nx()).flat_map(|x| (0..grid.ny()).map(move |y| (x, y))) {
        if heightmap.get(x, y).unwrap() >= grid.rim() {
            walled.raise(x, y, grid.rim() + above_rim);
        }
    }
    walled
}

/// The value of every placement that does not reach too high, sorted.
fn sorted(
    input: &StepInput<'_>,
    heuristic: Heuristic,
    weights: &Weights,
    above_rim: Units,
) -> Vec<f64> {
    let rim = input.grid.rim();
    let heightmap = &walled(input.grid, input.scene.heightmap(), above_rim);
    let views = input.candidates.iter().flat_map(|held| held.item.views());
    let values = views.flat_map(|view| {
        let surveyed = survey(input.grid, heightmap, view, heuristic, weights);
        let mut surveyed = surveyed.unwrap();
        surveyed.retain(|found| {
            let top = found.resting_height + view.height();
            view.height() <= rim && top <= rim + above_rim && found.resting_height < rim
        });
        surveyed.into_iter().map(|found| found.value)
    });
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(384))]

    #[test]
    fn the_search_gives_what_a_full_sort_gives(
        (grid, heightmap, items) in scenes(3),
        heuristic in proptest::sample::select(&HEURISTICS[..4]),
        weights in weights(),
        above_rim in prop_oneof![Just(0), 1_i16..12],
    ) {
        let scene = Scene::from_heightmap(heightmap);
        let held = Candidate::sequence(items);
        let input = StepInput::new(&grid, &scene, &held);
        let above_rim_m = f64::from(above_rim) * grid.resolution().height_unit_m();
        let settings = SearchSettings { weights, above_rim_m, ..settings(heuristic) };
        let mut search = Search::new(&grid, &settings).unwrap();
        let found = ranking(&mut search, &input, &all(&input));
        let expected = sorted(&input, heuristic, &weights, above_rim);
        let values: Vec<f64> = found.iter().map(|found| found.value).collect();
        prop_assert_eq!(values, expected);
        // Equal values come by candidate, yaw, x, y.
        prop_assert!(found.is_sorted_by(|one, other| one.rank_cmp(other).is_lt()));
    }

    #[test]
    fn levels_blocks_proposals_and_earlier_steps_give_one_ranking(
        (grid, first, items) in scenes(4),
        change in proptest::collection::vec((0_usize..14, 0_usize..14, 0_i16..60), 0..5),
        heuristic in heuristics(),
        order in proptest::sample::select(&[Order::Balance, Order::Arrival][..]),
        weights in weights(),
        percent in 1.0_f64..100.0,
        above_rim_m in prop_oneof![Just(0.0), 0.001..0.05],
    ) {
        let mut second = first.clone();
        for (x, y, height) in change {
            second.raise(x, y, height);
        }
        let held = Candidate::sequence(items);
        let settings = SearchSettings { weights, order, above_rim_m, ..settings(heuristic) };
        let search = || Search::new(&grid, &settings).unwrap();
        let mut kept = [search(), search().bounded()];
        let scenes = [first, second.clone(), second].map(Scene::from_heightmap);
        for (step, scene) in scenes.iter().enumerate() {
            // The buffer changes from step to step too.
            let held = &held[step.min(held.len() - 1)..];
            let input = StepInput { step: step as u64, ..StepInput::new(&grid, scene, held) };
            // Every placement by name, backwards, and the first ones again.
            let mut named = Proposals::default();
            for candidate in held {
                let mut placements: Vec<_> = possible_placements(&grid, &candidate.item).collect();
                placements.reverse();
                placements.extend_from_within(..placements.len().min(5));
                named.push(placements);
            }
            // All placements of the first candidate, some of the second.
            let mut random = Proposals::default();
            ProposeRandom::new(Percent::new(percent).unwrap(), 5).propose(&input, &mut random).unwrap();
            let mut mixed = Proposals::default();
            mixed.push_all();
            if let CandidateProposals::Some(placements) = random.of(1) {
                mixed.push(placements.iter().copied());
            }
            let mut fresh = search();
            let bits = |ranked: &[Evaluated]| -> Vec<u64> {
                ranked.iter().map(|found| found.value.to_bits()).collect()
            };
            for (proposals, same) in [(&all(&input), &all(&input)), (&named, &all(&input)), (&mixed, &mixed)] {
                let expected = ranking(&mut fresh, &input, same);
                for search in &mut kept {
                    let found = ranking(search, &input, proposals);
                    prop_assert_eq!(&found, &expected);
                    prop_assert_eq!(bits(&found), bits(&expected));
                    for candidate in 0..held.len() {
                        prop_assert_eq!(search.counts(candidate), fresh.counts(candidate));
                    }
                }
            }
            // The order of the group does not matter either.
            let expected = ranking(&mut fresh, &input, &all(&input));
            let group: Vec<usize> = (0..held.len()).rev().collect();
            kept[1].rank(&input, &group, &all(&input)).unwrap();
            prop_assert_eq!(rest(&mut kept[1], &input).collect::<Vec<_>>(), expected);
        }
    }

    #[test]
    fn proposals_are_ranked_like_all_placements_restricted_to_them(
        (grid, heightmap, items) in scenes(3),
        heuristic in heuristics(),
        percent in 1.0_f64..100.0,
    ) {
        let scene = Scene::from_heightmap(heightmap);
        let held = Candidate::sequence(items);
        let input = StepInput { step: 3, ..StepInput::new(&grid, &scene, &held) };
        let mut proposals = Proposals::default();
        let share = Percent::new(percent).unwrap();
        ProposeRandom::new(share, 5).propose(&input, &mut proposals).unwrap();
        let proposed = |found: &Evaluated| match proposals.of(found.candidate) {
            CandidateProposals::All => true,
            CandidateProposals::Some(placements) => placements.contains(&found.resting.placement),
        };
        let mut search = searching(&grid, heuristic, Order::Balance, false);
        let mut expected = ranking(&mut search, &input, &all(&input));
        expected.retain(proposed);
        prop_assert_eq!(ranking(&mut search, &input, &proposals), expected);
        for (index, candidate) in held.iter().enumerate() {
            let possible = possible_count(&grid, &candidate.item);
            let counts = search.counts(index);
            if candidate.item.views().iter().any(|view| view.height() <= grid.rim()) {
                prop_assert_eq!(counts.possible, possible);
            }
            let wanted = share.of(all_count(&grid, &candidate.item));
            prop_assert_eq!(counts.proposed, wanted.min(possible));
        }
        // What repeats counts once, what leaves the container not at all.
        let placements: Vec<Placement> = possible_placements(&grid, &held[0].item).collect();
        let outside = [(0, grid.nx(), 0), (0, 0, usize::MAX), (grid.resolution().yaws().count(), 0, 0)];
        let outside = outside.map(|(yaw, x, y)| Placement { yaw, x, y });
        proposals.clear();
        proposals.push(placements.iter().chain(&outside).chain(&placements).copied());
        search.rank(&input, &[0], &proposals).unwrap();
        prop_assert_eq!(search.counts(0).proposed, placements.len() as u64);
        let ranked: Vec<Evaluated> = rest(&mut search, &input).collect();
        prop_assert!(ranked.is_sorted_by(|one, other| one.rank_cmp(other).is_lt()));
    }

    #[test]
    fn a_plan_is_the_best_valid_placement_and_says_why_there_is_none(
        (grid, heightmap, items) in scenes(3),
        order in proptest::sample::select(&[Order::Balance, Order::BboxVolume, Order::Arrival, Order::Shuffled][..]),
    ) {
        let scene = Scene::from_heightmap(heightmap);
        let held = Candidate::sequence(items);
        let input = StepInput { alternatives: 2, ..StepInput::new(&grid, &scene, &held) };
        let mut search = searching(&grid, Heuristic::Sdfm, order, false);
        let mut valid = ranking(&mut search, &input, &all(&input));
        let fitting = valid.clone();
        let checks: Vec<BoxedCheck> = vec![Box::new(PublishedStability::default()), Box::new(Fits)];
        let mut planner = Planner::new(Box::new(ProposeAll), Box::new(search), checks, order, 1);
        let plan = planner.plan(&input).unwrap();
        let mut stability = PublishedStability::default();
        valid.retain(|found| {
            let view = &held[found.candidate].item.views()[found.resting.placement.yaw];
            stability.is_stable(&grid, scene.heightmap(), view, &found.resting)
        });
        if order == Order::Balance {
            prop_assert_eq!(plan.choice(), valid.first().copied());
            prop_assert!(plan.alternatives().eq(valid.iter().skip(1).take(2)));
        }
        prop_assert_eq!(plan.choice().is_some(), !valid.is_empty());
        for (index, report) in plan.candidates().iter().enumerate() {
            let of = |ranked: &[Evaluated]| ranked.iter().filter(|found| found.candidate == index).count();
            match &report.reason {
                Some(Reason::Rejected(refusal)) => {
                    prop_assert_eq!(refusal.cause, Cause::UnstableByPublishedTest);
                    prop_assert!(of(&fitting) > 0 && of(&valid) == 0);
                    prop_assert_eq!(report.refusals.total() as usize, of(&fitting));
                }
                Some(_) => prop_assert_eq!(of(&fitting), 0),
                None => prop_assert!(plan.choice().is_some()),
            }
        }
    }
}

#[test]
fn random_placements_are_spread_over_all_valid_ones() {
    let grid = Grid::reference();
    let scene = empty(&grid);
    let held = Candidate::sequence([block(&grid, [2, 2], 3)]);
    let mut search = searching(&grid, Heuristic::Random, Order::Shuffled, false);
    let mut quadrants = [0; 8];
    for step in 0..4000 {
        let input = StepInput {
            step,
            ..StepInput::new(&grid, &scene, &held)
        };
        search.rank(&input, &[0], &all(&input)).unwrap();
        let Placement { yaw, x, y } = search.next_best(&input).unwrap().unwrap().resting.placement;
        quadrants[(yaw / 2) * 4 + (x / 16) * 2 + y / 16] += 1;
    }
    let are_even = quadrants.iter().all(|count| (400..=600).contains(count));
    assert!(are_even, "{quadrants:?}");
}
