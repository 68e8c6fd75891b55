"""Makes the page of what items carry, of its runs.

    python experiments/loads.py out/loads/loads.json

The file is what `ppnpack experiment loads` wrote; what the runs came to is added to it.
"""

import math

from pages import kept, make, measured, of_change, of_count, of_difference, of_mean, of_share, quantile

# Loads below this say little of the estimate, in kilograms.
NOTICEABLE_KG = 0.05

# Limits may be exceeded by so much, as a share of them.
TOLERATED = 0.1


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
    cm3, without_cm3 = ([1e6 * run["meshes_m3"] for run in of] for of in (runs, others))
    all_greatest = [greatest(run, limits_kg) for run in runs]
    flat = [excess for of_run in all_greatest for excess in of_run]
    noticeable = [excess for excess in flat if is_noticeable(excess)]
    at_end = [excess for run in runs if run["states"] for excess in excesses(run, len(run["states"]) - 1, limits_kg)]
    most = max(map(part_of_limit, flat), default=0.0)
    placed, unsteady = (sum(run[key] for run in runs) for key in ("placed", "unsteady"))
    worst = sorted(noticeable, key=part_of_limit, reverse=True)[:50]
    return [
        of_mean("meshes_cm3", "mesh volume (cm³)", 0, cm3),
        of_difference("difference_cm3", "difference (cm³)", 0, cm3, without_cm3),
        of_change("difference_percent", cm3, without_cm3),
        of_mean("refused", "placements refused by load", 0, [run["refused"] for run in runs]),
        of_count("exceeded", "limits exceeded", sum(part_of_limit(excess) > 1 for excess in flat)),
        of_count("exceeded_noticeably", "by more than 10 %", len(noticeable)),
        of_count("containers_noticeably", "containers with these", sum(any(map(is_noticeable, of_run)) for of_run in all_greatest)),
        of_count("exceeded_noticeably_at_end", "at the end", sum(map(is_noticeable, at_end))),
        ("greatest_share", "greatest share of a limit", f"{most:.2f}", most),
        of_share("unsteady_percent", "unsteady", unsteady, placed),
        of_count("placed", None, placed),
        of_count("unsteady", None, unsteady),
        ("worst", None, None, worst),
    ]


def ratios(runs, *_):
    """Loads at the end as measured, by what was estimated."""
    last = [reading for run in runs if run["states"] for reading in run["states"][-1]["readings"]]
    last = [reading for reading in last if reading["measured_kg"] >= NOTICEABLE_KG]
    by = [it["measured_kg"] / it["estimated_kg"] if it["estimated_kg"] else math.inf for it in last]
    count = lambda key, head, is_so: of_count(key, head, sum(map(is_so, last)))
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
        of_share("states_in_motion_percent", "in motion", sum(not state["is_still"] for state in states), len(states)),
        ("unbalanced_99_kg", "unbalanced", f"{1e3 * unbalanced_kg:.1f} g", unbalanced_kg),
    ]


def page(results, folder):
    lines = [(line["name"], line, kept(folder, line, results)) for line in results["lines"]]
    least, most = results["factors"]
    limits_kg = results["limits_kg"]
    return f"""# Loads: measured, estimated, allowed

{results["cases"]} containers of up to {results["items"]} items, sequences from {results["first_case"]} on, method \
*{results["way"]["name"]}*. Each object may carry between {least:g} and {most:g} times its own mass, a factor drawn once an object, or what \
the catalogue says. Loads are measured in the simulated cell, at rest, after every placement: the vertical forces, friction among them, with \
which other items press an item down. Impacts are not measured. Limits *exceeded* are items that carried more after any placement. \
Differences are to packing without limits, sequence by sequence, with 95 % intervals by Student's t.

{measured("line", lines, limits, lines[0][2], limits_kg)}
Loads of at least 50 g at the end, as measured, by what is estimated from where all items lie then. *Missed* are those estimated at less than \
a tenth; *beyond all above* those more than 10 % greater than the mass of all that was thought to rest there. *In motion* are placements \
after which something still moved; *unbalanced* says how exact the measure is: the difference between what an item is held up with and what \
it weighs and carries, for 99 % of them.

{measured("line", lines, ratios)}"""


if __name__ == "__main__":
    make(__doc__, "loads", page)
