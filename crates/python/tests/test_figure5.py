"""The methods are drawn side by side on the same objects."""

import json
import os
import pathlib
import stat
import subprocess
import sys

import numpy
import pytest

SCRIPT = pathlib.Path(__file__).resolve().parents[3] / "experiments" / "figure5.py"

# A picture of one pixel.
PIXEL = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="

# Stands for `ppnpack`: packs nothing, has no network, and says what it was asked.
PROGRAM = f"""#!{sys.executable}
import base64, json, pathlib, sys
asked = sys.argv[1:]
of = lambda option: asked[asked.index(option) + 1]
assert asked[0] == "pack" and of("--conditions") == "reference" and of("--catalogue") == "folder"
out = pathlib.Path(of("--out"))
for name in ("packed.png", "heightmap.png"):
    (out / name).write_bytes(base64.b64decode("{PIXEL}"))
is_network = "--proposals" in asked
method = None if is_network else json.loads(pathlib.Path(of("--method")).read_text())
print(json.dumps({{
    "version": "1", "settings": {{"items": of("--items"), "seed": of("--seed")}}, "height_m": 0.2, "floor_compactness": 0.5,
    "packed": {{"items": len(of("--items").split(",")), "meshes_m3": 0.01}},
    "degraded": [{{"reason": "there is no network", "steps": 1}}] if is_network else [],
}}))
"""


def stand_in(folder):
    program = folder / "ppnpack"
    program.write_text(PROGRAM)
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    return program


def figure(folder, program, *options):
    sequences = folder / "sequences.npy"
    numpy.save(sequences, numpy.arange(12).reshape(2, 6))
    command = [sys.executable, SCRIPT, "--program", program, "--sequences", sequences, "--sequence", "1", "--out", folder / "out"]
    return subprocess.run([*command, *options], capture_output=True, text=True)


def test_the_methods_are_drawn_side_by_side_on_the_same_objects(tmp_path):
    options = ["--length", "4", "--catalogue", "folder"]
    done = figure(tmp_path, stand_in(tmp_path), *options)
    assert done.returncode == 0, done.stderr
    results = json.loads((tmp_path / "out" / "figure5.json").read_text())
    assert results["settings"] == {"items": "6,7,8,9", "seed": "1"}
    methods = [line["method"] for line in results["lines"]]
    assert len(methods) == 7 and methods[-1] == "SDFM", methods
    assert results["lines"][0]["floor_compactness_percent"] == 50
    page = tmp_path / "out" / "figure5.md"
    assert "| SDFM | 4 | 50.0 | 10000 | 20.0 |" in page.read_text()
    assert (tmp_path / "out" / "figure5.png").read_bytes().startswith(b"\x89PNG")
    page.write_text(page.read_text() + "by hand\n")
    figure(tmp_path, stand_in(tmp_path), *options)
    assert page.read_text().endswith("by hand\n")


@pytest.mark.skipif(not os.path.exists(os.environ.get("PPNPACK_PROGRAM", "")), reason="`cargo build` has not made ppnpack")
def test_every_method_packs(tmp_path):
    done = figure(tmp_path, os.environ["PPNPACK_PROGRAM"], "--length", "4")
    assert done.returncode == 0, done.stderr
    lines = json.loads((tmp_path / "out" / "figure5.json").read_text())["lines"]
    assert len(lines) >= 7
    for line in lines:
        assert 1 <= line["items"] <= 4 and line["floor_compactness_percent"] > 0, line


def test_a_sequence_that_is_too_short_is_refused(tmp_path):
    done = figure(tmp_path, stand_in(tmp_path), "--length", "7")
    assert done.returncode == 2 and "have 6 objects" in done.stderr
