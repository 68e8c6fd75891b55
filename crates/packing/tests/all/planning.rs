//! Plans over checks that refuse, give up, work ahead or know a last resort, as arm and simulation.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use nalgebra::Isometry3;
use ppnpack_packing::checks::check::LastResort;
use ppnpack_packing::checks::motion::Cycle;
use ppnpack_packing::checks::trial::Settling;
use ppnpack_packing::kernel::item::ShapeId;
use ppnpack_packing::streams::episode::{IdealCell, Play, play};

use crate::support::*;

/// An item, by its arrival, at a place.
type Place = (usize, RestingPlacement);

/// What a check was told and asked, in order.
#[derive(Debug, Clone, PartialEq)]
enum Event {
    Begun,
    Told(Vec<Place>),
    Asked(Place),
    Widened,
}

type Log = Arc<Mutex<Vec<Event>>>;

/// A check that does as it is told.
struct Stub {
    cost: Cost,
    foresight: usize,
    /// By the item's arrival.
    accepts: Box<dyn FnMut(usize, Placement) -> bool + Send>,
    ruled_out: Vec<usize>,
    /// Which item it gives up, and after how many refusals.
    gives_up: Option<(usize, usize)>,
    /// Which of the placements that it refused is its last resort.
    resort: Option<usize>,
    /// Where it is given, refused placements stand for all others of the same x but this.
    open_row: Option<usize>,
    /// Placements looked into together: all told of last but the first; the time is over then.
    known: Option<Vec<RestingPlacement>>,
    /// What it finds out about a placement.
    evidence: fn(&RestingPlacement) -> Evidence,
    /// Since the step began.
    refused: Vec<(usize, ShapeId, RestingPlacement)>,
    log: Log,
}

impl Stub {
    /// As dear as a simulation.
    fn new(log: &Log, accepts: impl FnMut(usize, Placement) -> bool + Send + 'static) -> Self {
        Self {
            cost: Cost::Simulation,
            foresight: 1,
            accepts: Box::new(accepts),
            ruled_out: Vec::new(),
            gives_up: None,
            resort: None,
            open_row: None,
            known: None,
            evidence: found,
            refused: Vec::new(),
            log: Arc::clone(log),
        }
    }

    fn note(&self, event: Event) {
        self.log.lock().unwrap().push(event);
    }
}

/// Evidence that tells the placement.
fn found(resting: &RestingPlacement) -> Evidence {
    let Placement { yaw, x, y } = resting.placement;
    let settling = Settling {
        tilt_rad: yaw as f64,
        slide_m: x as f64,
        disturbance_m: y as f64,
        above_rim_m: 0.0,
        is_still: true,
    };
    Evidence {
        settling: Some(settling),
        ..Evidence::default()
    }
}

fn why() -> Refusal {
    Refusal::because(Cause::Unsteady, "it is refused in the test")
}

impl ValidityCheck for Stub {
    fn cost(&self) -> Cost {
        self.cost
    }

    fn begin(&mut self, _: &StepInput<'_>) -> StageResult {
        self.refused.clear();
        self.note(Event::Begun);
        Ok(())
    }

    fn rules_out(&mut self, _: &StepInput<'_>, held: &Candidate) -> StageResult<Option<Refusal>> {
        Ok(self.ruled_out.contains(&held.arrival).then(why))
    }

    fn refuses_unseen(
        &self,
        _: &StepInput<'_>,
        _: &Candidate,
        at: &RestingPlacement,
    ) -> Option<Refusal> {
        let row = self.open_row.map(|_| at.placement.x);
        let row = row.filter(|row| Some(*row) != self.open_row)?;
        let mut refused = self.refused.iter();
        refused
            .any(|(_, _, other)| other.placement.x == row)
            .then(why)
    }

    fn judge(
        &mut self,
        _: &StepInput<'_>,
        held: &Candidate,
        resting: &RestingPlacement,
    ) -> StageResult<Verdict> {
        assert!(!self.ruled_out.contains(&held.arrival));
        let mut known = self.known.iter();
        assert!(
            known.all(|known| known.contains(resting)),
            "nobody looked into it"
        );
        self.note(Event::Asked((held.arrival, *resting)));
        if (self.accepts)(held.arrival, resting.placement) {
            return Ok(Verdict::Accepted((self.evidence)(resting)));
        }
        let refused = (held.arrival, held.item.shape(), *resting);
        self.refused.push(refused);
        Ok(Verdict::Refused(why()))
    }

