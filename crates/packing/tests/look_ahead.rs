//! Choosing among the items of the buffer by looking ahead.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use std::sync::{Arc, Mutex};
use std::time::Instant;

use ppnpack_packing::check::{BoxedCheck, Cost, ValidityCheck, Verdict};
use ppnpack_packing::chooser::Chooser;
use ppnpack_packing::episode::{IdealCell, Play, play};
use ppnpack_packing::grid::{ContainerSize, Grid, GridSettings};
use ppnpack_packing::heightmap::{Heightmap, Scene};
use ppnpack_packing::item::{Item, ViewSurfaces};
use ppnpack_packing::look_ahead::LookAheadSettings;
use ppnpack_packing::method::{Method, ProposalSource, Stability};
use ppnpack_packing::placement::RestingPlacement;
use ppnpack_packing::plan::{Plan, Planner};
use ppnpack_packing::refusal::Cause;
use ppnpack_packing::step::{Candidate, Evaluated, StageResult, StepInput};
use ppnpack_packing::trial::TrialSettings;

/// 16 x 16 x 10 cm in cells of 1 cm, four yaws.
fn grid() -> Grid {
    let settings = GridSettings {
        container: ContainerSize {
            x_m: 0.16,
            y_m: 0.16,
            z_m: 0.1,
        },
        ..GridSettings::default()
    };
    settings.build().unwrap()
}

/// A box of so many cells and units.
fn block(name: &str, nx: usize, ny: usize, height: i16) -> Arc<Item> {
    let view = |nx: usize, ny: usize| {
        ViewSurfaces::of_cells(nx, ny, vec![height; nx * ny], vec![0; nx * ny])
    };
    let views = vec![view(nx, ny), view(nx, ny), view(ny, nx), view(ny, nx)];
    let volume_m3 = (nx * ny) as f64 * 1e-4 * f64::from(height) * 0.002;
    Arc::new(Item::new(name, views, volume_m3).unwrap())
}

fn mix() -> Vec<Arc<Item>> {
    vec![
        block("plate", 12, 10, 5),
        block("brick", 6, 4, 15),
        block("bar", 3, 12, 10),
        block("cube", 4, 4, 20),
        block("tower", 5, 5, 40),
    ]
}

fn method(look_ahead: LookAheadSettings) -> Method {
    Method {
        proposals: ProposalSource::Bounded,
        stability: Stability::Published,
        trial: TrialSettings::off(),
        look_ahead,
        ..Method::default()
    }
}

/// Through so many futures, without a margin.
fn looking_ahead(futures: usize) -> Method {
    method(LookAheadSettings {
        futures,
        significance: 0.0,
    })
}

/// Simulates nothing, and refuses one item everywhere.
struct Refuses(usize);

impl ValidityCheck for Refuses {
    fn cost(&self) -> Cost {
        Cost::Simulation
    }

    fn judge(
        &mut self,
        _: &StepInput<'_>,
        candidate: &Candidate,
        _: &RestingPlacement,
    ) -> StageResult<Verdict> {
        Ok(Verdict::of(candidate.arrival != self.0, Cause::Unsteady))
    }
}

type Seen = Arc<Mutex<Vec<Vec<Evaluated>>>>;

