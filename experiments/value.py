"""Learns from packings what a scene is worth that a placement leaves: by a ridge regression of how much was packed after it.

    python experiments/value.py out/value/value.json

The file is what `ppnpack experiment value` wrote. `methods.json` has the coefficients that were learned, as methods to compare by
`ppnpack experiment filling --methods`. It needs NumPy.
"""

import json
import math
import pathlib

import numpy

from pages import kept, options, publish

# In standard deviations of the figures; from 30 to 1,000 what is explained differs by less than a thousandth.
PENALTY = 100.0

# Sequences are held back one in so many at a time.
PARTS = 5


def fit(regressors, further, penalty):
    """The coefficients and the constant of the ridge regression, each regressor by its standard deviation.

    Source: Hoerl and Kennard, *Ridge Regression: Biased Estimation for Nonorthogonal Problems*, 1970.
    """
    means = regressors.mean(axis=0)
    # What is always the same explains nothing.
    deviations = numpy.maximum(regressors.std(axis=0), 1e-9)
    scaled = (regressors - means) / deviations
    normal = scaled.T @ scaled + penalty * numpy.eye(scaled.shape[1])
    coefficients = numpy.linalg.solve(normal, scaled.T @ (further - further.mean())) / deviations
    return coefficients, further.mean() - coefficients @ means


def explained(sequences, first, penalty):
    """The share of the variance that the regressors from the one numbered `first` on explain of sequences that were held back."""
    squares = 0.0
    for part in range(PARTS):
        of = lambda is_wanted: [it for at, it in enumerate(sequences) if (at % PARTS == part) == is_wanted]
        regressors, further = joined(of(False))
        coefficients, constant = fit(regressors[:, first:], further, penalty)
        regressors, further = joined(of(True))
        squares += ((further - constant - regressors[:, first:] @ coefficients) ** 2).sum()
    _, further = joined(sequences)
    return 1 - squares / ((further - further.mean()) ** 2).sum()


def joined(sequences):
    return tuple(numpy.concatenate(parts) for parts in zip(*sequences))


def samples(seen, container_m3):
    """The steps of a sequence: the figures and what was packed until then, and what was packed after it, as shares of the container."""
    packed = numpy.array(seen["packed_m3"]) / container_m3
    return numpy.column_stack([seen["figures"], packed]), seen["meshes_m3"] / container_m3 - packed


def main():
    parser = options(__doc__, "value")
    parser.add_argument("--out", type=pathlib.Path, default="out/learned", help="where what was learned is written")
    asked = parser.parse_args()
    results = json.loads(asked.results.read_text())
    way, grid = results["way"], results["way"]["grid"]
    container_m3 = math.prod(grid["container"].values())
    runs = kept(asked.runs or asked.results.with_name("runs"), results, results)
    sequences = [samples(seen, container_m3) for seen in runs if seen["packed_m3"]]
    if len(sequences) < PARTS:
        parser.error(f"{asked.results} has {len(sequences)} packed sequences: {PARTS} are needed to learn from")
    regressors, further = joined(sequences)
    # What was packed until then is the same for all placements of a step.
    coefficients = fit(regressors, further, PENALTY)[0][:-1].tolist()
    of_all = explained(sequences, 0, PENALTY)
    # What a placement has no influence on.
    without_surface = explained(sequences, len(coefficients) - results["figures_of_items"], PENALTY)
    named = lambda name, value: {**way, "name": name, "method": {**way["method"], "scene_value": value}}
    methods = [named("objective alone", way["method"]["scene_value"]), named("with the learned value", {"coefficients": coefficients})]
    last = results["first_case"] + results["cases"] - 1
    text = f"""# Value: what a placement leaves

Learned from sequences {results["first_case"]} to {last} in robot conditions: cells of {1e3 * grid["cell_m"]:g} mm, {grid["yaws"]} yaws, \
{way["set_aside"]} set aside, poses {way["poses"]}, by the objective alone.

| | |
|---|---|
| steps | {len(further)} |
| variance explained, of sequences held back | {100 * of_all:.1f} % |
| of that without the figures of the surface | {100 * without_surface:.1f} % |

`methods.json` has the coefficients: `ppnpack experiment filling --methods methods.json` says what they are worth.
"""
    told = {key: results[key] for key in ("first_case", "cases", "way")}
    told |= {"samples": len(further), "explained": of_all, "explained_without_surface": without_surface, "coefficients": coefficients}
    publish(asked.out / "value.md", text, told, results["origin"]["version"])
    (asked.out / "methods.json").write_text(json.dumps(methods, indent=2))


if __name__ == "__main__":
    main()
