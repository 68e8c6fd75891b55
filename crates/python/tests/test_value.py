"""What scenes are worth is learned from packings."""

import json
import pathlib
import runpy
import subprocess
import sys

import numpy
import pytest

EXPERIMENTS = pathlib.Path(__file__).resolve().parents[3] / "experiments"


@pytest.fixture
def value(monkeypatch):
    monkeypatch.syspath_prepend(str(EXPERIMENTS))
    return runpy.run_path(str(EXPERIMENTS / "value.py"))


def sequences(noise):
    """Sequences in which what is packed later is `2 a - 3 b + 5 c` and noise."""
    random = numpy.random.default_rng(7)

    def sequence():
        a, b, c, error = random.uniform(size=(4, 30))
        regressors = numpy.column_stack([a, b, numpy.full(30, 0.25), c])
        return regressors, 2 * a - 3 * b + 5 * c + noise * (error - 0.5)

    return [sequence() for _ in range(20)]


def test_a_linear_law_is_found(value):
    coefficients, constant = value["fit"](*value["joined"](sequences(0.0)), 1e-9)
    numpy.testing.assert_allclose([*coefficients, constant], [2, -3, 0, 5, 0], atol=1e-6)
    assert value["explained"](sequences(0.0), 0, 1e-9) == pytest.approx(1)


def test_noise_and_what_is_left_out_are_not_explained_and_a_penalty_makes_coefficients_less(value):
    noisy = sequences(1.0)
    of_all, without_the_first = (value["explained"](noisy, first, 1.0) for first in (0, 1))
    assert 0.9 < of_all < 1 and without_the_first < of_all - 0.05
    norm = lambda penalty: numpy.square(value["fit"](*value["joined"](noisy), penalty)[0]).sum()
    assert norm(1e4) < 0.5 * norm(1.0)


def test_what_was_learned_is_written_as_methods(tmp_path):
    grid = {"container": {"x_m": 0.1, "y_m": 0.1, "z_m": 0.1}, "cell_m": 0.005, "yaws": 8}
    way = {"name": "", "grid": grid, "set_aside": 20, "poses": 1, "method": {"scene_value": {"weight": 0.0}}}
    seen = [{"figures": [[at, 1.0], [2.0, at]], "packed_m3": [1e-4, 3e-4], "meshes_m3": 5e-4} for at in range(6)]
    results = {"first_case": 100, "cases": 6, "way": way, "figures_of_items": 1, "origin": {"version": "1"}}
    results |= {"folder": "kept"}
    path = tmp_path / "value.json"
    path.write_text(json.dumps(results))
    (tmp_path / "runs" / "kept").mkdir(parents=True)
    for number, run in enumerate(seen, 100):
        (tmp_path / "runs" / "kept" / f"{number:05}.json").write_text(json.dumps(run))
    command = [sys.executable, EXPERIMENTS / "value.py", path, "--out", tmp_path / "out"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    found = json.loads((tmp_path / "out" / "value.json").read_text())
    assert found["samples"] == 12 and len(found["coefficients"]) == 2
    methods = json.loads((tmp_path / "out" / "methods.json").read_text())
    assert methods[0]["method"]["scene_value"] == {"weight": 0.0}
    assert methods[1]["method"]["scene_value"] == {"coefficients": found["coefficients"]}
    page = (tmp_path / "out" / "value.md").read_text()
    assert "sequences 100 to 105" in page and "| steps | 12 |" in page