    fn foresight(&self) -> usize {
        self.foresight
    }

    fn foresee(
        &mut self,
        input: &StepInput<'_>,
        next: &[(&Candidate, RestingPlacement)],
    ) -> StageResult {
        if let Some(known) = &mut self.known {
            *known = next.iter().skip(1).map(|(_, resting)| *resting).collect();
            while input.deadline.is_some_and(|until| Instant::now() < until) {
                std::thread::yield_now();
            }
        }
        let next = next.iter().map(|(held, resting)| (held.arrival, *resting));
        self.note(Event::Told(next.collect()));
        Ok(())
    }

    fn is_known(&self, _: &Candidate, resting: &RestingPlacement) -> bool {
        let mut known = self.known.iter();
        known.any(|known| known.contains(resting))
    }

    fn widen(&mut self) {
        self.note(Event::Widened);
        self.gives_up = None;
    }

    fn is_done_with(&self, candidate: &Candidate) -> bool {
        let refused = self.refused.iter();
        let of_it = refused.filter(|(arrival, ..)| *arrival == candidate.arrival);
        let refusals = of_it.count();
        self.gives_up
            .is_some_and(|(arrival, after)| arrival == candidate.arrival && refusals >= after)
    }

    fn last_resort(&self) -> Option<LastResort> {
        let (arrival, shape, resting) = *self.refused.get(self.resort?)?;
        Some(LastResort {
            arrival,
            shape,
            resting,
            evidence: (self.evidence)(&resting),
        })
    }
}

fn events(log: &Log) -> Vec<Event> {
    log.lock().unwrap().clone()
}

fn asked(log: &Log) -> Vec<Place> {
    let asked = events(log).into_iter().filter_map(|event| match event {
        Event::Asked(place) => Some(place),
        _ => None,
    });
    asked.collect()
}

/// How often it was asked about placements of an item.
fn questions(log: &Log, arrival: usize) -> usize {
    asked(log).iter().filter(|(of, _)| *of == arrival).count()
}

/// Whether it was asked only about placements that it was told of last, in that order.
fn was_told_before(log: &Log) -> bool {
    let mut told = Vec::new().into_iter();
    events(log).into_iter().all(|event| match event {
        Event::Told(next) => {
            told = next.into_iter();
            true
        }
        // Those before it are passed by.
        Event::Asked(place) => told.any(|next| next == place),
        Event::Begun | Event::Widened => true,
    })
}

/// Counts what is asked of a search, and does not leave out what it should.
struct Watched(Search, Arc<[AtomicUsize; 2]>);

impl Evaluator for Watched {
    fn rank(&mut self, input: &StepInput<'_>, group: &[usize], of: &Proposals) -> StageResult {
        self.1[0].fetch_add(1, Ordering::Relaxed);
        self.0.rank(input, group, of)
    }

    fn next_best(&mut self, input: &StepInput<'_>) -> StageResult<Option<Evaluated>> {
        self.1[1].fetch_add(1, Ordering::Relaxed);
        self.0.next_best(input)
    }

    fn counts(&self, candidate: usize) -> PlacementCounts {
        self.0.counts(candidate)
    }
}

/// Proposes for each candidate the corner of the container alone.
struct ProposeCorner;

impl Proposer for ProposeCorner {
    fn propose(&mut self, input: &StepInput<'_>, proposals: &mut Proposals) -> StageResult {
        proposals.clear();
        for _ in input.candidates {
            proposals.push([Placement { yaw: 0, x: 0, y: 0 }]);
        }
        Ok(())
    }
}

fn planner_of(
    evaluator: impl Evaluator + 'static,
    proposer: impl Proposer + 'static,
    order: Order,
    checks: Vec<BoxedCheck>,
) -> Planner {
    Planner::new(Box::new(proposer), Box::new(evaluator), checks, order, 1)
}

/// A planner that searches all placements, which these have to accept.
fn searching_all(grid: &Grid, order: Order, stubs: Vec<Stub>) -> Planner {
    let search = searching(grid, Heuristic::Sdfm, order, false);
    let checks = stubs.into_iter();
    let checks = checks.map(|stub| -> BoxedCheck { Box::new(stub) });
    planner_of(search, ProposeAll, order, checks.collect())
}

