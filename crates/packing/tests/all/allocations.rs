//! A step allocates nothing once its buffers have grown.

use ppnpack_packing::checks::stability::PhysicalStability;

use crate::support::*;

#[test]
fn a_step_allocates_nothing_after_warm_up() {
    let grid = Grid::reference();
    let mut half_full = Heightmap::empty(&grid);
    for (x, y, height) in (0..32).flat_map(|x| (0..32).map(move |y| (x, y, 10 * (x % 5 + y % 3)))) {
        half_full.raise(x, y, height as Units);
    }
    let mut changed = half_full.clone();
    changed.raise(3, 4, 60);
    let scenes = [Heightmap::empty(&grid), half_full, changed].map(Scene::from_heightmap);
    let kinds = (3..12).map(|size| block(&grid, [size, size + 1], 4 * size as Units));
    let kinds: Vec<Arc<Item>> = kinds.collect();
    let steps: Vec<Vec<Candidate>> = (0..12)
        .map(|step| {
            let held = (0..5).map(|slot| kinds[(step + slot) % kinds.len()].clone());
            Candidate::sequence(held)
        })
        .collect();
    let all: fn() -> Box<dyn Proposer> = || Box::new(ProposeAll);
    let random: fn() -> Box<dyn Proposer> =
        || Box::new(ProposeRandom::new(Percent::new(5.0).unwrap(), 3));
    for heuristic in HEURISTICS {
        for order in [Order::Balance, Order::BboxVolume, Order::Shuffled] {
            for (source, is_bounded) in [(all, false), (all, true), (random, false)] {
                let search = searching(&grid, heuristic, order, is_bounded);
                let checks: Vec<BoxedCheck> = vec![
                    Box::new(PublishedStability::default()),
                    Box::new(PhysicalStability::new(Default::default())),
                ];
                let mut planner = Planner::new(source(), Box::new(search), checks, order, 1);
                let mut play = || {
                    for (step, candidates) in steps.iter().enumerate() {
                        let scene = &scenes[step % scenes.len()];
                        let input = StepInput {
                            step: step as u64,
                            ..StepInput::new(&grid, scene, candidates)
                        };
                        planner.plan(&input).unwrap();
                    }
                };
                play();
                play();
                let counted = allocation_counter::measure(play);
                let of = format!("{heuristic:?} {order:?}, bounded {is_bounded}");
                assert_eq!(counted.count_total, 0, "{of}: {counted:?}");
            }
        }
    }
}
