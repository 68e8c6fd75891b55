"""Draws the charts of experiments beside their results.

    python experiments/charts.py out/table1/table1.json out/train/epochs.json

Each file is what `ppnpack experiment NAME` or `ppnpack train` wrote; the charts are named by it. It needs matplotlib.
"""

import argparse
import json
import pathlib

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt

plt.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "ppnpack", "figure.figsize": (9, 6), "axes.grid": True, "grid.color": "#e4e7eb"})


def of(value, factor=1.0):
    """A mean with half the width of its interval, or a number."""
    if isinstance(value, dict):
        return value["mean"] * factor, value["half_width"] * factor
    return (value or 0.0) * factor, 0.0


def save(path):
    plt.tight_layout()
    plt.savefig(path, metadata={"Date": None})
    plt.close()
    return path


def scatter(path, groups, x, y, logarithmic=True):
    """A point for each line of each named group; `x` and `y` are a key, a factor and a label."""
    for name, lines in groups:
        points = [(of(line[x[0]], x[1]), of(line[y[0]], y[1]), line.get("method") or line.get("name")) for line in lines]
        (xs, x_errors), (ys, y_errors) = (zip(*(point[axis] for point in points)) for axis in (0, 1))
        plt.errorbar(xs, ys, xerr=x_errors, yerr=y_errors, fmt="o", elinewidth=1, label=name)
        for at_x, at_y, label in zip(xs, ys, (point[2] for point in points)):
            plt.annotate(label, (at_x, at_y), textcoords="offset points", xytext=(7, 4), fontsize=8)
    if logarithmic:
        plt.xscale("log")
    plt.xlabel(x[2])
    plt.ylabel(y[2])
    if len(groups) > 1:
        plt.legend()
    return save(path)


def bars(path, label, values):
    plt.barh([name for name, _ in values], [value for _, value in values])
    plt.gca().invert_yaxis()
    plt.xlabel(label)
    return save(path)


def curves(path, label, lines, key):
    for line in lines:
        shares = line[key]
        plt.plot([float(share) for share in shares], [of(mean)[0] for mean in shares.values()], label=line["network"])
    plt.xlabel("K (%)")
    plt.ylabel(label)
    plt.legend()
    return save(path)


def epochs(path, label, reports, values):
    """A curve for each value of the epochs of a training that has a name."""
    for name in values(reports[0]):
        plt.plot([report["epoch"] for report in reports], [values(report)[name] for report in reports], label=name)
    plt.xlabel("Epoch")
    plt.ylabel(label)
    plt.legend()
    return save(path)


def loss(report):
    validation = report["validation"]
    return {"training": report["training_loss"], **({"validation": validation["loss"]} if validation else {})}


def accuracy(report):
    validation = report["validation"]
    answers = validation["accuracies"]["over_all"] if validation else []
    return {f"K = {answer['percent']} %": 100 * answer["share"] for answer in answers}


DECISION = ("decision_s", 1e3, "Decision time per item (ms)")


def draw(path):
    """Draws what there is to draw of a file of results; gives the files of the charts."""
    results = json.loads(path.read_text())
    named = lambda suffix: path.with_name(f"{path.stem}{suffix}.svg")
    if isinstance(results, list):
        return [epochs(named("-loss"), "Loss", results, loss), epochs(named("-accuracy"), "Validation candidates (%)", results, accuracy)]
    if "grids" in results:
        volume = ("mesh_floor_compactness_percent", 1, "Compactness of the meshes by the floor (%)")
        groups = [(grid["name"], grid["lines"]) for grid in results["grids"]]
        single = [scatter(named("-" + grid["key"]), [group], DECISION, volume) for grid, group in zip(results["grids"], groups)]
        return [scatter(named(""), groups, DECISION, volume), *single]
    if "tables" in results:
        cells = ["the cell is the twin's" if table["apart"]["friction"] == 1 else "the cell is another one" for table in results["tables"]]
        groups = list(zip(cells, (table["lines"] for table in results["tables"])))
        volume = ("meshes_cm3", 1, "Mesh volume (cm³)")
        return [
            scatter(named(""), groups, ("unsteady_percent", 1, "Unsteady of what was placed (%)"), volume),
            scatter(named("-times"), groups, ("decision_95_s", 1e3, "Decision, 95 % take no longer (ms)"), volume),
        ]
    lines = results.get("lines", [])
    has = lambda key: bool(lines) and key in lines[0]
    if has("over_all"):
        return [
            curves(named(suffix), "Test candidates (%)", lines, key)
            for key, suffix in (("over_all", ""), ("proposed", "-proposed"), ("among_fitting", "-fitting"))
        ]
    if has("stages_ms"):
        times = lambda line: [(stage, line["stages_ms"][stage]["median"] or 0) for stage in ("recognise", "plan", "see")]
        return [bars(named(f"-{number}"), f"Median (ms): {line['method']}", times(line)) for number, line in enumerate(lines)]
    if has("containers_noticeably"):
        return [bars(named(""), "Containers with an item that carried over 110 % of what it may", [(it["name"], it["containers_noticeably"]) for it in lines])]
    if has("decision_s") and has("method"):
        return [scatter(named(""), [("ppnpack", lines)], DECISION, ("floor_compactness_percent", 1, "Compactness by the floor (%)"))]
    return []


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", nargs="+", type=pathlib.Path, help="files of results")
    for path in parser.parse_args().results:
        for chart in draw(path):
            print(chart)


if __name__ == "__main__":
    main()
