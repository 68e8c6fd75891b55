"""Steps per second of the environments, with random possible actions, on one core and on all.

usage: python steps.py [SECONDS]
"""

import os
import platform
import sys
import time

import numpy as np

import ppnpack
from ppnpack.envs import PackingEnv


def rate(step, seconds):
    """How often a second a function that takes some steps takes one."""
    steps, started = 0, time.perf_counter()
    while time.perf_counter() - started < seconds:
        steps += step()
    return steps / (time.perf_counter() - started)


def single(env, random):
    """A step of one environment, with the choice of its action."""
    state = {"observation": env.reset(seed=1)[0]}

    def step():
        mask = state["observation"]["action_mask"]
        state["observation"], _, terminated, _, _ = env.step(random.choice(np.flatnonzero(mask)))
        if terminated:
            state["observation"] = env.reset()[0]
        return 1

    return step


def native(packings, random, count):
    """A step of all packings without Gymnasium; the actions are drawn before."""
    state = {"mask": packings.reset(list(range(count))).action_mask}

    def step():
        # The first possible action from a random place on.
        start = int(random.integers(state["mask"].shape[1]))
        actions = (np.roll(state["mask"], -start, 1).argmax(1) + start) % state["mask"].shape[1]
        observed, _ = packings.step(actions, autoreset=True)
        state["mask"] = observed.action_mask
        return count

    return step


def main():
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 5.0
    cores = len(os.sched_getaffinity(0))
    print(f"{platform.processor() or platform.machine()}, {cores} cores, load {os.getloadavg()[0]:.1f}; random possible actions, 80 items, buffer 5")
    print("| cell | physics | environment | threads | steps/s |\n|---|---|---|---|---|")
    for cell_m, yaws in [(0.01, 4), (0.005, 8)]:
        grid = ppnpack.Grid(cell_m=cell_m, yaws=yaws)
        catalogue = ppnpack.Catalogue(grid)
        for physics in [False, True]:
            random = np.random.default_rng(1)
            about = f"{1000 * cell_m:g} mm, {yaws} yaws | {'yes' if physics else 'no'}"
            env = PackingEnv(grid, catalogue, physics=physics)
            print(f"| {about} | one | 1 | {rate(single(env, random), seconds):,.0f} |", flush=True)
            for threads in sorted({1, cores}):
                count = 16
                packings = ppnpack.Packings(grid, catalogue, count, physics=physics, threads=threads)
                print(f"| {about} | {count} together | {threads} | {rate(native(packings, random, count), seconds):,.0f} |", flush=True)


if __name__ == "__main__":
    main()