/// Takes an option by its index, and notes what there was.
struct Takes(Result<usize, &'static str>, Seen);

impl Chooser for Takes {
    fn choose(&mut self, _: &StepInput<'_>, options: &[Evaluated]) -> StageResult<usize> {
        self.1.lock().unwrap().push(options.to_vec());
        Ok(self.0?)
    }
}

fn planner(check: Option<BoxedCheck>) -> Planner {
    let grid = grid();
    let method = method(LookAheadSettings::default());
    let proposer = method.proposer(&grid, None).unwrap();
    method.build_with(&grid, proposer, check, 1).unwrap()
}

fn candidates() -> Vec<Candidate> {
    Candidate::sequence(mix())
}

/// Plans the first step with this chooser; gives the plan, and the options that there were.
fn planned(
    takes: Result<usize, &'static str>,
    check: Option<BoxedCheck>,
) -> (Plan, Vec<Evaluated>) {
    let seen = Seen::default();
    let chooser = Takes(takes, Arc::clone(&seen));
    let mut planner = planner(check).with_chooser(Some(Box::new(chooser)));
    let (grid, candidates) = (grid(), candidates());
    let scene = Scene::from_heightmap(Heightmap::empty(&grid));
    let plan = planner.plan(&StepInput::new(&grid, &scene, &candidates));
    let plan = plan.unwrap().clone();
    let options = seen.lock().unwrap().concat();
    (plan, options)
}

/// The best placement of an item alone, if it has one.
fn best_of(index: usize) -> Option<Evaluated> {
    let (grid, candidates) = (grid(), candidates());
    let scene = Scene::from_heightmap(Heightmap::empty(&grid));
    let alone = std::slice::from_ref(&candidates[index]);
    let mut planner = planner(None);
    let plan = planner.plan(&StepInput::new(&grid, &scene, alone)).unwrap();
    plan.choice().map(|choice| Evaluated {
        candidate: index,
        ..choice
    })
}

#[test]
fn the_options_are_the_greedy_choice_and_the_best_of_each_other_item() {
    let (greedy, options) = planned(Ok(0), None);
    let mut expected: Vec<Evaluated> = (0..mix().len()).filter_map(best_of).collect();
    assert!(expected.len() > 2);
    expected.sort_by(Evaluated::rank_cmp);
    assert_eq!(greedy.choice(), Some(expected[0]));
    let first = expected.remove(0);
    expected.sort_by_key(|option| option.candidate);
    expected.insert(0, first);
    assert_eq!(options, expected);
}

#[test]
fn what_is_chosen_is_made_if_it_is_valid() {
    let (_, options) = planned(Ok(0), None);
    let (plan, _) = planned(Ok(2), None);
    assert_eq!(plan.choice(), Some(options[2]));
    // A simulation that refuses the item everywhere leaves the greedy choice.
    let refused = options[2].candidate;
    let (plan, options) = planned(Ok(2), Some(Box::new(Refuses(refused))));
    assert_eq!(options[2].candidate, refused);
    assert_eq!(plan.choice(), Some(options[0]));
    assert!(plan.degraded().is_empty());
}

#[test]
fn a_chooser_that_fails_leaves_the_greedy_choice_and_it_is_said() {
    let (plan, options) = planned(Err("no futures today"), None);
    assert_eq!(plan.choice(), Some(options[0]));
    assert!(plan.degraded()[0].contains("no futures today"));
}

#[test]
fn any_number_of_threads_chooses_the_same_and_leaves_the_greedy_choice_at_times() {
    let grid = grid();
    let sequence = || {
        let items = mix();
        Candidate::sequence((0..30).map(move |at| Arc::clone(&items[at * 7 % 5])))
    };
    let packed = |futures: usize, threads: usize| {
        let method = looking_ahead(futures);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = (threads > 1).then(|| Arc::new(pool.build().unwrap()));
        let chooser = method.chooser(&grid, &mix(), pool).unwrap();
        let mut planner = planner(None).with_chooser(chooser);
        let mut cell = IdealCell::new(&grid);
        let how = Play::with_buffer(4);
        let episode = play(&grid, &mut planner, &mut cell, sequence(), how, &mut ()).unwrap();
        let steps = episode.steps.iter();
        steps
            .map(|step| (step.candidate.arrival, step.choice))
            .collect::<Vec<_>>()
    };
    let expected = packed(6, 1);
    assert_eq!(packed(6, 3), expected);
    assert_eq!(packed(6, 8), expected);
    assert_ne!(packed(0, 1), expected);
}

#[test]
fn a_step_without_time_is_decided_by_the_objective() {
    let (grid, candidates) = (grid(), candidates());
    let scene = Scene::from_heightmap(Heightmap::empty(&grid));
    let chooser = looking_ahead(4).chooser(&grid, &mix(), None).unwrap();
    let options: Vec<Evaluated> = (0..3).filter_map(best_of).collect();
    let late = StepInput {
        deadline: Some(Instant::now()),
        ..StepInput::new(&grid, &scene, &candidates)
    };
    let refused = chooser.unwrap().choose(&late, &options).unwrap_err();
    assert!(refused.to_string().contains("time limit"));
}

#[test]
fn nothing_is_looked_ahead_without_futures_or_items_that_may_arrive() {
    let grid = grid();
    assert!(
        looking_ahead(0)
            .chooser(&grid, &mix(), None)
            .unwrap()
            .is_none()
    );
    assert!(
        looking_ahead(4)
            .chooser(&grid, &[], None)
            .unwrap()
            .is_none()
    );
}
