//! A check that works ahead, gives candidates up and knows a last resort: what a simulation does, without one.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use std::sync::{Arc, Mutex};

use ppnpack_packing::check::{BoxedCheck, Cost, Evidence, LastResort, ValidityCheck, Verdict};
use ppnpack_packing::evaluator::Evaluator;
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::Scene;
use ppnpack_packing::item::ShapeId;
use ppnpack_packing::objective::Order;
use ppnpack_packing::placement::{Placement, RestingPlacement};
use ppnpack_packing::plan::{Plan, Planner, Reason};
use ppnpack_packing::proposals::{
    CandidateProposals, Percent, Proposals, ProposeAll, ProposeRandom, Proposer,
};
use ppnpack_packing::refusal::{Cause, Refusal};
use ppnpack_packing::search::{Search, SearchSettings};
use ppnpack_packing::stability::PublishedStability;
use ppnpack_packing::step::{Candidate, Evaluated, PlacementCounts, StageResult, StepInput};
use ppnpack_packing::trial::Settling;
use proptest::prelude::*;

mod support;

use support::ProposeCorner;
use support::blocks::{PLACES, blocks, empty, grid};

/// An item, by its arrival, at a place.
type Place = (usize, RestingPlacement);

/// What a check was told and asked, in order.
#[derive(Debug, Clone, PartialEq)]
enum Event {
    Begun,
    /// Whether it rules an item out.
    AskedOf(usize),
    Told(Vec<Place>),
    Asked(Place),
    Widened,
}

type Log = Arc<Mutex<Vec<Event>>>;

/// A check as dear as a simulation.
struct Stub {
    foresight: usize,
    /// By the item's arrival.
    accepts: Box<dyn Fn(usize, Placement) -> bool + Send>,
    ruled_out: Option<usize>,
    /// Which item it gives up, and after how many refusals.
    gives_up: Option<(usize, usize)>,
    /// Which of the placements that it refused is its last resort.
    resort: Option<usize>,
    /// Since the step began.
    refused: Vec<(usize, ShapeId, RestingPlacement)>,
    log: Log,
}

impl Stub {
    fn new(log: &Log, accepts: impl Fn(usize, Placement) -> bool + Send + 'static) -> Self {
        Self {
            foresight: 1,
            accepts: Box::new(accepts),
            ruled_out: None,
            gives_up: None,
            resort: None,
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
        Cost::Simulation
    }

    fn begin(&mut self, _: &StepInput<'_>) -> StageResult {
        self.refused.clear();
        self.note(Event::Begun);
        Ok(())
    }

    fn rules_out(&mut self, _: &StepInput<'_>, held: &Candidate) -> StageResult<Option<Refusal>> {
        self.note(Event::AskedOf(held.arrival));
        Ok((self.ruled_out == Some(held.arrival)).then(why))
    }

    fn judge(
        &mut self,
        _: &StepInput<'_>,
        held: &Candidate,
        resting: &RestingPlacement,
    ) -> StageResult<Verdict> {
        self.note(Event::Asked((held.arrival, *resting)));
        if (self.accepts)(held.arrival, resting.placement) {
            return Ok(Verdict::Accepted(found(resting)));
        }
        self.refused
            .push((held.arrival, held.item.shape(), *resting));
        Ok(Verdict::Refused(why()))
    }

    fn foresight(&self) -> usize {
        self.foresight
    }

    fn foresee(
        &mut self,
        _: &StepInput<'_>,
        next: &[(&Candidate, RestingPlacement)],
    ) -> StageResult {
        let next = next.iter().map(|(held, resting)| (held.arrival, *resting));
        self.note(Event::Told(next.collect()));
        Ok(())
    }

    fn widen(&mut self) -> bool {
        self.note(Event::Widened);
        self.gives_up.take().is_some()
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
            evidence: found(&resting),
        })
    }
}

fn events(log: &Log) -> Vec<Event> {
    log.lock().unwrap().clone()
}

fn asked(events: &[Event]) -> Vec<Place> {
    let asked = events.iter().filter_map(|event| match event {
        Event::Asked(place) => Some(*place),
        _ => None,
    });
    asked.collect()
}

/// How often it was asked about placements of an item.
fn questions(log: &Log, arrival: usize) -> usize {
    let asked = asked(&events(log)).into_iter();
    asked.filter(|(of, _)| *of == arrival).count()
}

