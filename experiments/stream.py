"""Makes the page of streams, of their runs.

    python experiments/stream.py out/stream/stream.json

The file is what `ppnpack experiment stream` wrote; what the runs came to is added to it.
"""

import collections
import math

from pages import (
    UNSTEADY, WIDENED, kept, make, mean, measured, of_change, of_count, of_decisions, of_difference, of_mean, of_share,
)


def containers(run):
    return run["closed"] + run["open"]


def average(run, value):
    """The mean over the closed containers; over the others that were begun where none was closed."""
    begun = [container for container in run["closed"] or run["open"] if container["placed"]]
    return mean(map(value, begun))["mean"]


def volumes(runs, others):
    """What closed containers hold."""
    cm3, others_cm3 = ([average(run, lambda it: 1e6 * it["meshes_m3"]) for run in of] for of in (runs, others))
    items = [average(run, lambda it: it["items"]) for run in runs]
    total = lambda key: sum(container[key] for run in runs for container in containers(run))
    return [
        of_count("closed", "closed", sum(len(run["closed"]) for run in runs)),
        of_mean("meshes_cm3", "mesh volume (cm³)", 0, cm3),
        of_difference("difference_cm3", "difference (cm³)", 0, cm3, others_cm3),
        of_change("difference_percent", cm3, others_cm3),
        of_mean("items", "items", 1, items),
        of_mean("containers_per_thousand", "containers per 1,000 items", 1, [1e3 / it if it else math.inf for it in items]),
        of_share("unsteady_percent", "unsteady", total("unsteady"), total("placed")),
        of_count("unsteady", None, total("unsteady")),
        of_count("placed", None, total("placed")),
        of_count("steps_widened", "steps widened", total("steps_widened")),
        of_count("unplaceable", "fit nowhere", sum(run["unplaceable"] for run in runs)),
        *of_decisions(runs),
    ]


def orders(runs, others):
    """How many containers orders take."""
    used, others_used = ([sum(it["placed"] > 0 for it in containers(run)) for run in of] for of in (runs, others))
    of_orders = [count for run in runs for count in run["containers_of_orders"]]
    complete, asked = (sum(run[key] for run in runs) for key in ("complete_orders", "orders"))
    return [
        of_mean("used", "containers used", 1, used),
        of_difference("used_difference", "difference", 1, used, others_used),
        of_change("used_difference_percent", used, others_used),
        of_mean("containers_an_order", "containers an order", 2, [mean(run["containers_of_orders"])["mean"] for run in runs]),
        of_share("in_one_container_percent", "orders in one container", of_orders.count(1), len(of_orders)),
        of_share("complete_percent", "complete orders", complete, asked),
    ]


def closings(runs):
    """Why containers were closed, and how much of their volume was filled."""
    closed = [container for run in runs for container in run["closed"]]
    rules = collections.Counter(it["closed_by"] for run in runs for it in containers(run) if it["closed_by"])
    counts = dict(sorted(rules.items()))
    whole_m3 = sum(container["volume_m3"] for container in closed)
    filled = 100 * sum(container["meshes_m3"] for container in closed) / whole_m3 if whole_m3 else 0.0
    return [
        ("closed_by", "by", ", ".join(f"{rule}: {count}" for rule, count in counts.items()), counts),
        ("filled_percent", "filled", f"{filled:.1f} %", filled),
    ]


def named(setting, has_orders):
    """A line's name: how many containers are open, and whether orders share them."""
    if setting["sharing"] == "one-order":
        return f"{setting['open']}, one order at a time"
    return f"{setting['open']}, shared" if has_orders else str(setting["open"])


def page(results, folder):
    has_orders = any(line["setting"]["sharing"] == "one-order" for line in results["lines"])
    for line in results["lines"]:
        line["name"] = named(line["setting"], has_orders)
    lines = [(line["name"], line, kept(folder, line, results)) for line in results["lines"]]
    first, way = lines[0][2], results["way"]
    text = f"""# Streams: several containers open

{results["streams"]} streams of {results["source"]} from stream {results["first_stream"]} on, method *{way["name"]}*, buffer of \
{way["method"]["buffer"]}. An item goes into the fullest container in which an item of the buffer has a valid placement. Where nothing in \
the buffer has a valid placement in any, the fullest is closed and an empty one opened; other rules that closed containers are named below. \
Volumes are of closed containers: the mean of each stream, then over streams; differences are to the first line, stream by stream, with 95 % \
intervals by Student's t. {UNSTEADY} {WIDENED} Decision times are of one step on one thread, {results["workers"]} streams at once.

{measured("open", lines, volumes, first)}"""
    if has_orders:
        text += f"""
Containers in which something was packed, open ones at the end among them; differences are to the first line, stream by stream. *Complete* \
orders have all of their items in containers.

{measured("open", lines, orders, first)}"""
    return text + f"""
Why containers were closed, and how much of their volume was filled:

{measured("open", lines, closings)}"""


if __name__ == "__main__":
    make(__doc__, "stream", page)
