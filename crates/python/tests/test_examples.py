"""The examples run, and show what they are to show."""

import json
import pathlib
import re
import subprocess
import sys

EXAMPLES = pathlib.Path(__file__).resolve().parents[3] / "examples" / "python"


def output(name):
    script = EXAMPLES / name
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return done.stdout


def share(text, name):
    return float(re.search(rf"{name}: ([\d.]+) %", text)[1])


def test_a_placement_is_planned():
    assert [line.split(":")[0] for line in output("plan_a_placement.py").splitlines()] == ["mug", "bowl"]


def test_a_heuristic_of_ones_own_packs_more_than_random_placements():
    printed = output("own_heuristic.py")
    assert share(printed, "snug") > share(printed, "random") + 5


def test_a_trained_policy_packs_more_than_random_placements_on_other_seeds():
    printed = output("train_policy.py")
    better, error = map(float, re.search(r"better by (-?[\d.]+) \+- ([\d.]+)", printed).groups())
    assert better > 3 * error and better > 2


def test_the_documents_code_runs(tmp_path, monkeypatch):
    text = (EXAMPLES.parents[1] / "docs" / "python.md").read_text()
    # What talks to services is run where there are some.
    blocks = [block for block in re.findall(r"```python\n(.*?)```", text, re.DOTALL) if "ppnpack.client" not in block]
    assert len(blocks) >= 4
    monkeypatch.chdir(tmp_path)
    (tmp_path / "methods.json").write_text(json.dumps([{"method": {"heuristic": "dbl"}}]))
    names = {}
    for block in blocks:
        exec(compile(block, "python.md", "exec"), names)
    names["planner"].plan(names["grid"].empty(), [names["catalogue"]["mug"]])
