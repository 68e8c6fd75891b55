"""Trains the network and its ablations alike, and compares how often the optimum is among their best-scored placements.

    python experiments/table3.py --dataset out/dataset --seeds 3 --cut-off 10,40 --epochs 8 --device cuda

Options that it does not know are those of `ppnpack train`, for every network. Of each network, every cut-off is trained with the
first seed; the validation split chooses the one that is trained with the other seeds, too. Only what is chosen is measured on the
test split. A training that was killed goes on, and one that is finished is not repeated.
"""

import argparse
import json
import pathlib
import subprocess
import sys

from pages import mean, publish, row, student, table

SHARES = [1, 5, 8, 10, 20]

# Its name and that of its folder, its options, and Table III of the paper, in percent at the shares. Each but the first lacks one
# thing more.
NETWORKS = [
    ("full", "full", [], None),
    ("heightmaps alone (the paper's inputs)", "heightmaps", ["--no-resting-heights"], [81.0, 94.9, 97.2, 98.0, 99.4]),
    (
        "heightmaps alone, without ranking",
        "no-ranking",
        ["--no-resting-heights", "--loss", "mse"],
        [62.1, 72.9, 77.0, 79.2, 86.1],
    ),
    (
        "heightmaps alone, without ranking and correlation",
        "no-ranking-no-correlation",
        ["--no-resting-heights", "--loss", "mse", "--fusion", "concat"],
        [57.9, 66.9, 70.2, 72.5, 80.8],
    ),
]

# What each accuracy counts: a heading, and what the optimum is looked for among.
QUESTIONS = {
    "over_all": ("Over all placements: the paper's question", "among the best-scored K % of all placements"),
    "proposed": (
        "What the planner proposes: it leaves out what does not fit, and K stays a share of all",
        "among the best-scored that fit, as many as K % of all placements",
    ),
    "among_fitting": ("Among those that fit", "among the best-scored K % of those that fit"),
}

def answers(networks, question):
    """The accuracies of networks at the shares, in percent: with one network, the interval is over the sequences."""
    found = {}
    for at, share in enumerate(SHARES):
        each = [network[question][at] for network in networks]
        if len(each) == 1:
            width = student(networks[0]["sequences"]) * each[0].get("standard_error", 0.0)
            one = {"mean": each[0]["share"], "half_width": width}
        else:
            one = mean([answer["share"] for answer in each])
        found[str(share)] = {key: 100 * value for key, value in one.items()}
    return found


def shown(found, paper=None):
    """The cells of a network's accuracies; beside its own question, the paper's in brackets."""
    brackets = [f" [{percent}]" for percent in paper] if paper else [""] * len(SHARES)
    return [f"{it['mean']:.1f} ± {it['half_width']:.1f}{bracket}" for it, bracket in zip(found.values(), brackets)]


def train(asked, key, options, cut_off, seed, is_tested):
    """The card of a network, trained in a folder of its own."""
    recipe = f"cut-off-{cut_off}" if cut_off else "plain"
    folder = asked.out / "networks" / key / recipe / f"seed-{seed}"
    command = [asked.program, "train", "--dataset", asked.dataset, "--out", folder, "--resume", "--json", "--seed", str(seed)]
    command += ["--loss-over", asked.loss_over, "--validation", str(asked.validation), *options, *asked.further]
    command += ["--cut-off", cut_off] if cut_off else []
    command += [] if is_tested else ["--no-test"]
    print(f"{key}, {recipe}, seed {seed}:", file=sys.stderr)
    done = subprocess.run(command, stdout=subprocess.PIPE)
    if done.returncode:
        sys.exit(done.returncode)
    return json.loads(done.stdout)


