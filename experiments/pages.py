"""Pages of results: means with their intervals, tables, and notes by hand that a new run keeps."""

import argparse
import datetime
import json
import math
import pathlib
import platform
import shlex
import sys

# Everything from this line on is written by hand.
NOTES = "<!-- Notes: what follows is kept when the experiment is run again. -->"

# What pages say of their terms.
UNSTEADY = "*Unsteady* is what toppled by more than 30 degrees, slid by more than 2 cm or left the container when it was placed."
WIDENED = "A step is widened to an exhaustive search where none of its proposals is valid."


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


def quantile(values, part):
    """The value that a part of all stay below."""
    values = sorted(values)
    return values[min(int(len(values) * part), len(values) - 1)] if values else math.nan


# A column of a line is a key, a head, what is shown and what is kept; without a head it is kept alone.


def of_mean(key, head, decimals, values, scale=1.0, unit=""):
    """The column of a mean, which is shown so many times as great."""
    of = mean(values)
    return key, head, shown({name: scale * value for name, value in of.items()}, decimals) + unit, of


def of_count(key, head, number):
    return key, head, number, number


def of_share(key, head, part, whole):
    return key, head, *share(part, whole)


def of_time(key, head, part, decimals, times_s):
    """The column of what a part of all times stay below."""
    time_s = quantile(times_s, part)
    return key, head, f"{1e3 * time_s:.{decimals}f} ms", time_s


def of_difference(key, head, decimals, values, others):
    """The column of the mean of the differences, one by one."""
    return of_mean(key, head, decimals, (one - other for one, other in zip(values, others)))


def of_change(key, values, others):
    """The column of that mean by the others' mean, in percent."""
    all_others = sum(others)
    percent = 100 * (sum(values) - all_others) / all_others if all_others else math.nan
    return key, "", f"{percent:+.1f} %", percent


def of_decisions(runs):
    """The columns of how long decisions took."""
    times_s = [time_s for run in runs for time_s in run["decision_s"]]
    ends = [("decision_median_s", "decision, median", 0.5), ("decision_95_s", "95 %", 0.95)]
    return [of_time(key, head, part, 1, times_s) for key, head, part in ends]


def row(*cells):
    return f"| {' | '.join(map(str, cells))} |\n"


def table(heads, rows):
    """A table of lines that `row` made."""
    return row(*heads) + f"|{'---|' * len(heads)}\n" + "".join(rows)


def finite(value):
    """A value without numbers that are not finite, which JSON has not."""
    if isinstance(value, dict):
        return {key: finite(of) for key, of in value.items()}
    return None if isinstance(value, float) and not math.isfinite(value) else value


def keep(line, columns):
    """Keeps columns of a line by their keys; with a `/` it is a part of what is before it."""
    for key, _, _, value in columns:
        *groups, last = key.split("/")
        place = line
        for group in groups:
            place = place.setdefault(group, {})
        place[last] = finite(value)


def measured(head, lines, measure, *others):
    """A table with a row for each line: its name, and the columns that `measure` gives of its runs; all columns are kept."""
    rows, heads = [], []
    for name, line, runs in lines:
        columns = measure(runs, *others)
        keep(line, columns)
        heads = [head, *(column[1] for column in columns if column[1] is not None)]
        rows.append(row(name, *(column[2] for column in columns if column[1] is not None)))
    return table(heads, rows)


def kept(folder, line, results):
    """The runs of a line that an experiment kept in its folder, in their order."""
    first = results.get("first_case", 0)
    names = results.get("runs") or [f"{number:05}" for number in range(first, first + results["cases"])]
    return [json.loads((folder / line["folder"] / f"{name}.json").read_text()) for name in names]


def options(description, experiment):
    """The options of a program that makes the page of an experiment, which are parsed."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", type=pathlib.Path, help=f"what `ppnpack experiment {experiment}` wrote")
    parser.add_argument("--runs", type=pathlib.Path, help="where it kept its runs [default: runs beside the file]")
    return parser


def make(description, experiment, page):
    """Publishes the page that `page` makes of the results of an experiment and the folder of its runs."""
    of = options(description, experiment).parse_args()
    results = json.loads(of.results.read_text())
    text = page(results, of.runs or of.results.with_name("runs"))
    publish(of.results.with_suffix(".md"), text, results)


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
    # What cannot be read may have notes: then nothing is written.
    notes = path.read_text().partition(NOTES)[2] if path.exists() else ""
    write(path.with_suffix(".json"), json.dumps(results, indent=2, ensure_ascii=False))
    origin = results["origin"]
    program = f", program {origin['program_blake3'][:16]}" if "program_blake3" in origin else ""
    made = "Made by `{command}` on {made} ({machine}), version {version}".format(**origin) + f"{program}."
    write(path, f"{text.rstrip()}\n\n{made}\n\n{NOTES}{notes or chr(10)}")
    print(path)


def write(path, text):
    """Writes a file as a whole, or not at all."""
    new = path.with_name(f"{path.name}.new")
    new.write_text(text)
    new.replace(path)
