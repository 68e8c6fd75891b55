"""Makes the page of table 1, 2 or 4, or of decision times against volumes, of its runs.

    python experiments/tables.py out/table1/table1.json

The file is what `ppnpack experiment table1`, `table2`, `table4` or `pareto` wrote; what the runs came to is added to it.
"""

from pages import WIDENED, kept, make, mean, measured, of_count, of_difference, of_mean, of_share, row, shown, table

# What the paper reports of each method: seconds, cm³, percent, items.
RANDOM = (0.05, 10905, 39.9, 27.54)
RANDOM_UNSEEN = (0.37, 19029, 39.5, 27.54)
PAPER = {
    "table1": {
        "random-published": RANDOM,
        "random": RANDOM,
        "dbl-bbox": (0.82, 15073, 50.2, 37.17),
        "hm-bbox": (0.83, 15496, 51.7, 38.60),
        "dbl-balance": (1.90, 15117, 50.3, 36.21),
        "hm-balance": (1.64, 14094, 49.2, 38.43),
        "ppn": (0.43, 16525, 55.9, 39.88),
        "sdfm": (1.86, 16897, 56.8, 40.77),
    },
    "table4": {
        "random-published": RANDOM_UNSEEN,
        "random": RANDOM_UNSEEN,
        "ppn": (0.45, 22993, 47.3, 33.69),
        "sdfm": (1.58, 25001, 49.8, 34.26),
    },
}

# Of other objects, 50 easy and 50 hard ones a sequence.
PAPER_OF_CLASSES = {
    "regular": {"hierarchical reinforcement learning": (0.97, None, 45.6, 40.38), "PPN-Pack": (0.87, None, 47.9, 44.16)},
    "irregular": {"hierarchical reinforcement learning": (0.97, None, 42.3, 37.28), "PPN-Pack": (0.93, None, 42.4, 45.61)},
}

TERMS = f"""Compactness is the volume of the packed items over the floor times the greatest height, after the paper's published code, \
whose scan is from before the last placement, or over the minimum bounding box of what was packed, as in its text. K is a share of all \
placements: as many are proposed, but none that does not fit. {WIDENED}"""

RANDOM_ROWS = """`Random` places at any feasible placement, as the paper's text has it, and ends where there is none. `Random, as \
published` tries three yaws with three by three positions each and ends where none of these is valid for any item of the buffer; the published \
code tries four yaws, and takes the first item that has a valid one, at its least yaw and x. The network is this project's."""


def decision_s(run):
    return sum(run["decision_s"]) / max(len(run["decision_s"]), 1)


def ratio(values, others):
    """The sum of some values by that of others on the same sequences, in percent, with the interval of a ratio of paired means."""
    theirs = sum(others)
    if theirs <= 0:
        return {"mean": 0.0, "half_width": 0.0}
    part = sum(values) / theirs
    # By the differences to the ratio's line.
    apart = mean(value - part * other for value, other in zip(values, others))
    return {"mean": 100 * part, "half_width": 100 * apart["half_width"] * len(values) / theirs}


def columns(runs, others, has_stages=False):
    """What the packings of a method came to, and what of the others' that is; the stages of decisions are shown on demand."""
    values = lambda of, key, scale=1: [scale * run[key] for run in of]
    percent = lambda key, head: of_mean(key, head, 1, values(runs, key.removesuffix("_percent"), 100))
    milliseconds = lambda key, head, of: of_mean(key, head, 3, of, 1e3, " ms")
    stage = lambda key, head: milliseconds(key, head if has_stages else None, values(runs, key))

    def part(key, head, ours, theirs):
        of = ratio(ours, theirs)
        return key, head, shown(of, 1), of

    of_key = lambda key: (values(runs, key), values(others, key))
    placed, widened = (sum(values(runs, key)) for key in ("placed", "steps_widened"))
    found = [
        of_count("cases", None, len(runs)),
        milliseconds("decision_s", "decision per item", map(decision_s, runs)),
        stage("propose_s", "proposing"),
        stage("evaluate_s", "evaluating"),
        stage("check_s", "checking"),
        of_mean("items", "items packed", 1, values(runs, "items")),
        of_mean("voxels_cm3", "voxel volume (cm³)", 0, values(runs, "voxels_m3", 1e6)),
        percent("floor_compactness_percent", "compactness by floor (%)"),
        percent("box_compactness_percent", "compactness by box (%)"),
        of_mean("meshes_cm3", "mesh volume (cm³)", 0, values(runs, "meshes_m3", 1e6)),
        percent("mesh_floor_compactness_percent", "mesh compactness by floor (%)"),
        of_mean("height_m", None, 3, values(runs, "height_m")),
        part("floor_compactness_ratio_percent", "share of the search's compactness (%)", *of_key("floor_compactness")),
        part("mesh_volume_ratio_percent", "of its mesh volume (%)", *of_key("meshes_m3")),
        of_mean("fallen_out", "fell out", 2, [run["placed"] - run["items"] for run in runs]),
        of_count("steps", None, placed),
        of_count("steps_widened", None, widened),
        of_share("steps_widened_percent", "steps widened", widened, placed),
    ]
    if has_stages:
        times_s = (list(map(decision_s, of)) for of in (runs, others))
        found.append(part("decision_ratio_percent", "of its time (%)", *times_s))
    return found


