"""Makes the page of the robot cell, simulated, of its runs.

    python experiments/physical.py out/physical/physical.json

The file is what `ppnpack experiment physical` wrote; what the runs came to is added to it.
"""

import argparse
import collections
import json
import math
import pathlib

from pages import keep, of_count, of_mean, of_share, publish, row, table

# How far a pose on the tray, and one found after a placement, may be off, in metres and radians.
GOOD_POSE, GOOD_FOUND = (0.003, 0.053), (0.005, 0.088)

# Leaning by more than this, in degrees, an item counts as toppled.
TOPPLED_DEG = 30.0

STAGES = {
    "recognise": "tray: cloud to items",
    "plan": "request to decision",
    "see": "container: cloud to heightmap",
    "inspect": "placed to inspected",
    "simulate": "simulated placement",
}


def spread(values):
    """The median of some values, and what 95 % of them stay below."""
    values = sorted(values)
    median, most = (values[int((len(values) - 1) * part + 0.5)] if values else None for part in (0.5, 0.95))
    told = f"{median:.1f}, {most:.1f}" if values else "–"
    return told, {"median": median, "most": most, "count": len(values)}


def ended(item, kind):
    """How an item ended where it ended so; else nothing."""
    return item["end"].get(kind) if isinstance(item["end"], dict) else None


def pose_off(said):
    """How far a pose is off, where both parts of that are known."""
    off = (said.get("position_off_m"), said.get("angle_off_rad"))
    return None if None in off else off


def seen_off(item):
    """How far the pose of an item that was recognised rightly is off."""
    seen_as = item["seen_as"]
    return pose_off(seen_as["object"]) if isinstance(seen_as, dict) and item["is_known"] else None


def is_within(off, most):
    return all(one <= other for one, other in zip(off, most))


def total_ms(decision):
    return 1e3 * sum(decision[stage] for stage in ("propose_s", "evaluate_s", "check_s"))


def came_to(runs):
    """What the runs of a method came to: a key, a head, what is shown and what is kept of each."""
    items = [item for run in runs for item in run["items"]]
    decisions = [decision for run in runs for decision in run["decisions"]]
    placed = [it for it in (ended(item, "placed") for item in items) if it]
    toppled = sum(it["tilt_rad"] > math.radians(TOPPLED_DEG) for it in placed)
    known = [item for item in items if item["is_known"]]
    offs = [off for off in map(seen_off, items) if off]
    strangers = [item["seen_as"] == "unknown" for item in items if not item["is_known"]]
    found = [item["found"] for item in items if item["found"]]
    found_offs = [off for off in map(pose_off, found) if off]
    times_ms = [total_ms(decision) for decision in decisions]
    kinds = collections.Counter(it["kind"] for it in found)
    overlap_mm = max((1e3 * run["deepest_overlap_m"] for run in runs), default=0.0)
    disturbance_mm = max((1e3 * it["disturbance_m"] for it in placed), default=0.0)
    return [
        of_count("runs", "runs", len(runs)),
        of_count("items/all", "items", len(items)),
        of_count("items/placed", "placed", len(placed)),
        of_count("items/outside", "of these outside the container", sum(not it["is_inside"] for it in placed)),
        of_count("items/toppled", "of these leaning by over 30 degrees", toppled),
        of_share("items/toppled_percent", "leaning, of those placed", toppled, len(placed)),
        of_count("items/refused", "refused with a reason", sum(bool(ended(it, "refused")) or it["end"] == "waiting" for it in items)),
        of_count("items/lost", "dropped beside the container", sum(ended(it, "lost") is not None for it in items)),
        of_count("items/repeated", "placements repeated after missed picks", sum(max(it["attempts"] - 1, 0) for it in items)),
        of_count("runs_ended_by_doubt", "runs ended by a doubtful scene", sum(run["doubt"] is not None for run in runs)),
        ("deepest_overlap_mm", "deepest overlap of two items at the end (mm)", f"{overlap_mm:.2f}", overlap_mm),
        ("greatest_disturbance_mm", "farthest that a placement moved another item (mm)", f"{disturbance_mm:.1f}", disturbance_mm),
        of_mean("compactness_percent", "compactness of meshes by floor (%)", 1, [100 * run["compactness"] for run in runs]),
        of_mean("volume_l", "volume of meshes (l)", 2, [1e3 * run["volume_m3"] for run in runs]),
        of_mean("decision_mean_ms", "decision: mean (ms)", 2, times_ms),
        ("decision_ms", "decision: median, 95 % (ms)", *spread(times_ms)),
        of_count("decisions", "decisions", len(decisions)),
        of_count("degraded_decisions", "of these degraded", sum(bool(it["degraded"]) for it in decisions)),
        of_count("widened_decisions", "widened to an exhaustive search", sum(it["is_widened"] for it in decisions)),
        of_share("seen/right_percent", "known items recognised", len(offs), len(known)),
        of_share("seen/good_poses_percent", "of these within 3 mm and 3 degrees", sum(is_within(it, GOOD_POSE) for it in offs), len(offs)),
        of_share("seen/strangers_as_unknown_percent", "unknown items called unknown", sum(strangers), len(strangers)),
        of_count("found/as_planned", "inspected: as planned", kinds["as_planned"]),
        *(of_count(f"found/{kind}", kind, kinds[kind]) for kind in ("moved", "toppled", "missing", "unclear")),
        of_share(
            "found/good_poses_percent",
            "poses found within 5 mm and 5 degrees",
            sum(is_within(it, GOOD_FOUND) for it in found_offs),
            len(found_offs),
        ),
    ]