/// Whether it was asked only about placements that it was told of last, in that order.
fn was_told_before(events: &[Event]) -> bool {
    let mut told = Vec::new().into_iter();
    events.iter().all(|event| match event {
        Event::Told(next) => {
            told = next.clone().into_iter();
            true
        }
        // Those before it are passed by.
        Event::Asked(place) => told.any(|next| next == *place),
        Event::Begun | Event::AskedOf(_) | Event::Widened => true,
    })
}

fn searching(grid: &Grid, order: Order, is_bounded: bool) -> Search {
    let settings = SearchSettings {
        order,
        ..SearchSettings::default()
    };
    let search = Search::new(grid, &settings).unwrap();
    if is_bounded { search.bounded() } else { search }
}

fn planner(
    evaluator: impl Evaluator + 'static,
    proposer: impl Proposer + 'static,
    order: Order,
    stub: Stub,
) -> Planner {
    let checks: Vec<BoxedCheck> = vec![Box::new(stub), Box::new(PublishedStability::default())];
    Planner::new(Box::new(proposer), Box::new(evaluator), checks, order, 1)
}

/// The choice and the alternatives.
fn ranked(plan: &Plan) -> Vec<Evaluated> {
    let choice = plan.choice().into_iter();
    choice.chain(plan.alternatives().copied()).collect()
}

/// What came of a step, and what the check was asked for it.
#[derive(Debug, PartialEq)]
struct Decision {
    ranked: Vec<Evaluated>,
    evidence: Option<Evidence>,
    asked: Vec<Place>,
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn working_ahead_changes_no_decision_and_nothing_is_asked_that_was_not_told(
        (grid, heightmap, items) in support::scenes(3),
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
            let search = searching(&grid, order, is_bounded);
            let mut planner = planner(search, ProposeAll, order, stub);
            let plan = planner.plan(&input).unwrap();
            let events = events(&log);
            for event in &events {
                if let Event::Told(next) = event {
                    assert!(foresight > 1 && next.len() <= foresight);
                }
            }
            assert!(foresight == 1 || was_told_before(&events));
            Decision {
                ranked: ranked(plan),
                evidence: plan.evidence().cloned(),
                asked: asked(&events),
            }
        };
        let expected = decided(1, false);
        let best = expected.ranked.first();
        prop_assert_eq!(&expected.evidence, &best.map(|best| found(&best.resting)));
        for foresight in [1, 2, 3, 16] {
            for is_bounded in [false, true] {
                prop_assert_eq!(&decided(foresight, is_bounded), &expected);
            }
        }
    }

    #[test]
    fn a_widened_step_finds_the_one_placement_that_is_valid(
        seed in any::<u64>(),
        (x, y) in (0_usize..13, 0_usize..13),
        foresight in 1_usize..6,
        is_bounded in any::<bool>(),
    ) {
        let grid = grid();
        let scene = empty(&grid);
        let held = blocks(2);
        let input = StepInput::new(&grid, &scene, &held);
        let valid = Placement { yaw: 0, x, y };
        let mut proposer = ProposeRandom::new(Percent::new(2.0).unwrap(), seed);
        let mut proposals = Proposals::default();
        proposer.propose(&input, &mut proposals).unwrap();
        let is_proposed = match proposals.of(1) {
            CandidateProposals::Some(placements) => placements.contains(&valid),
            _ => true,
        };
        let log = Log::default();
        // The other item is given up on the way.
        let stub = Stub {
            foresight,
            gives_up: Some((0, 3)),
            ..Stub::new(&log, move |arrival, at| (arrival, at) == (1, valid))
        };
        let search = searching(&grid, Order::Balance, is_bounded);
        let mut planner = planner(search, proposer, Order::Balance, stub);
        let plan = planner.plan(&input).unwrap();
        prop_assert_eq!(plan.is_widened(), !is_proposed);
        let choice = plan.choice().unwrap();
        prop_assert_eq!((choice.candidate, choice.resting.placement), (1, valid));
        prop_assert!(plan.degraded().is_empty());
        prop_assert!(foresight == 1 || was_told_before(&events(&log)));
    }
}

