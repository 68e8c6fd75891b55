"""Packs the first objects of a sequence with each packing heuristic of the paper, and draws what becomes of them side by side.

    python experiments/figure5.py --sequences sequences.npy

Options that it does not know are those of `ppnpack pack`, for every method. It needs matplotlib.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy

from pages import publish, row, table

# The methods of Table I, each with what it says beside the published method; the network has its share in percent.
TRIES = {"from": "tries", "yaws": 3, "positions": 9}
METHODS = [
    ("Random, as published", {"heuristic": "random", "order": "shuffled", "proposals": TRIES}),
    ("Random", {"heuristic": "random", "order": "shuffled"}),
    ("DBL (BBox)", {"heuristic": "dbl", "order": "bbox-volume"}),
    ("HM (BBox)", {"heuristic": "hm", "order": "bbox-volume"}),
    ("DBL (Balance)", {"heuristic": "dbl"}),
    ("HM (Balance)", {"heuristic": "hm"}),
    ("PPN-Pack (K = 5 %)", "network:5"),
    ("SDFM", {"heuristic": "sdfm"}),
]

PICTURES = ["packed.png", "heightmap.png"]


def packed(asked, method, objects, folder):
    """The summary and the pictures of a packing; without the network, none of its."""
    command = [asked.program, "pack", "--conditions", "reference", "--json", "--out", folder, "--seed", str(asked.seed + asked.sequence)]
    command += ["--items", ",".join(map(str, objects)), *asked.further]
    if isinstance(method, str):
        command += ["--proposals", method]
    else:
        said = pathlib.Path(folder) / "method.json"
        said.write_text(json.dumps(method))
        command += ["--method", said]
    done = subprocess.run(command, stdout=subprocess.PIPE)
    if done.returncode:
        sys.exit(done.returncode)
    summary = json.loads(done.stdout)
    if isinstance(method, str) and summary["degraded"]:
        print(summary["degraded"][0]["reason"], file=sys.stderr)
        return None
    return summary, [plt.imread(pathlib.Path(folder) / name) for name in PICTURES]


def draw(path, title, columns):
    """The pictures of each method below its name."""
    figure, axes = plt.subplots(len(PICTURES), len(columns), figsize=(3.6 * len(columns), 7.2), squeeze=False)
    figure.suptitle(title, x=0.02, ha="left", weight="bold")
    for at, (line, pictures) in enumerate(columns):
        for axis, picture in zip(axes[:, at], pictures):
            axis.imshow(picture)
            axis.axis("off")
        told = f"{line['items']} items, {line['floor_compactness_percent']:.1f} %, {line['height_cm']:.1f} cm high"
        axes[0, at].set_title(f"{line['method']}\n{told}", fontsize=10)
    figure.tight_layout()
    figure.savefig(path, metadata={"Software": None})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False)
    parser.add_argument("--program", default="ppnpack", help="the program that packs")
    parser.add_argument("--sequences", type=pathlib.Path, required=True, help="a .npy file of sequences of object indices")
    parser.add_argument("--sequence", type=int, default=0, help="which of them, numbered from 0")
    parser.add_argument("--length", type=int, default=25, help="how many of its objects, from the first; the paper shows packings of 25")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=pathlib.Path, default="out/figure5", help="where the page and the picture are written")
    asked, asked.further = parser.parse_known_args()
    sequences = numpy.load(asked.sequences)
    if not 0 <= asked.sequence < len(sequences) or not 0 < asked.length <= sequences.shape[1]:
        parser.error(f"{asked.sequences} has {len(sequences)} sequences, numbered from 0, that have {sequences.shape[1]} objects")
    columns = []
    for name, method in METHODS:
        with tempfile.TemporaryDirectory() as folder:
            found = packed(asked, method, sequences[asked.sequence, : asked.length], folder)
        if found is None:
            continue
        summary, pictures = found
        line = {
            "method": name,
            "items": summary["packed"]["items"],
            "floor_compactness_percent": 100 * summary["floor_compactness"],
            "meshes_cm3": 1e6 * summary["packed"]["meshes_m3"],
            "height_cm": 100 * summary["height_m"],
        }
        columns.append((line, pictures))
    lines = [line for line, _ in columns]
    title = f"The first {asked.length} objects of sequence {asked.sequence} of {asked.sequences.name}"
    asked.out.mkdir(parents=True, exist_ok=True)
    draw(asked.out / "figure5.png", title, columns)
    cells = lambda it: (it["items"], f"{it['floor_compactness_percent']:.1f}", f"{it['meshes_cm3']:.0f}", f"{it['height_cm']:.1f}")
    heads = ["method", "items packed", "compactness by floor (%)", "mesh volume (cm³)", "height (cm)"]
    text = f"""# Figure 5: the same objects, packed by each method

{title}, in the conditions of the reference. One sequence says little of the methods: see table 1.

![The containers, and their heightmaps from above](figure5.png)

{table(heads, [row(line["method"], *cells(line)) for line in lines])}"""
    publish(asked.out / "figure5.md", text, {"settings": summary["settings"], "lines": lines}, summary["version"])


if __name__ == "__main__":
    main()
