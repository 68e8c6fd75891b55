"""Heuristics that are Python functions."""

import numpy as np
import pytest

import ppnpack

UNTRIED = {"tries_per_item": 0}


def deepest(heightmap, item, resting_height, fits):
    x, y = np.indices(heightmap.shape)
    return resting_height + x + y


def test_a_function_ranks_as_the_engine_does(grid, catalogue):
    """DBL without the balance term, in the order of arrival, is `k + x + y` on the reference grid."""
    heightmap = np.random.default_rng(4).integers(0, 60, (32, 32), np.int16)
    buffer = [catalogue["mug"], catalogue["bowl"]]
    own = ppnpack.Planner(grid, evaluator=deepest, order="arrival", trial=UNTRIED, stability="published")
    engine = ppnpack.Planner(grid, heuristic="dbl", order="arrival", trial=UNTRIED, stability="published")
    for step in range(3):
        one, other = (planner.plan(heightmap, buffer, step=step, alternatives=20) for planner in (own, engine))
        assert one.choice == other.choice and one.alternatives == other.alternatives
        heightmap = ppnpack.place(heightmap, buffer[one.choice.slot], one.choice)


def test_a_function_is_given_the_items_and_arrays_of_the_step(grid, block):
    seen = []

    def evaluator(heightmap, item, resting_height, fits):
        seen.append((heightmap, item, resting_height, fits))
        return np.where(fits, resting_height, np.inf)

    heightmap = np.arange(32 * 32, dtype=np.int16).reshape(32, 32) % 40
    plan = ppnpack.Planner(grid, evaluator=evaluator, trial=UNTRIED).plan(heightmap, [block])
    [(given, item, resting_height, fits)] = seen
    assert item is block and np.array_equal(given, heightmap) and plan.choice is not None
    assert np.array_equal(resting_height, ppnpack.resting_heights(grid, heightmap, block))
    assert fits.dtype == np.bool_ and np.array_equal(fits, (resting_height >= 0) & (resting_height <= 125))


def test_what_is_left_out_is_not_chosen(grid, block):
    def only_one(heightmap, item, resting_height, fits):
        values = np.full(resting_height.shape, np.nan)
        values[2, 5, 7] = 1.0
        return values

    planner = ppnpack.Planner(grid, evaluator=only_one, trial=UNTRIED)
    choice = planner.plan(grid.empty(), [block], alternatives=5)
    assert (choice.choice.yaw, choice.choice.x, choice.choice.y) == (2, 5, 7) and not choice.alternatives


def test_proposals_narrow_what_a_function_ranks(grid, block):
    method = {"proposals": {"from": "random", "percent": 1.0}, "seed": 3}
    own = ppnpack.Planner(grid, method, evaluator=deepest, order="arrival", trial=UNTRIED)
    engine = ppnpack.Planner(grid, method, heuristic="dbl", order="arrival", trial=UNTRIED)
    assert own.plan(grid.empty(), [block]).choice == engine.plan(grid.empty(), [block]).choice


def test_exceptions_of_a_function_come_out_and_the_planner_goes_on(grid, block):
    fail = True

    def evaluator(heightmap, item, resting_height, fits):
        if fail:
            raise LookupError("not today")
        return deepest(heightmap, item, resting_height, fits)

    planner = ppnpack.Planner(grid, evaluator=evaluator, trial=UNTRIED)
    with pytest.raises(LookupError, match="not today"):
        planner.plan(grid.empty(), [block])
    fail = False
    assert planner.plan(grid.empty(), [block]).choice is not None
    flat = ppnpack.Planner(grid, evaluator=lambda *_: np.zeros((2, 2, 2)), trial=UNTRIED)
    with pytest.raises(ValueError, match=r"shape \[2, 2, 2\] where \[4, 32, 32\] is needed"):
        flat.plan(grid.empty(), [block])
    with pytest.raises(TypeError, match="no function"):
        ppnpack.Planner(grid, evaluator="sdfm")


def test_a_planner_in_use_says_so(grid, block):
    def nested(heightmap, item, resting_height, fits):
        planner.plan(heightmap, [block])

    planner = ppnpack.Planner(grid, evaluator=nested, trial=UNTRIED)
    with pytest.raises(RuntimeError, match="planning another step"):
        planner.plan(grid.empty(), [block])
