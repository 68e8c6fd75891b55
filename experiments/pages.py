"""Pages of results: means with their intervals, tables, and notes by hand that a new run keeps."""

import datetime
import json
import math
import pathlib
import platform
import shlex
import sys

# Everything from this line on is written by hand.
NOTES = "<!-- Notes: what follows is kept when the experiment is run again. -->"


def student(count):
    """The two-sided 95 % quantile of Student's t for the mean of so many values; 0 for a single one."""
    freedom = count - 1
    if freedom < 1:
        return 0.0
    scale = math.exp(math.lgamma((freedom + 1) / 2) - math.lgamma(freedom / 2)) / math.sqrt(freedom * math.pi)

    def within(end, steps=500):
        """The probability between 0 and `end`, by Simpson's rule."""
        densities = [(1 + (end * step / steps) ** 2 / freedom) ** (-(freedom + 1) / 2) for step in range(steps + 1)]
        return scale * end / steps / 3 * (densities[0] + 4 * sum(densities[1::2]) + 2 * sum(densities[2:-1:2]) + densities[-1])

    low, high = 1.0, 13.0
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if within(middle) < 0.475 else (low, middle)
    return low


def mean(values):
    """The mean of some values with half the width of its interval."""
    values = list(values)
    middle = sum(values) / max(len(values), 1)
    squares = sum((value - middle) ** 2 for value in values)
    error = math.sqrt(squares / max(len(values) - 1, 1) / max(len(values), 1))
    return {"mean": middle, "half_width": student(len(values)) * error}


def shown(of, decimals):
    """A mean and its interval with so many decimals."""
    # What rounds to nothing is not less than nothing.
    return f"{round(of['mean'], decimals) + 0.0:.{decimals}f} ± {of['half_width']:.{decimals}f}"


def share(part, whole):
    """A part of a whole as it is shown, and in percent."""
    return (f"{100 * part / whole:.1f} % ({part} of {whole})", 100 * part / whole) if whole else ("–", None)


def row(*cells):
    return f"| {' | '.join(map(str, cells))} |\n"


def table(heads, rows):
    """A table of lines that `row` made."""
    return row(*heads) + f"|{'---|' * len(heads)}\n" + "".join(rows)


def keep(line, columns):
    """Keeps columns of a line by their keys; with a `/` it is a part of what is before it."""
    for key, value in columns:
        *groups, last = key.split("/")
        place = line
        for group in groups:
            place = place.setdefault(group, {})
        place[last] = value


def kept(folder, names):
    """The runs that an experiment kept in a folder."""
    return [json.loads((folder / f"{name}.json").read_text()) for name in names]


def publish(path, text, results, version=None):
    """Writes a page and its figures as JSON beside it, each with what made it: this script, where they do not say so."""
    results.setdefault("origin", {
        "command": shlex.join(["python", *sys.argv]),
        "version": version,
        "machine": f"{platform.machine()}, {platform.system()}",
        "made": f"{datetime.datetime.now(datetime.timezone.utc):%Y-%m-%dT%H:%M:%SZ}",
    })
    path = pathlib.Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.with_suffix(".json").write_text(json.dumps(results, indent=2, ensure_ascii=False))
    origin = results["origin"]
    program = f", program {origin['program_blake3'][:16]}" if "program_blake3" in origin else ""
    made = "Made by `{command}` on {made} ({machine}), version {version}".format(**origin) + f"{program}."
    notes = path.read_text().partition(NOTES)[2] if path.exists() else ""
    path.write_text(f"{text.rstrip()}\n\n{made}\n\n{NOTES}{notes or chr(10)}")
    print(path)
