"""Steps per second of the environments, with random possible actions.

usage: python steps.py [SECONDS]

A rate per second is that of the clock; one per processor second does not depend on what else the machine does, as far as that leaves
the processor's caches alone.
"""

import os
import sys
import time

import numpy as np

import ppnpack
from ppnpack.envs import PackingEnv, VectorPackingEnv


class Player:
    """Takes random possible actions in one environment."""

    def __init__(self, env):
        self.env, self.random = env, np.random.default_rng(1)
        self.observation, _ = env.reset(seed=1)

    def step(self):
        possible = np.flatnonzero(self.observation["action_mask"])
        action = possible[self.random.integers(len(possible))]
        self.observation, _, terminated, _, _ = self.env.step(action)
        if terminated:
            self.observation, _ = self.env.reset()
        return 1


class VectorPlayer:
    """Takes random possible actions in environments that are stepped together."""

    def __init__(self, envs):
        self.envs, self.random = envs, np.random.default_rng(1)
        self.observation, _ = envs.reset(seed=1)

    def step(self):
        # The first possible action from a random one on, and over the end.
        mask = self.observation["action_mask"]
        first = int(self.random.integers(mask.shape[1]))
        after = mask[:, first:]
        actions = np.where(after.any(1), first + after.argmax(1), mask.argmax(1))
        self.observation, *_ = self.envs.step(actions)
        return self.envs.num_envs


def rates(player, seconds):
    """Steps per second of the clock, and of the processor."""
    steps, started, busy = 0, time.perf_counter(), time.process_time()
    while time.perf_counter() - started < seconds:
        steps += player.step()
    return steps / (time.perf_counter() - started), steps / (time.process_time() - busy)


def main():
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 10.0
    cores = len(os.sched_getaffinity(0))
    print(f"{cores} cores, load {os.getloadavg()[0]:.1f}; 80 items, buffer 5, random possible actions, with the choice of these\n")
    print("| grid | physics | environments | threads | steps/s | per processor second |\n|---|---|---|---|---|---|", flush=True)
    for cell_m, yaws in [(0.01, 4), (0.005, 8)]:
        grid = ppnpack.Grid(cell_m=cell_m, yaws=yaws)
        catalogue = ppnpack.Catalogue(grid)
        for physics in [False, True]:
            about = f"{1000 * cell_m:g} mm, {yaws} yaws | {'yes' if physics else 'no'}"
            players = [("1 | 1", Player(PackingEnv(grid, catalogue, physics=physics)))]
            for threads in sorted({1, cores}):
                envs = VectorPackingEnv(16, grid, catalogue, physics=physics, threads=threads)
                players.append((f"16 | {threads}", VectorPlayer(envs)))
            for what, player in players:
                of_clock, of_processor = rates(player, seconds)
                print(f"| {about} | {what} | {of_clock:,.0f} | {of_processor:,.0f} |", flush=True)


if __name__ == "__main__":
    main()
