"""Prints criterion's medians as Markdown, with ratios within the run."""

import datetime
import json
import os
import pathlib
import subprocess
import sys

# Per grid, steps are given as a ratio to this one.
BASE = "SDFM, published stability"


def seconds(value):
    for limit, unit, scale in ((1e-3, "µs", 1e6), (1.0, "ms", 1e3)):
        if value < limit:
            return f"{value * scale:.3g} {unit}"
    return f"{value:.3g} s"


def measured(folder):
    """Yields (group, function, parameter, median and its confidence interval, in seconds)."""
    for path in sorted(pathlib.Path(folder).glob("**/new/benchmark.json")):
        about = json.loads(path.read_text())
        median = json.loads((path.parent / "estimates.json").read_text())["median"]
        interval = median["confidence_interval"]
        values = (median["point_estimate"], interval["lower_bound"], interval["upper_bound"])
        yield about["group_id"], about["function_id"], about["value_str"] or "", [v * 1e-9 for v in values]


def machine():
    with open("/proc/cpuinfo", encoding="utf-8") as info:
        for line in info:
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return "unknown processor"


def commit():
    """The commit of the working folder, and whether files differ from it."""
    command = ["git", "describe", "--always", "--dirty=, with changes"]
    described = subprocess.run(command, capture_output=True, text=True, check=False)
    return described.stdout.strip() or "unknown"


def main():
    rows = list(measured(sys.argv[1]))
    objects = os.environ.get("PPNPACK_BENCH_OBJECTS")
    print("# Benchmarks\n")
    print(f"Machine: {machine()}, {os.cpu_count()} cores; commit {commit()}, {datetime.date.today():%-d %B %Y}. One thread unless a row says otherwise. "
          f"Objects of steps: {'the folder ' + pathlib.Path(objects).name if objects else 'the built-in set'}; "
          "the other groups use the built-in set. "
          "'Every value computed' is the engine's plain survey of all placements, without bounds and without the "
          "processor's wider vectors. Medians with 95 % intervals, from one run of `scripts/bench`; what is measured is said in "
          "the `benches` folders of the crates.")
    base = {parameter: values[0] for _, function, parameter, values in rows if function == BASE}
    for group in dict.fromkeys(row[0] for row in rows):
        print(f"\n## {group}\n")
        has_ratio = any(row[0] == group and row[2] in base for row in rows) and group == "step"
        print(f"| grid | what | median | interval |{' to the first |' if has_ratio else ''}")
        print(f"|---|---|---|---|{'---|' if has_ratio else ''}")
        of_group = [row for row in rows if row[0] == group]
        order = {name: place for place, name in enumerate(("1 cm, 4 yaws", "5 mm, 8 yaws", "2.5 mm, 16 yaws"))}
        of_group.sort(key=lambda row: (order.get(row[2], 9), row[1] != BASE, row[1]))
        for _, function, parameter, (median, low, high) in of_group:
            line = f"| {parameter or '–'} | {function or group} | {seconds(median)} | {seconds(low)} – {seconds(high)} |"
            if has_ratio:
                line += f" {median / base[parameter]:.2f} |" if parameter in base else " – |"
            print(line)


main()