/// A planner that searches all placements, with the published test before the stub.
fn testing(grid: &Grid, order: Order, is_bounded: bool, stub: Stub) -> Planner {
    let search = searching(grid, Heuristic::Sdfm, order, is_bounded);
    let checks: Vec<BoxedCheck> = vec![Box::new(stub), Box::new(PublishedStability::default())];
    planner_of(search, ProposeAll, order, checks)
}

/// A step of such a planner.
fn planned(input: &StepInput<'_>, order: Order, is_bounded: bool, stub: Stub) -> Plan {
    let mut planner = testing(input.grid, order, is_bounded, stub);
    planner.plan(input).unwrap().clone()
}

/// The choice and the alternatives.
fn ranked(plan: &Plan) -> Vec<Evaluated> {
    let choice = plan.choice().into_iter();
    choice.chain(plan.alternatives().copied()).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn working_ahead_changes_no_decision_and_nothing_is_asked_that_was_not_told(
        (grid, heightmap, items) in scenes(3),
        order in proptest::sample::select(&[Order::Balance, Order::BboxVolume, Order::Arrival][..]),
        alternatives in 0_usize..4,
        // One in so many placements is accepted.
        one_in in 1_usize..12,
    ) {
        let scene = Scene::from_heightmap(heightmap);
        let held = Candidate::sequence(items);
        let input = StepInput { alternatives, ..StepInput::new(&grid, &scene, &held) };
        let accepts = move |arrival: usize, Placement { yaw, x, y }: Placement| {
            (arrival + 3 * yaw + 5 * x + 7 * y).is_multiple_of(one_in)
        };
        let decided = |foresight: usize, is_bounded: bool| {
            let log = Log::default();
            let stub = Stub { foresight, ..Stub::new(&log, accepts) };
            let plan = planned(&input, order, is_bounded, stub);
            for event in events(&log) {
                if let Event::Told(next) = event {
                    assert!(foresight > 1 && next.len() <= foresight);
                }
            }
            assert!(foresight == 1 || was_told_before(&log));
            (ranked(&plan), plan.evidence().cloned(), asked(&log))
        };
        let expected = decided(1, false);
        prop_assert_eq!(&expected.1, &expected.0.first().map(|best| found(&best.resting)));
        for foresight in [1, 2, 3, 16] {
            for is_bounded in [false, true] {
                prop_assert_eq!(&decided(foresight, is_bounded), &expected);
            }
        }
    }

    #[test]
    fn what_has_no_valid_placement_is_not_searched_again_while_others_arrive(
        (grid, heightmap, items) in scenes(6),
        order in proptest::sample::select(&[Order::Balance, Order::BboxVolume, Order::Arrival][..]),
        valid in 0_usize..7,
        is_bounded in any::<bool>(),
    ) {
        let scene = Scene::from_heightmap(heightmap);
        let held = Candidate::sequence(items);
        let stub = |log: &Log| Stub {
            foresight: 2,
            ..Stub::new(log, move |arrival, at| arrival == valid && at.x > 0)
        };
        let log = Log::default();
        let mut planner = testing(&grid, order, is_bounded, stub(&log));
        for buffer in held.windows(held.len().min(3)) {
            let input = StepInput { alternatives: 1, ..StepInput::new(&grid, &scene, buffer) };
            let others = &buffer[..buffer.len() - 1];
            let asked = || others.iter().map(|held| questions(&log, held.arrival)).sum::<usize>();
            let before = asked();
            let plan = planner.plan(&input).unwrap();
            let expected = planned(&input, order, is_bounded, stub(&Log::default()));
            prop_assert_eq!(ranked(plan), ranked(&expected));
            if plan.choice().is_none() {
                prop_assert_eq!(plan.candidates(), expected.candidates());
            }
            if buffer[0].arrival > 0 {
                prop_assert_eq!(asked(), before);
            }
            if plan.choice().is_some() {
                break;
            }
        }
        // In another scene it is.
        let empty = empty(&grid);
        let input = StepInput::new(&grid, &empty, &held[..1]);
        let expected = planned(&input, order, is_bounded, stub(&Log::default()));
        prop_assert_eq!(ranked(planner.plan(&input).unwrap()), ranked(&expected));
    }

    #[test]
    fn a_widened_step_finds_the_one_placement_that_is_valid(
        seed in any::<u64>(),
        (x, y) in (0_usize..13, 0_usize..13),
        foresight in 1_usize..6,
        is_bounded in any::<bool>(),
    ) {
        let grid = small_grid();
        let scene = empty(&grid);
        let held = blocks(2);
        let input = StepInput::new(&grid, &scene, &held);
        let valid = Placement { yaw: 0, x, y };
        let mut proposer = ProposeRandom::new(Percent::new(2.0).unwrap(), seed);
        let mut proposals = Proposals::default();
        proposer.propose(&input, &mut proposals).unwrap();
        let CandidateProposals::Some(placements) = proposals.of(1) else { panic!("all") };
        let is_proposed = placements.contains(&valid);
        let log = Log::default();
        // The other item is given up on the way.
        let stub = Stub {
            foresight,
            gives_up: Some((0, 3)),
            ..Stub::new(&log, move |arrival, at| (arrival, at) == (1, valid))
        };
        let search = searching(&grid, Heuristic::Sdfm, Order::Balance, is_bounded);
        let mut planner = planner_of(search, proposer, Order::Balance, vec![Box::new(stub)]);
        let plan = planner.plan(&input).unwrap();
        prop_assert_eq!(plan.is_widened(), !is_proposed);
        let choice = plan.choice().unwrap();
        prop_assert_eq!((choice.candidate, choice.resting.placement), (1, valid));
        prop_assert!(plan.degraded().is_empty());
        prop_assert!(foresight == 1 || was_told_before(&log));
        // Each plan begins once and before all else, however many searches it takes.
        let events = events(&log);
        let count = |wanted| events.iter().filter(|event| **event == wanted).count();
        prop_assert_eq!((&events[0], count(Event::Begun)), (&Event::Begun, 1));
        prop_assert_eq!(count(Event::Widened), usize::from(!is_proposed));
    }

    #[test]
    fn planning_without_those_that_are_ruled_out_is_the_same_plan(
        (grid, heightmap, items) in scenes(4),
        ruled_out in proptest::sample::subsequence(vec![0, 1, 2, 3], 0..=4),
        order in proptest::sample::select(&[Order::Balance, Order::BboxVolume, Order::Arrival][..]),
    ) {
        let scene = Scene::from_heightmap(heightmap);
        let held = Candidate::sequence(items);
        let others = held.iter().filter(|held| !ruled_out.contains(&held.arrival));
        let others: Vec<Candidate> = others.cloned().collect();
        let input = StepInput { step: 3, alternatives: 2, ..StepInput::new(&grid, &scene, &held) };
        let planned = |input: &StepInput<'_>| {
            let ruled_out = ruled_out.clone();
            let stub = Stub { ruled_out, ..Stub::new(&Log::default(), |_, at| at.x > 0) };
            planned(input, order, false, stub)
        };
        let plan = planned(&input);
        let expected = planned(&StepInput { candidates: &others, ..input });
        let chosen = |plan: &Plan, held: &[Candidate]| -> Vec<_> {
            let ranked = ranked(plan).into_iter();
            ranked.map(|found| (held[found.candidate].arrival, found.resting, found.value)).collect()
        };
        prop_assert_eq!(chosen(&plan, &held), chosen(&expected, &others));
        let mut reports = expected.candidates().iter();
        for (report, candidate) in plan.candidates().iter().zip(&held) {
            if ruled_out.contains(&candidate.arrival) {
                prop_assert_eq!(&report.reason, &Some(Reason::Rejected(why())));
                prop_assert_eq!(report.refusals.total(), 0);
            } else {
                prop_assert_eq!(Some(report), reports.next());
            }
        }
    }
}

