"""Packs with a heuristic of one's own, and compares it with the engine's."""

import numpy as np

import ppnpack


def snug(heightmap, item, resting_height, fits):
    """As low as possible, then with as little lost room below the item as possible, then towards the corner: lower is better.

    heightmap is [x, y]; resting_height, fits and what is returned are [yaw, x, y]. What is inf is never chosen.
    """
    x, y = np.indices(heightmap.shape)
    values = np.full(fits.shape, np.inf)
    for yaw in range(item.yaws):
        bottom = item.bottom(yaw)
        nx, ny = (side + 1 - part for side, part in zip(heightmap.shape, bottom.shape))
        if nx < 1 or ny < 1:
            continue
        # All windows of the heightmap that the footprint may cover: [x, y, footprint x, footprint y], without a copy.
        below = np.lib.stride_tricks.sliding_window_view(heightmap, bottom.shape)
        gaps = resting_height[yaw, :nx, :ny, None, None] + bottom - below
        lost = np.where(bottom >= 0, gaps, 0).sum((2, 3)) / (bottom >= 0).sum()
        tops = resting_height[yaw, :nx, :ny] + item.height(yaw)
        values[yaw, :nx, :ny] = tops + 0.5 * lost + 0.2 * (x + y)[:nx, :ny]
    return np.where(fits, values, np.inf)


def packed_share(grid, items, planner, buffer=5):
    """The share of the container's volume that is packed with items that arrive in this order."""
    heightmap, volume_m3, waiting, arriving = grid.empty(), 0.0, items[:buffer], items[buffer:]
    for step in range(len(items)):
        choice = planner.plan(heightmap, waiting, step=step).choice
        if choice is None:
            break
        item = waiting.pop(choice.slot)
        heightmap = ppnpack.place(heightmap, item, choice)
        volume_m3 += item.mesh_volume_m3
        waiting += arriving[:1]
        arriving = arriving[1:]
    return volume_m3 / grid.volume_m3


def main():
    grid = ppnpack.Grid.reference()
    catalogue = ppnpack.Catalogue(grid)
    untried = {"tries_per_item": 0}
    # By the box's volume: the largest item of the buffer first, so that the heuristic decides where alone.
    planners = {
        "snug": ppnpack.Planner(grid, evaluator=snug, order="bbox-volume", trial=untried),
        "hm": ppnpack.Planner(grid, heuristic="hm", order="bbox-volume", trial=untried),
        "random": ppnpack.Planner(grid, heuristic="random", order="shuffled", trial=untried),
    }
    random = np.random.default_rng(1)
    sequences = [[catalogue[int(index)] for index in random.integers(len(catalogue), size=40)] for _ in range(3)]
    for name, planner in planners.items():
        shares = [packed_share(grid, sequence, planner) for sequence in sequences]
        print(f"{name}: {100 * np.mean(shares):.1f} % of the container is packed")


if __name__ == "__main__":
    main()
