"""Makes the page of what items carry, of its runs.

    python experiments/loads.py out/loads/loads.json

The file is what `ppnpack experiment loads` wrote; what the runs came to is added to it.
"""

import argparse
import json
import math
import pathlib

from pages import keep, kept, mean, publish, row, share, shown, table

# Loads below this say little of the estimate, in kilograms.
NOTICEABLE_KG = 0.05

# Limits may be exceeded by so much, as a share of them.
TOLERATED = 0.1


def quantile(values, part):
    """The value that a part of all stay below."""
    values = sorted(values)
    return values[min(int(len(values) * part), len(values) - 1)] if values else math.nan


def excesses(run, index, limits_kg):
    """What each item carries after a placement, against its limit."""
    state = run["states"][index]
    for reading in state["readings"]:
        if reading["arrival"] < len(run["objects"]):
            item = run["objects"][reading["arrival"]]
            of = {"sequence": run["number"], "placed": index + 1, "object": item, "limit_kg": limits_kg[item]}
            yield {**of, "is_still": state["is_still"], "reading": reading}


def part_of_limit(excess):
    return excess["reading"]["measured_kg"] / excess["limit_kg"]


def is_noticeable(excess):
    return part_of_limit(excess) > 1 + TOLERATED


def greatest(run, limits_kg):
    """The greatest share of its limit that each item of a run carried."""
    found = {}
    for index in range(len(run["states"])):
        for excess in excesses(run, index, limits_kg):
            known = found.setdefault(excess["reading"]["arrival"], excess)
            if part_of_limit(excess) > part_of_limit(known):
                found[excess["reading"]["arrival"]] = excess
    return [excess for _, excess in sorted(found.items())]


def limits(runs, others, limits_kg):
    """What is allowed, and what it costs: a key, a head, what is shown and what is kept of each; others are packed without limits."""
    cm3 = [1e6 * run["meshes_m3"] for run in runs]
    without_cm3 = [1e6 * run["meshes_m3"] for run in others]
    difference = mean(one - other for one, other in zip(cm3, without_cm3))
    change = 100 * difference["mean"] / mean(without_cm3)["mean"]
    refused = mean(run["refused"] for run in runs)
    all_greatest = [greatest(run, limits_kg) for run in runs]
    flat = [excess for of_run in all_greatest for excess in of_run]
    noticeable = [excess for excess in flat if is_noticeable(excess)]
    at_end = [excess for run in runs if run["states"] for excess in excesses(run, len(run["states"]) - 1, limits_kg)]
    most = max(map(part_of_limit, flat), default=0.0)
    placed, unsteady = (sum(run[key] for run in runs) for key in ("placed", "unsteady"))
    count = lambda key, head, number: (key, head, number, number)
    worst = sorted(noticeable, key=part_of_limit, reverse=True)[:50]
    return [
        ("meshes_cm3", "mesh volume (cm³)", shown(mean(cm3), 0), mean(cm3)),
        ("difference_cm3", "difference (cm³)", shown(difference, 0), difference),
        ("difference_percent", "", f"{change:+.1f} %", change),
        ("refused", "placements refused by load", shown(refused, 0), refused),
        count("exceeded", "limits exceeded", sum(part_of_limit(excess) > 1 for excess in flat)),
        count("exceeded_noticeably", "by more than 10 %", len(noticeable)),
        count("containers_noticeably", "containers with these", sum(any(map(is_noticeable, of_run)) for of_run in all_greatest)),
        count("exceeded_noticeably_at_end", "at the end", sum(map(is_noticeable, at_end))),
        ("greatest_share", "greatest share of a limit", f"{most:.2f}", most),
        ("unsteady_percent", "unsteady", *share(unsteady, placed)),
        ("placed", None, None, placed),
        ("unsteady", None, None, unsteady),
        ("worst", None, None, worst),
    ]


def ratios(runs, *_):
    """Loads at the end as measured, by what was estimated."""
    last = [reading for run in runs if run["states"] for reading in run["states"][-1]["readings"]]
    last = [reading for reading in last if reading["measured_kg"] >= NOTICEABLE_KG]
    by = [it["measured_kg"] / it["estimated_kg"] if it["estimated_kg"] else math.inf for it in last]
    count = lambda key, head, is_so: (key, head, *[sum(map(is_so, last))] * 2)
    of_ratio = lambda key, head, part: (key, head, f"{quantile(by, part):.2f}", quantile(by, part))
    states = [state for run in runs for state in run["states"]]
    unbalanced_kg = quantile([abs(it["unbalanced_kg"]) for state in states for it in state["readings"]], 0.99)
    return [
        count("ratios/loads", "loads", lambda _: True),
        of_ratio("ratios/median", "median", 0.5),
        of_ratio("ratios/most_95", "95 %", 0.95),
        of_ratio("ratios/most_99", "99 %", 0.99),
        of_ratio("ratios/greatest", "greatest", 1.0),
        count("ratios/missed", "missed", lambda it: it["estimated_kg"] < 0.1 * it["measured_kg"]),
        count("ratios/beyond_all_above", "beyond all above", lambda it: it["measured_kg"] > (1 + TOLERATED) * it["above_kg"]),
        ("states_in_motion_percent", "in motion", *share(sum(not state["is_still"] for state in states), len(states))),
        ("unbalanced_99_kg", "unbalanced", f"{1e3 * unbalanced_kg:.1f} g", unbalanced_kg),
    ]


def measured(lines, measure, *others):
    """A table of the columns of each line that are shown; all are kept."""
    rows = []
    for line, runs in lines:
        columns = measure(runs, *others)
        # JSON has no numbers that are not finite.
        finite = lambda value: None if isinstance(value, float) and not math.isfinite(value) else value
        keep(line, [(key, finite(value)) for key, _, _, value in columns])
        rows.append(row(line["name"], *(told for _, head, told, _ in columns if head is not None)))
    return table(["line", *(head for _, head, _, _ in columns if head is not None)], rows)


def page(results, folder):
    lines = [(line, kept(folder / line["folder"], results["runs"])) for line in results["lines"]]
    least, most = results["factors"]
    limits_kg = results["limits_kg"]
    return f"""# Loads: measured, estimated, allowed

{results["cases"]} containers of up to {results["items"]} items, sequences from {results["first_case"]} on, method \
*{results["way"]["name"]}*. Each object may carry between {least:g} and {most:g} times its own mass, a factor drawn once an object, or what \
the catalogue says. Loads are measured in the simulated cell, at rest, after every placement: the vertical forces, friction among them, with \
which other items press an item down. Impacts are not measured. Limits *exceeded* are items that carried more after any placement. \
Differences are to packing without limits, sequence by sequence, with 95 % intervals by Student's t.

{measured(lines, limits, lines[0][1], limits_kg)}
Loads of at least 50 g at the end, as measured, by what is estimated from where all items lie then. *Missed* are those estimated at less than \
a tenth; *beyond all above* those more than 10 % greater than the mass of all that was thought to rest there. *In motion* are placements \
after which something still moved; *unbalanced* says how exact the measure is: the difference between what an item is held up with and what \
it weighs and carries, for 99 % of them.

{measured(lines, ratios)}"""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", type=pathlib.Path, help="what `ppnpack experiment loads` wrote")
    parser.add_argument("--runs", type=pathlib.Path, help="where it kept its runs [default: runs beside the file]")
    asked = parser.parse_args()
    results = json.loads(asked.results.read_text())
    publish(asked.results.with_suffix(".md"), page(results, asked.runs or asked.results.with_name("runs")), results)


if __name__ == "__main__":
    main()