def differences(runs, others):
    """By how much a method packs more than the search of all placements."""
    both = lambda key, scale=1: ([scale * run[key] for run in of] for of in (runs, others))
    return [
        of_difference("difference/items", "items packed", 1, *both("items")),
        of_difference("difference/voxels_cm3", "voxel volume (cm³)", 0, *both("voxels_m3", 1e6)),
        of_difference("difference/meshes_cm3", "mesh volume (cm³)", 0, *both("meshes_m3", 1e6)),
        of_difference("difference/floor_compactness_percent", "compactness by floor (points)", 1, *both("floor_compactness", 100)),
    ]


def published(name, figures):
    """The first cells of a row of the paper's figures."""
    seconds, volume, compactness, items = figures
    return row(f"*{name}*", f"{seconds} s", f"{items:.1f}", "" if volume is None else f"{volume:.0f}", f"{compactness:.1f}")


def compared(results, folder, lines):
    """The tables of some methods, which are compared with the last of them, the search of all placements; and its runs."""
    for line in lines:
        if line["key"] == "sdfm" and results["experiment"] != "table1":
            line["method"] = "Search all"
        line["paper"] = PAPER.get(results["experiment"], {}).get(line["key"])
    named = [(line["method"], line, kept(folder, line, results)) for line in lines]
    search = named[-1][2]
    papers = [published(f"{line['method']}, the paper", line["paper"]) for line in lines if line["paper"]]
    return f"""
{measured("method", named, columns, search)}{"".join(papers)}
Means of the differences to the search of all placements, on the same sequences:

{measured("method", named, differences, search)}""", search


def head(results, title, text):
    """The beginning of a page, which says how sequences were packed."""
    grid, cell = results["grid"], results["simulated"]
    sides_cm = " x ".join(f"{100 * side_m:.0f}" for side_m in grid["container"].values())
    cameras = {1: "one camera in place of a", 2: "two cameras in place of a"}
    scan = cameras[cell["camera"]["cameras"]] if cell.get("camera") else cell["scan"]
    missing = f"\nThe network is missing: {results['without_network']}.\n" if results["without_network"] else ""
    return f"""# {title}

{text} Container {sides_cm} cm, cells of {1e3 * grid["cell_m"]:g} mm, {grid["yaws"]} yaws, buffer {results["buffer"]}, published stability \
test, {scan} scan; {results["workers"]} sequences at once, each on one core. Intervals are 95 % confidence intervals over the sequences, by \
Student's t.

{TERMS}
{missing}"""


def sequences(results):
    return f"Sequences {results['first_case']} to {results['first_case'] + results['cases'] - 1}"


def table1(results, folder):
    text = f"{sequences(results)}. In italics the paper's figures, of 2,000 sequences, its own meshes and machine. {RANDOM_ROWS}"
    tables, search = compared(results, folder, results["lines"])
    page = head(results, "Table 1: packing heuristics", text) + tables
    if results["bounded"]:
        lines = [(line["grid"], line, kept(folder, line, results)) for line in results["bounded"]]
        page += f"""
## The bounded search on other grids

SDFM (Balance) on the same sequences; it chooses what the search of all placements chooses. Voxels inflate items, less on finer grids: only \
items and the volume of the meshes compare across grids. Shares and differences are to that search on the grid above.

{measured("grid", lines, columns, search)}
{measured("grid", lines, differences, search)}"""
    return page


def table2(results, folder):
    text = f"""{results["cases"]} random sequences of each class. Regular is what fills at least {100 * results["regular_share"]:.0f} % of \
its bounding box; all other objects are irregular. The paper's objects are not published: its rows are of other objects, and say nothing about \
ours."""
    page = head(results, "Table 2: easy and hard shapes", text)
    heads = ["the paper, on its own objects", "decision per item", "items packed", "voxel volume (cm³)", "compactness (%)"]
    for of in results["classes"]:
        lines = [line for line in results["lines"] if line["class"] == of["name"]]
        tables, _ = compared(results, folder, lines)
        papers = [published(*of_paper) for of_paper in PAPER_OF_CLASSES[of["name"]].items()]
        page += f"\n## {len(of['objects'])} {of['name']} objects\n{tables}\n{table(heads, papers)}"
    return page


def table4(results, folder):
    text = f"""{results["cases"]} random sequences of {results["objects"]} objects, seed {results["seed"]}. In italics the paper's figures, of \
400 sequences of its 28 objects: its volumes need a container of some 48 litres, so that of these only shares compare. {RANDOM_ROWS}"""
    tables, _ = compared(results, folder, results["lines"])
    return head(results, "Table 4: objects that the network was not trained on", text) + tables


def pareto(results, folder):
    text = f"""{sequences(results)}, the same for every method; SDFM; shares are of the exhaustive search (`all`) on the same grid, in this \
run."""
    page = head(results, "Decision time against packed volume", text)
    for grid in results["grids"]:
        lines = [(line["method"], line, kept(folder, line, results)) for line in grid["lines"]]
        page += f"\n## {grid['name']}\n\n{measured('proposals', lines, columns, lines[0][2], True)}"
    return page


PAGES = {"table1": table1, "table2": table2, "table4": table4, "pareto": pareto}

if __name__ == "__main__":
    make(__doc__, "table1", lambda results, folder: PAGES[results["experiment"]](results, folder))
