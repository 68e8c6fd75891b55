"""Trains a small policy by the cross-entropy method, and compares it with random placements on seeds that it was not trained on.

The policy is linear: each possible action has a few features, and the action of the greatest weighted sum is taken. All candidates of a
generation are played at the same time, one in each environment of a vector.
"""

import time

import numpy as np

import ppnpack
from ppnpack.envs import VectorPackingEnv

FEATURES = 6


def features(observation, rim):
    """Of every action: float32 [environment, slot, yaw, x, y, feature]."""
    resting = observation["resting_height"].astype(np.float32) / rim
    top, bottom = observation["item_top"], observation["item_bottom"]
    solid = bottom >= 0
    height = top.max((3, 4), keepdims=True).astype(np.float32) / rim
    volume = np.where(solid, top - bottom, 0).sum((3, 4), keepdims=True, dtype=np.float32)
    volume = np.cbrt(volume / (rim * resting.shape[3] * resting.shape[4]))
    x, y = (grid.astype(np.float32) / side for grid, side in zip(np.indices(resting.shape[3:]), resting.shape[3:]))
    surround = observation["heightmap"].astype(np.float32)[:, None, None] / rim
    every = [resting, resting + height, volume, x + y, np.minimum(x, 1 - x) + np.minimum(y, 1 - y), surround]
    return np.stack([np.broadcast_to(each, resting.shape) for each in every], -1)


def play(envs, weights, seeds):
    """Plays an episode in each environment, with its own weights [environment, feature]; at random without. Gives the packed shares."""
    random = np.random.default_rng(0)
    observation, _ = envs.reset(seed=list(seeds))
    shares, over = np.zeros(envs.num_envs), np.zeros(envs.num_envs, bool)
    while not over.all():
        mask = observation["action_mask"] == 1
        if weights is None:
            scores = random.random(mask.shape, np.float32)
        else:
            scores = np.einsum("nsrxyf,nf->nsrxy", features(observation, envs.grid.rim), weights.astype(np.float32))
        actions = np.where(mask, scores.reshape(mask.shape), -np.inf).argmax(1)
        observation, _, terminated, _, infos = envs.step(actions)
        shares = np.where(over, shares, infos["volume_share"])
        over |= terminated
    return shares


def train(envs, population, episodes, generations, random):
    """Weights that pack much, by the cross-entropy method."""
    mean, deviation = np.zeros(FEATURES), np.ones(FEATURES)
    for generation in range(generations):
        candidates = mean + deviation * random.standard_normal((population, FEATURES))
        seeds = random.integers(1_000_000, size=episodes)
        shares = play(envs, np.repeat(candidates, episodes, 0), np.tile(seeds, population))
        fitness = shares.reshape(population, episodes).mean(1)
        best = candidates[np.argsort(-fitness)[: population // 4]]
        mean, deviation = best.mean(0), best.std(0) + 0.05
        print(f"generation {generation + 1}: {100 * fitness.mean():.1f} % packed on average, {100 * fitness.max():.1f} % at best")
    return mean


def main():
    started = time.monotonic()
    # Coarse, so that it takes seconds.
    grid = ppnpack.Grid(cell_m=0.02, height_unit_m=0.005, yaws=2)
    catalogue = ppnpack.Catalogue(grid)
    population, episodes, held_out = 24, 2, 48
    envs = VectorPackingEnv(population * episodes, grid, catalogue, buffer=3, items=30)
    weights = train(envs, population, episodes, 6, np.random.default_rng(3))
    # Seeds of the training are below a million.
    seeds = 2_000_000 + np.arange(held_out)
    envs = VectorPackingEnv(held_out, grid, catalogue, buffer=3, items=30)
    trained = play(envs, np.tile(weights, (held_out, 1)), seeds)
    random = play(envs, None, seeds)
    error = (trained - random).std(ddof=1) / np.sqrt(held_out)
    print(f"random: {100 * random.mean():.1f} %, trained: {100 * trained.mean():.1f} % of the container packed")
    print(f"better by {100 * (trained - random).mean():.1f} +- {100 * error:.1f} points, in {time.monotonic() - started:.0f} s")


if __name__ == "__main__":
    main()
