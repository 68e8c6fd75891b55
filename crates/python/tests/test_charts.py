"""The charts of experiments are drawn of the results that are there."""

import pathlib
import subprocess
import sys
import xml.etree.ElementTree

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]


def test_charts_hold_the_methods_of_their_results(tmp_path):
    results = {"table1": "SDFM", "pareto": "bounded", "filling": "tried", "views": "one camera"}
    for name in results:
        (tmp_path / f"{name}.json").write_bytes((REPOSITORY / "docs" / "results" / f"{name}.json").read_bytes())
    command = [sys.executable, str(REPOSITORY / "experiments" / "charts.py")]
    done = subprocess.run([*command, *tmp_path.glob("*.json")], capture_output=True, text=True, check=True)
    assert len(done.stdout.split()) == 9
    for name, method in results.items():
        chart = xml.etree.ElementTree.parse(tmp_path / f"{name}.svg")
        assert any(method in (text.text or "") for text in chart.iter("{http://www.w3.org/2000/svg}text"))
