"""Makes the page of how full containers get, of its runs.

    python experiments/filling.py out/filling/filling.json

The file is what `ppnpack experiment filling` wrote; what the runs came to is added to it.
"""

import math

from pages import (
    UNSTEADY, WIDENED, kept, make, measured, of_change, of_count, of_decisions, of_difference, of_mean, of_share,
)


# Above the rim by less than this counts as below: bodies of a simulation are not quite where they touch.
RIM_M = 0.001


def columns(runs, others):
    """What the packings of a method came to; the others are those that they are compared with."""
    cm3, others_cm3 = ([1e6 * run["meshes_m3"] for run in of] for of in (runs, others))
    of = lambda key: [run[key] for run in runs]
    placed, unsteady = sum(of("placed")), sum(of("unsteady"))
    return [
        of_mean("items", "items", 1, of("items")),
        of_mean("meshes_cm3", "mesh volume (cm³)", 0, cm3),
        of_difference("difference_cm3", "difference (cm³)", 0, cm3, others_cm3),
        of_change("difference_percent", cm3, others_cm3),
        of_share("unsteady_percent", "unsteady", unsteady, placed),
        of_count("placed", None, placed),
        of_count("unsteady", None, unsteady),
        of_count("above_rim", "containers with something above the rim", sum(above_m > RIM_M for above_m in of("above_rim_m"))),
        of_mean("set_aside", "set aside", 1, of("set_aside")),
        of_share("in_other_pose_percent", "in another pose", sum(of("in_other_pose")), placed),
        of_count("steps_widened", "steps widened", sum(of("steps_widened"))),
        *of_decisions(runs),
    ]


def cell(apart):
    """How the cell differs from the twin."""
    friction, error = apart["friction"], apart["pose_error"]
    if friction == 1:
        return "## The cell is as the planner thinks it is\n"
    return f"""## The cell is another one than the twin

Friction of items and of walls times {1 / friction:.2f} to {friction:.2f}, drawn once a sequence; the poses of what lies there are known \
with normal errors of {1e3 * error["position_m"]:.0f} mm and {math.degrees(error["rotation_rad"]):.0f} degree per axis.
"""


def page(results, folder):
    last = results["first_case"] + results["cases"] - 1
    text = f"""# How full, how steady

Sequences {results["first_case"]} to {last} in robot conditions: laid down from 1 cm, by an exact scan where no camera is named. {UNSTEADY} \
Differences are to the first method, sequence by sequence, with 95 % intervals by Student's t. {WIDENED} Decision times are of one step on \
one thread, {results["workers"]} sequences at once.
"""
    for of_cell in results["tables"]:
        lines = [(line["name"], line, kept(folder, line, results)) for line in of_cell["lines"]]
        text += f"\n{cell(of_cell['apart'])}\n{measured('method', lines, columns, lines[0][2])}"
    return text


if __name__ == "__main__":
    make(__doc__, "filling", page)
