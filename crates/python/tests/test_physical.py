"""The page of the simulated robot cell counts every item once."""

import json
import pathlib
import subprocess
import sys

SCRIPT = pathlib.Path(__file__).resolve().parents[3] / "experiments" / "physical.py"


def item(end, seen_as, is_known=True, found=None):
    return {"object": "a", "is_known": is_known, "seen_as": seen_as, "attempts": 2, "end": end, "found": found}


def placed(is_inside, tilt_rad):
    return {"placed": {"is_inside": is_inside, "slide_m": 0.0, "tilt_rad": tilt_rad, "disturbance_m": 0.002}}


def known(off):
    return {"object": {"name": "a", "position_off_m": off, "angle_off_rad": off}}


FOUND = {"kind": "moved", "position_off_m": 0.004, "angle_off_rad": 0.1, "reason": ""}
ITEMS = [
    item(placed(True, 0.0), known(0.001), found=FOUND),
    item(placed(False, 1.0), known(None)),
    item({"lost": {"failure": "dropped"}}, "unknown", is_known=False),
    item({"refused": {"reason": "no room"}}, "nothing"),
    item("waiting", "nothing"),
]


def decision(time_ms):
    return {
        "propose_s": 0.0, "evaluate_s": time_ms / 1e3, "check_s": 0.0, "cycle_s": 0.0, "degraded": [], "is_widened": time_ms == 3,
    }


RECORD = {
    "items": ITEMS,
    "decisions": [decision(time_ms) for time_ms in (3, 1, 2)],
    "stages_s": {"plan": [at / 1e3 for at in range(100, -1, -1)]},
    "volume_m3": 0.002, "compactness": 0.25, "deepest_overlap_m": 0.0, "doubt": None,
}
SETTINGS = {
    "grid": {"cell_m": 0.005, "yaws": 8}, "buffer": 2, "unseen_count": 8, "known_count": 1, "strangers": True, "arm": None, "seed": 0,
    "simulated": {"release": {"jitter_m": 0.002}}, "faults": {"missed_picks": 0.02, "drops": 0.01},
}


def test_every_item_is_counted_once(tmp_path):
    results = {"settings": SETTINGS, "unseen_held": 12, "others_held": 33, "lines": [{"method": "tried", "records": [RECORD]}]}
    results["origin"] = {"command": "ppnpack experiment physical", "version": "1", "machine": "a", "made": "now"}
    path = tmp_path / "physical.json"
    path.write_text(json.dumps(results))
    # What is there already is measured anew.
    for _ in range(2):
        done = subprocess.run([sys.executable, SCRIPT, path], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
    line = json.loads(path.read_text())["lines"][0]
    counts = {"all": 5, "placed": 2, "outside": 1, "toppled": 1, "toppled_percent": 50.0, "refused": 2, "lost": 1, "repeated": 5}
    assert line["items"] == counts
    assert line["seen"] == {"right_percent": 25.0, "good_poses_percent": 100.0, "strangers_as_unknown_percent": 100.0}
    found = {"as_planned": 0, "moved": 1, "toppled": 0, "missing": 0, "unclear": 0, "good_poses_percent": 0.0}
    assert line["found"] == found
    assert line["greatest_disturbance_mm"] == 2.0 and line["widened_decisions"] == 1
    assert line["refusals"] == {"no room": 1}
    assert line["records"] == [RECORD]
    page = (tmp_path / "physical.md").read_text()
    for part in [
        "5.0 mm cells, 8 yaws, buffer 2; 8 unseen objects and 1 other a run, the unseen ones not known to the recogniser; arm none",
        "|  | tried |\n",
        "| known items recognised | 25.0 % (1 of 4) |",
        "| decision: median, 95 % (ms) | 2.0, 3.0 |",
        "| request to decision | 50.0, 95.0 |",
        "| placed to inspected | – |",
        "| no room | 1 |",
        "Made by `ppnpack experiment physical` on now (a), version 1.",
    ]:
        assert part in page, page