def times(runs):
    """How long a method's stages took."""
    of_stage = lambda stage: [1e3 * time_s for run in runs for time_s in run["stages_s"].get(stage, [])]
    cycles_s = [it["cycle_s"] for run in runs for it in run["decisions"] if it["cycle_s"] > 0]
    stages = [(f"stages_ms/{stage}", head, *spread(of_stage(stage))) for stage, head in STAGES.items()]
    return [*stages, ("cycle_s", "arm's cycle, planned (s)", *spread(cycles_s))]


def upright(lines, measure):
    """A table with a row for each column and a column for each method, whose columns are kept."""
    measured = [measure(line["records"]) for line in lines]
    for line, columns in zip(lines, measured):
        keep(line, columns)
    rows = [row(columns[0][1], *(cell[2] for cell in columns)) for columns in zip(*measured)]
    return table(["", *(line["method"] for line in lines)], rows)


def page(results):
    settings, lines = results["settings"], results["lines"]
    faults, arm = settings["faults"], settings["arm"]
    strangers = ", the unseen ones not known to the recogniser" if settings["strangers"] else ""
    text = f"""# The robot cell, simulated

Container 30 x 30 x 16 cm, {1e3 * settings["grid"]["cell_m"]:.1f} mm cells, {settings["grid"]["yaws"]} yaws, buffer \
{settings["buffer"]}; {settings["unseen_count"]} unseen objects and {settings["known_count"]} other a run{strangers}; arm \
{arm["arm"] if arm else "none"}; placement noise {1e3 * settings["simulated"]["release"]["jitter_m"]:.1f} mm, \
{100 * faults["missed_picks"]:.0f} % of picks miss, {100 * faults["drops"]:.0f} % of items are dropped; depth cameras with 1 mm of noise \
and 5 % dropouts above container and tray. Seed {settings["seed"]}. Intervals are 95 % confidence intervals, by Student's t: of a run's \
compactness and volume over the runs, of decisions over the decisions.

Objects are drawn from those that fit into the empty container and that the arm can hold in at least 80 % of the cases, by the chances \
of their resting poses: {results["unseen_held"]} unseen ones and {results["others_held"]} others.

"""
    if results.get("without_network"):
        text += f"Without the network: {results['without_network']}.\n\n"
    text += f"""{upright(lines, came_to)}
## Time line

Median and what 95 % stay below, in ms; the arm's cycle in s.

{upright(lines, times)}
## Why items were refused

"""
    for line in lines:
        reasons = [ended(item, "refused") for run in line["records"] for item in run["items"]]
        line["refusals"] = dict(sorted(collections.Counter(it["reason"] for it in reasons if it).items()))
    reasons = sorted({reason for line in lines for reason in line["refusals"]})
    rows = [row(reason, *(line["refusals"].get(reason, 0) for line in lines)) for reason in reasons]
    return text + table(["", *(line["method"] for line in lines)], rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", type=pathlib.Path, help="what `ppnpack experiment physical` wrote")
    path = parser.parse_args().results
    results = json.loads(path.read_text())
    publish(path.with_suffix(".md"), page(results), results)


if __name__ == "__main__":
    main()
