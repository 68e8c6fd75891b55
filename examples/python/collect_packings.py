"""Collects a dataset of packings, as shards that are written whole: in sequence, by processes of this machine, or by tasks of Ray on one
machine or many.

Each packing has a seed of its own and depends on nothing else, so a shard has the same bytes wherever and whenever it is made, and a task that was
lost is done again. Shards that are there are kept: the same command goes on where it was cut off.
"""

import argparse
import concurrent.futures
import dataclasses
import importlib.metadata
import importlib.util
import io
import itertools
import json
import multiprocessing
import os
import pathlib

import numpy as np

import ppnpack

# Shards wait in it until they are written: some at a time, of some 100 KB each.
OBJECT_STORE_BYTES = 256 * 2**20


@dataclasses.dataclass(frozen=True)
class Settings:
    """All that a packing depends on beside its seed. Lengths are in metres."""

    cell_m: float = 0.02
    height_unit_m: float = 0.005
    yaws: int = 2
    items: int = 30
    buffer: int = 3
    heuristic: str = "sdfm"
    physics: bool = False

    def grid(self):
        return ppnpack.Grid(cell_m=self.cell_m, height_unit_m=self.height_unit_m, yaws=self.yaws)


class IdealCell:
    """A cell in which an item stays where it comes to rest as it is lowered."""

    def __init__(self, grid):
        self.grid, self.heightmap = grid, grid.empty()

    def scan(self):
        return ppnpack.Scene(self.grid, self.heightmap)

    def place(self, item, placement):
        self.heightmap = ppnpack.place(self.heightmap, item, placement)


def packing(seed, settings, grid, catalogue):
    """Packs one container with objects drawn by the seed, until nothing of the buffer has a place.

    Gives of each step the heightmap before it, the objects of the buffer (-1 where none waits), the placement and its value.
    """
    objects = np.random.default_rng(seed).integers(len(catalogue), size=settings.items).tolist()
    arrivals = iter(objects)
    buffer = list(itertools.islice(arrivals, settings.buffer))
    planner = ppnpack.Planner(grid, heuristic=settings.heuristic, trial={"tries_per_item": 0})
    cell = ppnpack.SimulatedCell(grid, seed=seed) if settings.physics else IdealCell(grid)
    steps = []
    while buffer:
        scene = cell.scan()
        choice = planner.plan(scene, [catalogue[index] for index in buffer], step=len(steps)).choice
        if choice is None:
            break
        waiting = buffer + [-1] * (settings.buffer - len(buffer))
        placement = choice.slot, choice.yaw, choice.x, choice.y, choice.resting_height
        steps.append((scene.heightmap, waiting, placement, choice.value))
        cell.place(catalogue[buffer.pop(choice.slot)], choice)
        buffer.extend(itertools.islice(arrivals, 1))
    return steps


def shard(first, count, settings):
    """The packings of `count` seeds from `first` on, as the bytes of an .npz file."""
    grid = settings.grid()
    catalogue = ppnpack.Catalogue(grid)
    seeds = range(first, first + count)
    packings = [packing(seed, settings, grid, catalogue) for seed in seeds]
    steps = [step for steps in packings for step in steps]
    heightmaps, buffers, placements, values = zip(*steps) if steps else ((), (), (), ())
    content = io.BytesIO()
    # Not compressed: what a compressor writes depends on its version.
    np.savez(
        content,
        seed=np.array(seeds, np.int64),
        steps=np.array([len(steps) for steps in packings], np.int64),
        heightmap=np.array(heightmaps, np.int16).reshape(-1, grid.nx, grid.ny),
        buffer=np.array(buffers, np.int16).reshape(-1, settings.buffer),
        placement=np.array(placements, np.int16).reshape(-1, 5),
        value=np.array(values, np.float64),
    )
    return content.getvalue()


def windowed(jobs, window, start, wait, result):
    """Has jobs done, never more than `window()` of them begun and not ended; gives each with what it came to, as they end."""
    jobs = iter(jobs)
    under_way = {}
    while True:
        for job in itertools.islice(jobs, max(window() - len(under_way), 0)):
            under_way[start(job)] = job
        if not under_way:
            return
        for ended in wait(list(under_way)):
            yield under_way.pop(ended), result(ended)


