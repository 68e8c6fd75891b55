"""Makes the page of the benchmark of boxes, of its runs.

    python experiments/boxes.py out/boxes/boxes.json

The file is what `ppnpack experiment boxes` wrote; what the runs came to is added to it.
"""

import math

from pages import kept, make, mean, measured, of_count, of_mean, of_time

BIN_VOLUME = 1000

SETTINGS = {"1": "1: two orientations, boxes have to be stable", "2": "2: six orientations, no stability rule"}

# The others are those of the engine, whose names are short for something.
WORDS = {"snug", "look-ahead"}


def filled_percent(run):
    """The share of the bin that is filled."""
    return 100 * sum(math.prod(placed["sides"].values()) for placed in run["placed"]) / BIN_VOLUME


def columns(runs):
    """What the packings of a method came to."""
    filled = [filled_percent(run) for run in runs]
    middle = mean(filled)["mean"]
    times_s = [time_s for run in runs for time_s in run["decision_s"]]
    return [
        of_mean("utilisation_percent", "utilisation (%)", 1, filled),
        ("utilisation_variance", None, None, mean((value - middle) ** 2 for value in filled)),
        of_mean("boxes", "boxes", 1, [len(run["placed"]) for run in runs]),
        of_time("decision_median_s", "decision, median", 0.5, 3, times_s),
        of_time("decision_longest_s", "decision, longest", 1.0, 1, times_s),
        of_count("decisions", None, len(times_s)),
    ]


def page(results, folder):
    text = f"""# Online box packing

A bin of 10 x 10 x 10, boxes with whole sides drawn uniformly from 1 to 5, one known at a time; an episode ends with the first box that fits \
nowhere. {results["instances"]} instances from {results["first"]} on, seed {results["seed"]}; means with 95 % confidence intervals. \
{results["workers"]} at once.
"""
    for setting, rules in SETTINGS.items():
        lines = []
        for line in (line for line in results["lines"] if line["setting"] == setting):
            line["name"] = line["method"] if line["method"] in WORDS else line["method"].upper()
            # Several instances are kept together.
            lines.append((line["name"], line, sum(kept(folder, line, results), [])))
        if lines:
            text += f"\n## Setting {rules}\n\n{measured('method', lines, columns)}"
    return text


if __name__ == "__main__":
    make(__doc__, "boxes", page)
