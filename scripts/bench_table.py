"""Prints criterion's medians as Markdown: a row for each benchmark, a column for each grid."""

import datetime
import json
import os
import pathlib
import subprocess
import sys

# Steps begin with this one.
BASE = "SDFM, published stability"

GRIDS = ("1 cm, 4 yaws", "5 mm, 8 yaws", "2.5 mm, 16 yaws")


def seconds(median, low, high):
    """A median with its interval, all in the median's unit."""
    for limit, unit, scale in ((1e-3, "µs", 1e6), (1.0, "ms", 1e3), (float("inf"), "s", 1.0)):
        if median < limit:
            return f"{median * scale:.3g} {unit} ({low * scale:.3g} – {high * scale:.3g})"


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
    for group in dict.fromkeys(row[0] for row in rows):
        of_group = [row for row in rows if row[0] == group]
        print(f"\n## {group}\n\n{table(group, of_group)}")


def table(group, rows):
    """A table of a group's benchmarks."""
    order = {name: place for place, name in enumerate(GRIDS)}
    grids = sorted({parameter for _, _, parameter, _ in rows}, key=lambda grid: (order.get(grid, 9), grid))
    functions = sorted({function for _, function, _, _ in rows}, key=lambda function: (function != BASE, function))
    values = {(function, parameter): seconds(*times) for _, function, parameter, times in rows}
    lines = ["| | " + " | ".join(grid or "–" for grid in grids) + " |", "|---" * (1 + len(grids)) + "|"]
    for function in functions:
        cells = [values.get((function, grid), "–") for grid in grids]
        lines.append(f"| {function or group} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


if __name__ == "__main__":
    main()