#[test]
fn a_candidate_that_the_check_is_done_with_is_left_out_and_the_others_are_searched() {
    let grid = grid();
    let scene = empty(&grid);
    let held = blocks(2);
    // More than there are, so that the step looks at all that is left.
    let input = StepInput {
        alternatives: 10 * PLACES,
        ..StepInput::new(&grid, &scene, &held)
    };
    for (foresight, is_bounded) in [(1, false), (1, true), (5, false), (5, true)] {
        let log = Log::default();
        let stub = Stub {
            foresight,
            gives_up: Some((0, 7)),
            ..Stub::new(&log, |arrival, _| arrival == 1)
        };
        let search = searching(&grid, Order::Balance, is_bounded);
        let mut planner = planner(search, ProposeAll, Order::Balance, stub);
        let plan = planner.plan(&input).unwrap();
        assert_eq!(questions(&log, 0), 7);
        assert_eq!(questions(&log, 1), PLACES);
        let ranked = ranked(plan);
        assert_eq!(ranked.len(), PLACES);
        assert!(ranked.iter().all(|found| found.candidate == 1));
        let [left_out, other] = plan.candidates() else {
            panic!("{:?}", plan.candidates());
        };
        assert_eq!(left_out.reason, Some(Reason::Rejected(why())));
        assert_eq!(left_out.refusals.total(), 7);
        assert_eq!(other.reason, None);
        assert!(plan.degraded().is_empty() && !plan.is_cut());
    }
}

#[test]
fn a_candidate_that_is_left_out_makes_room_for_the_next_in_the_order() {
    let grid = grid();
    let scene = empty(&grid);
    let held = blocks(2);
    let log = Log::default();
    let stub = Stub {
        gives_up: Some((0, 4)),
        ..Stub::new(&log, |arrival, _| arrival == 1)
    };
    let search = searching(&grid, Order::Arrival, false);
    let mut planner = planner(search, ProposeAll, Order::Arrival, stub);
    let plan = planner.plan(&StepInput::new(&grid, &scene, &held)).unwrap();
    assert_eq!(plan.choice().unwrap().candidate, 1);
    assert_eq!((questions(&log, 0), questions(&log, 1)), (4, 1));
    assert_eq!(
        plan.candidates()[0].reason,
        Some(Reason::Rejected(why())),
        "it was searched before the other, to its end"
    );
}

/// Goes on to give the placements of candidates that it should leave out.
struct Forgetful(Search);

impl Evaluator for Forgetful {
    fn rank(
        &mut self,
        input: &StepInput<'_>,
        group: &[usize],
        proposals: &Proposals,
    ) -> StageResult {
        self.0.rank(input, group, proposals)
    }

    fn next_best(&mut self, input: &StepInput<'_>) -> StageResult<Option<Evaluated>> {
        self.0.next_best(input)
    }

    fn counts(&self, candidate: usize) -> PlacementCounts {
        self.0.counts(candidate)
    }
}

#[test]
fn an_evaluator_that_leaves_nothing_out_leads_to_the_same_plan() {
    let grid = grid();
    let scene = empty(&grid);
    let held = blocks(2);
    let input = StepInput {
        alternatives: 5,
        ..StepInput::new(&grid, &scene, &held)
    };
    let stub = |log: &Log| Stub {
        foresight: 3,
        gives_up: Some((0, 2)),
        ..Stub::new(log, |arrival, at| arrival == 1 && at.x > 2)
    };
    let (of_one, of_other) = (Log::default(), Log::default());
    let search = || searching(&grid, Order::Balance, false);
    let mut one = planner(search(), ProposeAll, Order::Balance, stub(&of_one));
    let forgetful = Forgetful(search());
    let mut other = planner(forgetful, ProposeAll, Order::Balance, stub(&of_other));
    let expected = ranked(one.plan(&input).unwrap());
    assert_eq!(expected.len(), 6);
    assert_eq!(ranked(other.plan(&input).unwrap()), expected);
    assert_eq!(questions(&of_one, 0), 2);
}

/// The ranking of some blocks, as far as the third.
fn best_three(grid: &Grid, held: &[Candidate]) -> Vec<Evaluated> {
    let scene = empty(grid);
    let input = StepInput {
        alternatives: 2,
        ..StepInput::new(grid, &scene, held)
    };
    let stub = Stub::new(&Log::default(), |_, _| true);
    let search = searching(grid, Order::Balance, false);
    let mut planner = planner(search, ProposeAll, Order::Balance, stub);
    ranked(planner.plan(&input).unwrap())
}

#[test]
fn where_all_is_refused_the_last_resort_is_made() {
    let grid = grid();
    let scene = empty(&grid);
    let held = blocks(1);
    let third = best_three(&grid, &held)[2];
    for (foresight, is_bounded) in [(1, false), (1, true), (4, false), (4, true)] {
        let stub = Stub {
            foresight,
            resort: Some(2),
            ..Stub::new(&Log::default(), |_, _| false)
        };
        let search = searching(&grid, Order::Balance, is_bounded);
        let mut planner = planner(search, ProposeAll, Order::Balance, stub);
        let plan = planner.plan(&StepInput::new(&grid, &scene, &held)).unwrap();
        assert_eq!(ranked(plan), [third]);
        assert_eq!(plan.evidence(), Some(&found(&third.resting)));
        assert!(plan.degraded().is_empty());
        assert!(!plan.is_cut());
        assert_eq!(plan.refusals().total(), PLACES as u64);
    }
}

