"""The page of loads holds what items carried against what they may and what was estimated."""

import json
import pathlib
import subprocess
import sys

SCRIPT = pathlib.Path(__file__).resolve().parents[3] / "experiments" / "loads.py"


def reading(arrival, measured_kg, estimated_kg):
    return {
        "arrival": arrival, "measured_kg": measured_kg, "estimated_kg": estimated_kg, "above_kg": 0.5, "unbalanced_kg": -0.002,
    }


def run(number, meshes_m3, states):
    return {
        "number": number, "objects": [1, 0], "items": 2, "placed": 2, "meshes_m3": meshes_m3, "unsteady": number, "refused": 3,
        "states": states,
    }


def state(is_still, *readings):
    return {"is_still": is_still, "readings": list(readings)}


def test_what_items_carried_is_held_against_limits_and_estimates(tmp_path):
    # The item that came first is of object 1, which may carry 200 g.
    heavy = run(0, 0.002, [state(True, reading(0, 0.3, 0.3)), state(False, reading(0, 0.21, 0.2), reading(1, 0.6, 0.01))])
    light = run(1, 0.001, [state(True), state(True, reading(0, 0.04, 0.2))])
    lines = [{"name": "no limits", "margin": None, "folder": "a"}, {"name": "margin 2", "margin": 2.0, "folder": "b"}]
    for line, runs in zip(lines, ([heavy, heavy], [light, light])):
        folder = tmp_path / "runs" / line["folder"]
        folder.mkdir(parents=True)
        for name, of in zip(("00000", "00001"), runs):
            (folder / f"{name}.json").write_text(json.dumps(of))
    origin = {"command": "ppnpack experiment loads", "version": "1", "machine": "a", "made": "now", "program_blake3": "0123456789abcdef01"}
    results = {
        "first_case": 0, "cases": 2, "items": 20, "factors": [0.5, 5.0], "way": {"name": "tried"}, "limits_kg": [10.0, 0.2],
        "lines": lines, "origin": origin,
    }
    path = tmp_path / "loads.json"
    path.write_text(json.dumps(results))
    done = subprocess.run([sys.executable, SCRIPT, path], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    without, limited = json.loads(path.read_text())["lines"]
    counts = ("exceeded", "exceeded_noticeably", "containers_noticeably", "exceeded_noticeably_at_end", "unsteady", "placed")
    assert [without[count] for count in counts] == [2, 2, 2, 0, 0, 4]
    assert [limited[count] for count in counts] == [0, 0, 0, 0, 2, 4]
    assert abs(without["greatest_share"] - 1.5) < 1e-9 and without["worst"][0]["placed"] == 1
    assert limited["difference_cm3"]["mean"] == -1000 and limited["difference_percent"] == -50
    assert without["ratios"]["loads"] == 4 and without["ratios"]["missed"] == 2 and without["ratios"]["beyond_all_above"] == 2
    assert limited["ratios"]["loads"] == 0 and limited["ratios"]["median"] is None
    page = (tmp_path / "loads.md").read_text()
    for part in [
        "between 0.5 and 5 times its own mass",
        "| margin 2 | 1000 ± 0 | -1000 ± 0 | -50.0 % | 3 ± 0 | 0 | 0 | 0 | 0 | 0.20 | 50.0 % (2 of 4) |",
        "| no limits | 4 | 60.00 | 60.00 | 60.00 | 60.00 | 2 | 2 | 50.0 % (2 of 4) | 2.0 g |",
        "program 0123456789abcdef.",
    ]:
        assert part in page, page