#[test]
fn a_candidate_that_the_check_is_done_with_is_left_out_and_the_others_are_searched() {
    let grid = small_grid();
    let (scene, held) = (empty(&grid), blocks(2));
    // More than there are, so that the step looks at all that is left.
    let input = StepInput {
        alternatives: 10 * PLACES,
        ..StepInput::new(&grid, &scene, &held)
    };
    for (foresight, is_bounded) in [(1, false), (1, true), (5, false), (5, true)] {
        let log = Log::default();
        let stub = |log: &Log| Stub {
            foresight,
            gives_up: Some((0, 7)),
            ..Stub::new(log, |arrival, _| arrival == 1)
        };
        let plan = planned(&input, Order::Balance, is_bounded, stub(&log));
        assert_eq!((questions(&log, 0), questions(&log, 1)), (7, PLACES));
        let found = ranked(&plan);
        assert_eq!(found.len(), PLACES);
        assert!(found.iter().all(|found| found.candidate == 1));
        // An evaluator that leaves nothing out leads to the same plan.
        let search = searching(&grid, Heuristic::Sdfm, Order::Balance, is_bounded);
        let watched = Watched(search, Arc::default());
        let checks: Vec<BoxedCheck> = vec![Box::new(stub(&Log::default()))];
        let mut other = planner_of(watched, ProposeAll, Order::Balance, checks);
        assert_eq!(ranked(other.plan(&input).unwrap()), found);
        let [left_out, other] = plan.candidates() else {
            panic!("{:?}", plan.candidates());
        };
        assert_eq!(left_out.reason, Some(Reason::Rejected(why())));
        assert_eq!((left_out.refusals.total(), &other.reason), (7, &None));
        assert!(plan.degraded().is_empty() && !plan.is_cut());
    }
    // In an order of their own, it makes room for the next.
    let log = Log::default();
    let stub = Stub {
        gives_up: Some((0, 4)),
        ..Stub::new(&log, |arrival, _| arrival == 1)
    };
    let input = StepInput::new(&grid, &scene, &held);
    let plan = planned(&input, Order::Arrival, false, stub);
    assert_eq!(plan.choice().unwrap().candidate, 1);
    assert_eq!((questions(&log, 0), questions(&log, 1)), (4, 1));
    assert_eq!(plan.candidates()[0].reason, Some(Reason::Rejected(why())));
}