#[test]
fn an_item_that_was_given_up_is_looked_into_again_where_nothing_else_is_valid() {
    let grid = grid();
    let scene = empty(&grid);
    let held = blocks(1);
    let far = Placement { yaw: 0, x: 6, y: 6 };
    for gives_up in [None, Some((0, 2))] {
        let log = Log::default();
        let stub = Stub {
            gives_up,
            ..Stub::new(&log, move |_, at| at == far && gives_up.is_some())
        };
        let search = searching(&grid, Order::Balance, false);
        let mut planner = planner(search, ProposeAll, Order::Balance, stub);
        let plan = planner.plan(&StepInput::new(&grid, &scene, &held)).unwrap();
        assert_eq!(plan.choice().is_some(), gives_up.is_some());
        assert!(!plan.is_widened(), "all was proposed before");
        let widened = events(&log)
            .into_iter()
            .filter(|event| *event == Event::Widened);
        assert_eq!(widened.count(), 1);
    }
}

#[test]
fn without_a_last_resort_there_is_no_choice() {
    let grid = grid();
    let scene = empty(&grid);
    let held = blocks(1);
    let stub = Stub::new(&Log::default(), |_, _| false);
    let search = searching(&grid, Order::Balance, false);
    let mut planner = planner(search, ProposeAll, Order::Balance, stub);
    let plan = planner.plan(&StepInput::new(&grid, &scene, &held)).unwrap();
    assert_eq!((plan.choice(), plan.evidence()), (None, None));
    assert!(plan.degraded().is_empty());
    assert_eq!(plan.candidates()[0].reason, Some(Reason::Rejected(why())));
}

#[test]
fn what_is_valid_goes_before_the_last_resort() {
    let grid = grid();
    let scene = empty(&grid);
    let held = blocks(1);
    let far = Placement { yaw: 0, x: 6, y: 6 };
    let stub = Stub {
        resort: Some(0),
        ..Stub::new(&Log::default(), move |_, at| at == far)
    };
    let search = searching(&grid, Order::Balance, false);
    let mut planner = planner(search, ProposeAll, Order::Balance, stub);
    let plan = planner.plan(&StepInput::new(&grid, &scene, &held)).unwrap();
    assert_eq!(plan.choice().unwrap().resting.placement, far);
    assert!(plan.degraded().is_empty());
}

#[test]
fn the_last_resort_is_of_the_right_candidate_where_another_is_ruled_out() {
    let grid = grid();
    let scene = empty(&grid);
    let held = blocks(2);
    let best = best_three(&grid, &held[1..])[0];
    let stub = Stub {
        ruled_out: Some(0),
        resort: Some(0),
        ..Stub::new(&Log::default(), |_, _| false)
    };
    let search = searching(&grid, Order::Balance, false);
    let mut planner = planner(search, ProposeAll, Order::Balance, stub);
    let plan = planner.plan(&StepInput::new(&grid, &scene, &held)).unwrap();
    let expected = Evaluated {
        candidate: 1,
        ..best
    };
    assert_eq!(plan.choice(), Some(expected));
    assert!(plan.degraded().is_empty());
}

#[test]
fn each_plan_begins_once_and_before_all_else() {
    let grid = grid();
    let scene = empty(&grid);
    let held = blocks(3);
    for order in [Order::Balance, Order::Arrival] {
        let log = Log::default();
        let stub = Stub {
            foresight: 2,
            ruled_out: Some(1),
            ..Stub::new(&log, |arrival, at| arrival == 2 && at.x > 0)
        };
        let search = searching(&grid, order, false);
        let mut planner = planner(search, ProposeCorner, order, stub);
        for step in 0..3 {
            log.lock().unwrap().clear();
            let input = StepInput {
                step,
                ..StepInput::new(&grid, &scene, &held)
            };
            // Several searches in one plan.
            let plan = planner.plan(&input).unwrap();
            assert!(plan.is_widened() && plan.choice().is_some());
            let events = events(&log);
            assert_eq!(events[0], Event::Begun);
            let widened = events.iter().filter(|event| **event == Event::Widened);
            assert_eq!(widened.count(), 1);
            assert!(events.len() > 1 && !events[1..].contains(&Event::Begun));
        }
    }
}
