"""Compares the carton that `ppnpack carton` chooses for orders with the one that a plain rule chooses.

    python experiments/carton.py --program target/release/ppnpack --orders 200

The orders are drawn from the built-in household objects. The plain rule takes the smallest carton of which the boxes around the items
fill at most a share, and in which each item's longest sides have room. Options that it does not know are those of `ppnpack carton`.
"""

import argparse
import collections
import csv
import json
import pathlib
import random
import statistics
import subprocess
import sys
import tempfile
import time

from pages import of_count, of_share, publish, row, table

# Inner sizes in centimetres, the smallest first.
CARTONS = {"XS": (20, 15, 10), "S": (25, 20, 12), "M": (30, 25, 15), "L": (35, 30, 20), "XL": (45, 35, 30)}
SIZES = list(CARTONS)
ITEMS = (3, 12)
FILL = 0.6


def volume_m3(size_cm):
    x, y, z = size_cm
    return x * y * z * 1e-6


def has_room(item, size_cm):
    """Whether the box around an item has room, side by side."""
    return all(side <= room / 100 for side, room in zip(sorted(item["extents_m"]), sorted(size_cm)))


def by_rule(items):
    """The size that the plain rule chooses; none where it has none."""
    boxes_m3 = sum(x * y * z for x, y, z in (item["extents_m"] for item in items))
    does = (name for name, size in CARTONS.items() if boxes_m3 <= FILL * volume_m3(size) and all(has_room(item, size) for item in items))
    return next(does, None)


def draw(objects, count, seed):
    """Orders of objects that each have room in the largest carton."""
    drawn = random.Random(seed)
    possible = [item for item in objects if has_room(item, CARTONS[SIZES[-1]])]
    return [[drawn.choice(possible) for _ in range(drawn.randint(*ITEMS))] for _ in range(count)]


def answer(asked, number, items, folder):
    """What the command answers for an order, and how long it takes."""
    order = folder / "order.csv"
    with order.open("w", newline="") as file:
        counts = collections.Counter(item["name"] for item in items)
        csv.writer(file).writerows([("item", "quantity"), *counts.items()])
    command = [asked.program, "carton", "--order", order, "--cartons", folder / "cartons.csv", "--json", "--seed", str(asked.seed)]
    began = time.monotonic()
    done = subprocess.run(command + asked.further, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    took_s = time.monotonic() - began
    if not done.stdout:
        sys.exit(f"order {number}: {done.stderr}")
    found = json.loads(done.stdout)
    chosen = found["carton"] and found["carton"]["name"]
    run = {
        "order": number,
        "items": len(items),
        "carton": chosen,
        "rule": by_rule(items),
        "fill": found["carton"] and found["carton"]["fill"],
        "sequences": found["carton"] and found["carton"]["sequences"],
        "refused": {it["name"]: [it["kind"], it["sequences"]] for it in found["refused"]},
        "took_s": took_s,
    }
    print(json.dumps(run), file=sys.stderr, flush=True)
    return run


def smaller(run):
    """How many sizes smaller the chosen carton is than the rule's; an order that the rule has none for counts as one size more."""
    place = lambda name: SIZES.index(name) if name else len(SIZES)
    return place(run["rule"]) - place(run["carton"])


def measured(runs):
    fits = [run for run in runs if run["carton"]]
    both = [smaller(run) for run in fits]
    times_s = sorted(run["took_s"] for run in runs)
    longest_s, median_s = times_s[-1], statistics.median(times_s)
    sizes = statistics.fmean(both) if both else 0.0
    return [
        of_count("orders", "orders", len(runs)),
        of_share("fit_percent", "fit", len(fits), len(runs)),
        of_share("rule_percent", "by the rule", sum(run["rule"] is not None for run in runs), len(runs)),
        ("sizes_smaller", "sizes smaller, mean", f"{sizes:.2f}", sizes),
        of_share("smaller_percent", "smaller", sum(it > 0 for it in both), len(both)),
        of_share("larger_percent", "larger", sum(it < 0 for it in both), len(both)),
        ("median_s", "median", f"{median_s:.1f} s", median_s),
        ("longest_s", "longest", f"{longest_s:.1f} s", longest_s),
    ]


def page(asked, runs, columns):
    cartons = ", ".join(f"{name} {x} x {y} x {z} cm" for name, (x, y, z) in CARTONS.items())
    counts = lambda key: [sum(run[key] == name for run in runs) for name in [*SIZES, None]]
    chosen = [row("command", *counts("carton")), row("rule", *counts("rule"))]
    return f"""# Cartons: an order's smallest

{len(runs)} orders of {ITEMS[0]} to {ITEMS[1]} built-in objects, seed {asked.seed}; cartons {cartons}. The rule takes the smallest of which \
the boxes around the items fill at most {100 * FILL:.0f} %, and in which each of these has room. Times are of the whole command.

{table([column[1] for column in columns], [row(*(column[2] for column in columns))])}
How often each is chosen:

{table(["by", *SIZES, "none"], chosen)}"""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False)
    parser.add_argument("--program", default="ppnpack", help="the program that is asked")
    parser.add_argument("--orders", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=pathlib.Path, default="out/carton", help="where the page is written")
    asked, asked.further = parser.parse_known_args()
    listed = subprocess.run([asked.program, "catalogue", "list", "--json"], stdout=subprocess.PIPE, check=True).stdout
    orders = draw(json.loads(listed), asked.orders, asked.seed)
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        with (folder / "cartons.csv").open("w", newline="") as file:
            lines = [(name, *size, "cm") for name, size in CARTONS.items()]
            csv.writer(file).writerows([("name", "x", "y", "z", "unit"), *lines])
        runs = [answer(asked, number, items, folder) for number, items in enumerate(orders)]
    columns = measured(runs)
    results = {"cartons_cm": CARTONS, "fill": FILL, **{key: value for key, _, _, value in columns}, "runs": runs}
    publish(asked.out / "carton.md", page(asked, runs, columns), results)


if __name__ == "__main__":
    main()