#[test]
fn the_last_resort_is_made_where_all_is_refused_and_there_alone() {
    let grid = small_grid();
    let (scene, held) = (empty(&grid), blocks(2));
    let input = StepInput {
        alternatives: 2,
        ..StepInput::new(&grid, &scene, &held[..1])
    };
    let best = Stub::new(&Log::default(), |_, _| true);
    let best = ranked(&planned(&input, Order::Balance, false, best));
    for (foresight, is_bounded) in [(1, false), (1, true), (4, false), (4, true)] {
        let plan = |resort, ruled_out: &[usize], valid: Option<Placement>| {
            let stub = Stub {
                foresight,
                resort,
                ruled_out: ruled_out.to_vec(),
                ..Stub::new(&Log::default(), move |_, at| Some(at) == valid)
            };
            let input = StepInput::new(&grid, &scene, &held[..=ruled_out.len()]);
            let plan = planned(&input, Order::Balance, is_bounded, stub);
            assert!(plan.degraded().is_empty() && !plan.is_cut());
            plan
        };
        let made = plan(Some(2), &[], None);
        assert_eq!(ranked(&made), best[2..]);
        assert_eq!(made.evidence(), Some(&found(&best[2].resting)));
        assert_eq!(made.refusals().total(), PLACES as u64);
        let none = plan(None, &[], None);
        assert_eq!((none.choice(), none.evidence()), (None, None));
        assert_eq!(none.candidates()[0].reason, Some(Reason::Rejected(why())));
        let far = Placement { yaw: 0, x: 6, y: 6 };
        let valid = plan(Some(0), &[], Some(far)).choice().unwrap();
        assert_eq!(valid.resting.placement, far, "it is valid");
        // It is of the right candidate where another is ruled out.
        let expected = Evaluated {
            candidate: 1,
            ..best[0]
        };
        assert_eq!(plan(Some(0), &[0], None).choice(), Some(expected));
    }
}