def compare(asked):
    """A line for each network: what was tried, and what was chosen with its accuracies."""
    question = "over_all" if asked.loss_over == "all" else "proposed"
    lines = []
    for name, key, options, paper in NETWORKS:
        cut_offs = asked.cut_off.split(",") if "mse" in options else [None]
        tried = []
        if len(cut_offs) > 1:
            for cut_off in cut_offs:
                card = train(asked, key, options, cut_off, asked.seed, False)
                tried.append({"cut_off": float(cut_off), "validation": card["validation"]})
        # The first of equals; networks differ most at the smallest share.
        share = lambda at: tried[at]["validation"][question][0]["share"]
        cut_off = cut_offs[max(range(len(tried)), key=share) if tried else 0]
        cards = [train(asked, key, options, cut_off, seed, True) for seed in range(asked.seed, asked.seed + asked.seeds)]
        tests = [card["test"] for card in cards]
        lines.append({
            "network": name,
            "paper": paper,
            "tried": tried,
            "cut_off": cut_off and float(cut_off),
            **{question: answers(tests, question) for question in QUESTIONS},
            "parameters": cards[0]["parameters"],
            "training_s": mean([card["training_s"] for card in cards]),
            "cards": cards,
        })
    return lines


def page(asked, lines):
    card = lines[0]["cards"][0]
    split = lambda of: f"{of['candidates']} candidates of {of['sequences']} sequences" if of else "none"
    over = "all placements, as in the paper" if asked.loss_over == "all" else "the placements that fit"
    training = card["training"]
    text = f"""# Table 3: how often the optimum is among the best-scored K %

Each network is trained alike: {training['epochs']} epochs of {card['data']['training_candidates']} candidates, batches of \
{training['batch']} steps, the loss over {over}. Validation ({split(card['validation'])}) chose the epoch, and the cut-off where several \
were tried, by the accuracy at the smallest K. The test split ({split(card['test'])}) was looked at once, at the end. Accuracies in %, \
{asked.seeds} networks each, from seed {asked.seed} on; intervals are 95 % by Student's t over the networks, or over the test sequences \
where there is one network. In brackets the paper's Table III, whose network is wider and was trained on its own data.

"""
    heads = [f"K = {share} %" for share in SHARES]
    for question, (title, ranked) in QUESTIONS.items():
        rows = []
        for line in lines:
            cells = shown(line[question], line["paper"] if question == "over_all" else None)
            rows.append(row(line["network"], *cells, line["parameters"], f"{line['training_s']['mean']:.0f} s"))
        text += f"## {title}\n\nThe optimum is {ranked}.\n\n{table(['network', *heads, 'parameters', 'training'], rows)}\n"
    question = "over_all" if asked.loss_over == "all" else "proposed"
    rows = []
    for line in lines:
        for tried in line["tried"]:
            mark = ", chosen" if tried["cut_off"] == line["cut_off"] else ""
            name = f"{line['network']}, cut off at {tried['cut_off']:g}{mark}"
            rows.append(row(name, *shown(answers([tried["validation"]], question))))
    if rows:
        text += f"## What validation chose\n\nAccuracy on the validation split, {QUESTIONS[question][1]}, with the first seed. What was \
not chosen was not tested.\n\n{table(['network', *heads], rows)}\n"
    return text


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False)
    parser.add_argument("--program", default="ppnpack", help="the program that trains")
    parser.add_argument("--dataset", type=pathlib.Path, default="out/dataset", help="what `ppnpack dataset --values` made")
    parser.add_argument("--seeds", type=int, default=1, help="networks of each row, from --seed on")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--validation", type=int, default=1, help="tenths of the sequences that are held out for validation")
    parser.add_argument("--loss-over", choices=["all", "fitting"], default="all", help="which placements the loss is over")
    parser.add_argument("--cut-off", default="10,40", help="how far above the optimum regression tells values apart; of several, validation chooses")
    parser.add_argument("--out", type=pathlib.Path, default="out/table3", help="where the page and the networks are written")
    asked, asked.further = parser.parse_known_args()
    if "," in asked.cut_off and not asked.validation:
        parser.error("several cut-offs are given and no validation split to choose among them: give one, or --validation 1")
    settings = asked.dataset / "settings.json"
    if settings.exists() and not json.loads(settings.read_text())["has_values"]:
        parser.error(f"{asked.dataset} has no values, which the rows without ranking need: make it with `ppnpack dataset --values`")
    lines = compare(asked)
    results = {"shares_percent": SHARES, "loss_over": asked.loss_over, "lines": lines}
    publish(asked.out / "table3.md", page(asked, lines), results, lines[0]["cards"][0]["versions"]["ppnpack"])


if __name__ == "__main__":
    main()
