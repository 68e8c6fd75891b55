"""The interpreter's lock is released around everything that computes."""

import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import ppnpack

UNTRIED = {"tries_per_item": 0}


def ticks_during(call):
    """How often another thread got the lock during one call of native code, and how long that took, in seconds."""
    ticks, is_over = [0], threading.Event()

    def tick():
        while not is_over.wait(0.001):
            ticks[0] += 1

    with ThreadPoolExecutor(1) as pool:
        ticking = pool.submit(tick)
        started, before = time.monotonic(), ticks[0]
        call()
        counted, took_s = ticks[0] - before, time.monotonic() - started
        is_over.set()
        ticking.result()
    return counted, took_s


@pytest.fixture(scope="module")
def fine():
    return ppnpack.Grid(cell_m=0.0025, yaws=16)


@pytest.fixture(scope="module")
def rough(fine, catalogue):
    rng = np.random.default_rng(5)
    top = rng.integers(30, 60, (36, 48), np.int16)
    return ppnpack.Item("rough", [top] * 16, [np.zeros_like(top)] * 16)


def calls(grid, fine, rough, catalogue):
    """One call of each kind that takes a tenth of a second or more."""
    heightmap = np.random.default_rng(6).integers(0, 60, (128, 128), np.int16)
    planner = ppnpack.Planner(fine, trial=UNTRIED, heuristic="mta")
    slow = {"solver": {"timestep_s": 2e-5, "sleep_time_s": 60.0}, "settle_time_s": 1.0}
    cell = ppnpack.SimulatedCell(grid, **slow)
    packings = ppnpack.Packings(grid, catalogue, 2, physics=True, cell=slow, threads=1)
    actions = packings.reset([1, 2]).action_mask.argmax(1)
    return {
        "evaluate": lambda: ppnpack.evaluate(fine, heightmap, rough),
        "plan": lambda: planner.plan(heightmap, [rough]),
        "cell": lambda: cell.place(catalogue["mug"], ppnpack.Placement(0, 4, 4, 0)),
        "catalogue": lambda: ppnpack.Catalogue(grid, cache=False),
        "packings": lambda: packings.step(actions),
    }


@pytest.mark.parametrize("kind", ["evaluate", "plan", "cell", "catalogue", "packings"])
def test_other_threads_run_during(kind, grid, fine, rough, catalogue):
    ticks, took_s = ticks_during(calls(grid, fine, rough, catalogue)[kind])
    assert took_s > 0.05, "too short to tell"
    # A thread that cannot get the lock during the call ticks once before it and once after it at most.
    assert ticks > 5, f"{ticks} ticks in {took_s:.3f} s"


def test_two_planners_are_at_work_at_the_same_time(grid, block):
    both = threading.Barrier(2)

    def evaluator(heightmap, item, resting_height, fits):
        both.wait(60.0)
        return resting_height.astype(float)

    def plan(_):
        return ppnpack.plan(grid, grid.empty(), [block], evaluator=evaluator, trial=UNTRIED).choice

    with ThreadPoolExecutor(2) as pool:
        one, other = pool.map(plan, range(2))
    assert one == other


def test_results_do_not_depend_on_the_number_of_threads(grid, catalogue):
    def play(threads):
        packings = ppnpack.Packings(grid, catalogue, 6, items=12, threads=threads)
        observed, shares = packings.reset(list(range(6))), []
        for _ in range(10):
            observed, stepped = packings.step(observed.action_mask.argmax(1), autoreset=True)
            shares.append(stepped.volume_share)
        return observed.heightmap, np.array(shares)

    (one, one_shares), (four, four_shares) = play(1), play(4)
    assert np.array_equal(one, four) and np.array_equal(one_shares, four_shares)