#[test]
fn the_arms_cycle_goes_with_the_last_resort() {
    let grid = small_grid();
    let (scene, held) = (empty(&grid), blocks(1));
    let input = StepInput::new(&grid, &scene, &held);
    let stub = Stub {
        resort: Some(2),
        ..Stub::new(&Log::default(), |_, _| false)
    };
    let moving = |_: &RestingPlacement| Evidence {
        cycle: Some(Arc::new(Cycle {
            arm: "an arm".to_owned(),
            cycle_s: 2.0,
            container_from_item_at_pick: Isometry3::identity(),
            grasp_yaw_rad: 0.0,
            grip_s: 0.2,
            release_s: 0.2,
            legs: Vec::new(),
        })),
        ..Evidence::default()
    };
    let arm = Stub {
        cost: Cost::Motion,
        evidence: moving,
        ..Stub::new(&Log::default(), |_, _| true)
    };
    let mut planner = searching_all(&grid, Order::Balance, vec![stub, arm]);
    let evidence = planner.plan(&input).unwrap().evidence().cloned().unwrap();
    assert_eq!(evidence.cycle.unwrap().arm, "an arm");
    assert!(evidence.settling.is_some());
}

#[test]
fn the_refusals_of_a_widened_step_are_those_of_both_searches() {
    let grid = small_grid();
    let (scene, held) = (empty(&grid), blocks(2));
    let stub = Stub {
        cost: Cost::Motion,
        ruled_out: vec![1],
        ..Stub::new(&Log::default(), |_, at| at.x > 0)
    };
    let search = searching(&grid, Heuristic::Sdfm, Order::Balance, false);
    let mut planner = planner_of(search, ProposeCorner, Order::Balance, vec![Box::new(stub)]);
    // The second candidate is ruled out, which makes no difference.
    for held in [&held[..1], &held[..]] {
        let plan = planner.plan(&StepInput::new(&grid, &scene, held)).unwrap();
        assert!(plan.is_widened() && plan.choice().is_some());
        let of_second_search = plan.candidates().iter();
        let of_second_search: u64 = of_second_search.map(|it| it.refusals.total()).sum();
        assert!(of_second_search > 0);
        assert_eq!(plan.refusals().total(), 1 + of_second_search);
    }
    let (mut cell, how) = (IdealCell::new(&grid), Play::with_buffer(2));
    let episode = play(&grid, &mut planner, &mut cell, held, how, &mut ()).unwrap();
    assert_eq!(episode.steps.len(), 1, "{:?}", episode.ending);
    assert_eq!(episode.steps[0].refusals, episode.refusals);
    assert!(episode.refusals.total() > 1);
}

/// A planner that refuses the first placements, slowly; and counts of rankings and placements.
fn reluctant(refusals: u64, takes: Duration, log: &Log) -> (Planner, Arc<[AtomicUsize; 2]>) {
    let mut left = refusals;
    let stub = Stub::new(log, move |_, _| {
        std::thread::sleep(takes);
        left = left.saturating_sub(1);
        left == 0
    });
    let asked: Arc<[AtomicUsize; 2]> = Arc::default();
    let search = searching(&small_grid(), Heuristic::Sdfm, Order::Balance, true);
    let watched = Watched(search, Arc::clone(&asked));
    let planner = planner_of(watched, ProposeAll, Order::Balance, vec![Box::new(stub)]);
    (planner, asked)
}

#[test]
fn a_placement_after_two_hundred_refusals_costs_one_ranking_and_each_placement_once() {
    let grid = small_grid();
    let (scene, held) = (empty(&grid), blocks(2));
    let log = Log::default();
    let (mut planner, counted) = reluctant(201, Duration::ZERO, &log);
    let plan = planner.plan(&StepInput::new(&grid, &scene, &held)).unwrap();
    assert!(plan.choice().is_some() && !plan.is_cut());
    let refused: u64 = plan.candidates().iter().map(|it| it.refusals.total()).sum();
    let counted = counted
        .each_ref()
        .map(|count| count.load(Ordering::Relaxed));
    assert_eq!((refused, counted, asked(&log).len()), (200, [1, 201], 201));
}

#[test]
fn after_the_deadline_nothing_more_is_checked_and_the_plan_says_so() {
    let grid = small_grid();
    let (scene, held) = (empty(&grid), blocks(1));
    let log = Log::default();
    let (mut planner, _) = reluctant(u64::MAX, Duration::from_millis(5), &log);
    let input = StepInput {
        deadline: Some(Instant::now() + Duration::from_millis(30)),
        ..StepInput::new(&grid, &scene, &held)
    };
    let plan = planner.plan(&input).unwrap();
    assert!(plan.is_cut() && plan.degraded()[0].contains("time limit"));
    assert_eq!(plan.choice(), None);
    assert_eq!(
        plan.candidates()[0].reason,
        None,
        "not everything was tried"
    );
    assert!(asked(&log).len() <= 7);
}

