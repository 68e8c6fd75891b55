"""Runs an experiment over a cluster, by tasks of Ray that each make a range of its runs; then the experiment names what makes its page of all.

    run_experiment.py --cases 2000 --runs out/kept --out out/table2 -- ppnpack experiment table2

Each machine needs the same build of ppnpack and the same input files. A task that is lost is made again, and ranges that are there are kept: the
same command goes on where it was cut off.
"""

import argparse
import pathlib
import subprocess
import tempfile


def made(command, count, first, cases):
    """The files that a range of the experiment keeps, by their paths."""
    with tempfile.TemporaryDirectory() as folder:
        runs = pathlib.Path(folder) / "runs"
        last = {"--first": first, count: cases, "--workers": 1, "--runs": runs, "--out": pathlib.Path(folder) / "out"}
        options = [str(part) for option in last.items() for part in option]
        done = subprocess.run([*command, *options], capture_output=True, text=True)
        if done.returncode != 0:
            raise RuntimeError(done.stderr.strip())
        return {str(path.relative_to(runs)): path.read_bytes() for path in runs.rglob("*.json")}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--first", type=int, default=0, help="the first run [%(default)s]")
    parser.add_argument("--cases", type=int, required=True, help="how many there are")
    parser.add_argument("--count", default="--cases", help="the experiment's option for that: --streams, --instances [%(default)s]")
    parser.add_argument("--per-task", type=int, default=20, help="how many a task makes [%(default)s]")
    parser.add_argument("--runs", type=pathlib.Path, required=True, help="where finished runs are kept")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="where the results are written")
    parser.add_argument("--address", help="a running cluster, or auto [one of this machine]")
    parser.add_argument("command", nargs="+", help="ppnpack experiment NAME, with its options")
    options = parser.parse_args()

    import ray

    ray.init(address=options.address, log_to_driver=False)
    task = ray.remote(num_cpus=1, max_retries=20)(made)
    end = options.first + options.cases
    waiting = {}
    for first in range(options.first, end, options.per_task):
        cases = min(options.per_task, end - first)
        mark = options.runs / f"{first}-{cases}.made"
        if not mark.exists():
            waiting[task.remote(options.command, options.count, first, cases)] = mark
    while waiting:
        [ready], _ = ray.wait(list(waiting))
        for name, content in ray.get(ready).items():
            path = options.runs / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.with_suffix(".new").write_bytes(content)
            path.with_suffix(".new").replace(path)
        waiting.pop(ready).touch()
        print(f"{len(waiting)} ranges are left", flush=True)
    whole = ["--first", options.first, options.count, options.cases, "--runs", options.runs, "--out", options.out]
    subprocess.run([*options.command, *map(str, whole)], check=True)


if __name__ == "__main__":
    main()