def in_sequence(jobs, options):
    for job in jobs:
        yield job, shard(*job)


def by_processes(jobs, options):
    """By processes of this machine. Where one is lost the run ends, and the same command goes on."""
    context = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(options.workers, context) as pool:
        first = concurrent.futures.FIRST_COMPLETED
        yield from windowed(
            jobs,
            window=lambda: 2 * options.workers,
            start=lambda job: pool.submit(shard, *job),
            wait=lambda under_way: concurrent.futures.wait(under_way, return_when=first).done,
            result=lambda ended: ended.result(),
        )


def by_ray(jobs, options):
    """By tasks of Ray, one a core, on this machine or on all of a cluster. A task that is lost with its worker or its machine is done again.

    Shards come back as bytes and are written here, so the machines need no common folder.
    """
    # Nothing is reported to anybody.
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    import ray

    if options.address is None:
        ray.init(num_cpus=options.workers, include_dashboard=False, object_store_memory=OBJECT_STORE_BYTES)
    else:
        ray.init(address=options.address)
    task = ray.remote(shard).options(num_cpus=1, max_retries=5)
    try:
        yield from windowed(
            jobs,
            window=lambda: 2 * max(int(ray.cluster_resources().get("CPU", 1)), 1),
            start=lambda job: task.remote(*job),
            wait=lambda under_way: ray.wait(under_way, num_returns=1)[0],
            result=ray.get,
        )
    finally:
        ray.shutdown()


WAYS = {"sequence": in_sequence, "processes": by_processes, "ray": by_ray}


def write_whole(path, content):
    """Under its name a file is whole or not there, even after a power cut."""
    part = path.with_name(path.name + ".part")
    with open(part, "wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    os.replace(part, path)


def prepare(out, settings):
    """Makes the folder, with what its shards depend on beside them; a folder with shards of anything else is refused."""
    depends_on = {
        "settings": dataclasses.asdict(settings),
        "catalogue": ppnpack.Catalogue(settings.grid()).content_hash(),
        "ppnpack": importlib.metadata.version("ppnpack"),
    }
    out.mkdir(parents=True, exist_ok=True)
    path = out / "settings.json"
    if not path.exists():
        write_whole(path, json.dumps(depends_on, indent=2).encode())
    elif json.loads(path.read_bytes()) != depends_on:
        raise SystemExit(f"{path} is of other settings: name another folder, or remove this one")


def path_of(out, job):
    first, count, _ = job
    return out / f"seeds-{first:09}-{first + count - 1:09}.npz"


def collect(options, settings):
    """Has the shards made that are not there, and gives the paths of all."""
    prepare(options.out, settings)
    firsts = range(0, options.packings, options.per_shard)
    jobs = [(first, min(options.per_shard, options.packings - first), settings) for first in firsts]
    missing = [job for job in jobs if not path_of(options.out, job).exists()]
    for job, content in WAYS[options.way](missing, options):
        path = path_of(options.out, job)
        write_whole(path, content)
        print(f"{path.name}: written", flush=True)
    return [path_of(options.out, job) for job in jobs]


def parse():
    has_ray = importlib.util.find_spec("ray") is not None
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/packings"), help="where the shards are [%(default)s]")
    parser.add_argument("--packings", type=int, default=256, help="how many, of the seeds from 0 on [%(default)s]")
    parser.add_argument("--per-shard", type=int, default=16, help="packings in a shard, and in a task [%(default)s]")
    parser.add_argument("--way", choices=WAYS, default="ray" if has_ray else "processes", help="what packs [%(default)s here]")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help="processes of this machine [one per core]")
    parser.add_argument("--address", help="a Ray cluster in place of this machine alone: auto, or ray://HOST:10001")
    parser.add_argument("--physics", action="store_true", help="items settle in the simulated cell, in place of staying where they rest")
    options = parser.parse_args()
    if min(options.packings, options.per_shard, options.workers) < 1:
        parser.error("--packings, --per-shard and --workers are at least 1")
    return options


def main():
    options = parse()
    paths = collect(options, Settings(physics=options.physics))
    steps = 0
    for path in paths:
        with np.load(path) as arrays:
            steps += int(arrays["steps"].sum())
    print(f"{options.packings} packings, {steps} steps, {len(paths)} shards in {options.out}")


if __name__ == "__main__":
    main()