#[test]
fn after_the_deadline_the_best_that_was_looked_into_and_is_valid_is_chosen() {
    let grid = small_grid();
    let (scene, held) = (empty(&grid), blocks(1));
    let input = StepInput::new(&grid, &scene, &held);
    let best = StepInput {
        alternatives: 2,
        ..input
    };
    let mut planner = searching_all(&grid, Order::Balance, Vec::new());
    let best = ranked(planner.plan(&best).unwrap());
    let limited = StepInput {
        deadline: Some(Instant::now() + Duration::from_millis(200)),
        ..input
    };
    let second = best[1].resting.placement;
    let together = Stub {
        foresight: 4,
        known: Some(Vec::new()),
        ..Stub::new(&Log::default(), move |_, at| at != second)
    };
    let mut planner = searching_all(&grid, Order::Balance, vec![together]);
    let plan = planner.plan(&limited).unwrap();
    assert_eq!(plan.choice(), Some(best[2]));
    assert!(plan.is_cut() && plan.degraded()[0].contains("time limit"));
}

#[test]
fn after_the_deadline_the_best_untried_placement_is_chosen_only_where_that_is_asked_for() {
    let grid = small_grid();
    let (scene, held) = (empty(&grid), blocks(1));
    let input = StepInput::new(&grid, &scene, &held);
    let mut planner = searching_all(&grid, Order::Balance, Vec::new());
    let best = planner.plan(&input).unwrap().choice();
    for (cost, takes_untried, expected) in [
        (Cost::Simulation, true, best),
        (Cost::Simulation, false, None),
        (Cost::Motion, true, None),
    ] {
        let slow = Stub {
            cost,
            ..Stub::new(&Log::default(), |_, _| {
                std::thread::sleep(Duration::from_millis(60));
                false
            })
        };
        let mut planner = searching_all(&grid, Order::Balance, vec![slow]);
        let plan = planner
            .plan(&StepInput {
                deadline: Some(Instant::now() + Duration::from_millis(50)),
                takes_untried,
                ..input
            })
            .unwrap();
        assert_eq!(plan.choice(), expected, "{cost:?}, {takes_untried}");
        let says_so = plan.degraded().iter().any(|why| why.contains("not stay"));
        assert!(plan.is_cut() && says_so == expected.is_some());
    }
}

#[test]
fn what_is_refused_unseen_is_not_asked_of_the_arm_and_counts_as_refused() {
    let grid = small_grid();
    let (scene, held) = (empty(&grid), blocks(1));
    let input = StepInput {
        // So that the step goes on to the last placement.
        alternatives: 1,
        ..StepInput::new(&grid, &scene, &held)
    };
    let accepted = Placement { yaw: 0, x: 5, y: 7 };
    let step = |foresight: usize, open_row: Option<usize>| {
        let log = Log::default();
        let arm = Stub {
            cost: Cost::Motion,
            ..Stub::new(&log, |_, _| true)
        };
        let trial = Stub {
            foresight,
            open_row,
            ..Stub::new(&Log::default(), move |_, at| at == accepted)
        };
        let mut planner = searching_all(&grid, Order::Arrival, vec![trial, arm]);
        let plan = planner.plan(&input).unwrap();
        let choice = plan.choice().map(|choice| choice.resting.placement);
        (choice, plan.candidates()[0].clone(), asked(&log).len())
    };
    let (choice, report, asked) = step(1, None);
    assert_eq!((choice, asked), (Some(accepted), PLACES));
    for foresight in [1, 4] {
        let (other_choice, other_report, asked) = step(foresight, Some(accepted.x));
        assert_eq!(other_choice, choice);
        assert_eq!(other_report.refusals, report.refusals);
        // The first of each other row, what is looked at ahead, and the row of the accepted one.
        let most = (SIDE - 1) * foresight + SIDE;
        assert!((2 * SIDE - 1..=most).contains(&asked), "{asked}");
    }
}
