"""Pages hold what the runs of experiments came to."""

import importlib
import json
import math
import pathlib

import pytest

EXPERIMENTS = pathlib.Path(__file__).resolve().parents[3] / "experiments"
ORIGIN = {"command": "ppnpack experiment", "version": "1", "machine": "a", "made": "now"}
GRID = {"container": {"x_m": 0.32, "y_m": 0.32, "z_m": 0.3}, "cell_m": 0.01, "yaws": 4}


@pytest.fixture
def module(monkeypatch):
    monkeypatch.syspath_prepend(str(EXPERIMENTS))
    return importlib.import_module


def keep(folder, lines, first_case=0):
    """Keeps the runs of lines where their experiment would have."""
    for name, runs in lines.items():
        (folder / name).mkdir(parents=True)
        for number, run in enumerate(runs, first_case):
            (folder / name / f"{number:05}.json").write_text(json.dumps(run))


def packed(items, meshes_m3, floor_compactness=0.5, **more):
    run = {
        "items": items, "placed": items + 1, "unsteady": 1, "set_aside": 2, "in_other_pose": 0, "steps_widened": 1, "voxels_m3": 2 * meshes_m3,
        "meshes_m3": meshes_m3, "floor_compactness": floor_compactness, "box_compactness": 0.5, "mesh_floor_compactness": 0.25,
        "height_m": 0.2, "above_rim_m": 0.0, "decision_s": [0.001, 0.003], "propose_s": 0.0, "evaluate_s": 0.001, "check_s": 0.001,
    }
    return run | more


def test_the_interval_is_that_of_students_t_and_what_rounds_to_nothing_has_no_sign(module):
    pages = module("pages")
    of = pages.mean([1, 2, 3, 4])
    assert of["mean"] == 2.5 and of["half_width"] == pytest.approx(3.182446 * math.sqrt(5 / 3 / 4), abs=1e-6)
    assert pages.mean([]) == {"mean": 0, "half_width": 0} and pages.mean([2.0])["half_width"] == 0
    shown = lambda middle: pages.shown({"mean": middle, "half_width": 0.12}, 1)
    assert [shown(-0.037), shown(-0.051), shown(0.26)] == ["0.0 ± 0.1", "-0.1 ± 0.1", "0.3 ± 0.1"]
    assert [pages.quantile([3.0, 1.0, 2.0], part) for part in (0.5, 1.0)] == [2.0, 3.0] and math.isnan(pages.quantile([], 0.5))


def test_notes_survive_a_new_page_and_what_cannot_be_read_is_left_as_it_is(module, tmp_path):
    publish, path = module("pages").publish, tmp_path / "a.md"
    publish(path, "one", {"origin": ORIGIN})
    path.write_text(f"{path.read_text()}by hand\n")
    publish(path, "two", {"origin": ORIGIN})
    assert path.read_text().startswith("two\n") and path.read_text().endswith("by hand\n")
    path.write_bytes(b"by hand \xff")
    with pytest.raises(UnicodeDecodeError):
        publish(path, "three", {"origin": ORIGIN, "figure": 3})
    assert path.read_bytes() == b"by hand \xff" and "figure" not in path.with_suffix(".json").read_text()


def test_numbers_that_are_not_finite_are_not_kept(module):
    line = {}
    module("pages").keep(line, [("a", "", "", math.inf), ("b/c", "", "", {"mean": math.nan, "half_width": 1.0})])
    assert line == {"a": None, "b": {"c": {"mean": None, "half_width": 1.0}}}


def test_fillings_are_compared_with_the_first_method_in_each_cell(module, tmp_path):
    keep(tmp_path, {"a": [packed(2, 0.001, above_rim_m=0.002), packed(4, 0.001)], "b": [packed(3, 0.002), packed(3, 0.002)]}, 7)
    lines = [{"name": "one", "folder": "a"}, {"name": "other", "folder": "b"}]
    apart = {"friction": 1.4, "pose_error": {"position_m": 0.002, "rotation_rad": math.radians(1)}}
    tables = [{"apart": apart, "lines": lines}]
    results = {"workers": 2, "first_case": 7, "cases": 2, "ways": [], "tables": tables}
    page = module("filling").page(results, tmp_path)
    assert lines[1]["difference_cm3"] == {"mean": 1000.0, "half_width": 0.0} and lines[1]["difference_percent"] == 100
    assert (lines[0]["placed"], lines[0]["unsteady"], lines[0]["decision_95_s"]) == (8, 2, 0.003)
    for part in [
        "Sequences 7 to 8 in", "times 0.71 to 1.40", "errors of 2 mm and 1 degree",
        "| one | 3.0 ± 12.7 | 1000 ± 0 | 0 ± 0 | +0.0 % | 25.0 % (2 of 8) | 1 | 2.0 ± 0.0 | 0.0 % (0 of 8) | 2 | 3.0 ms | 3.0 ms |",
    ]:
        assert part in page, page


def test_a_ratio_of_proportional_runs_is_certain(module):
    ratio = module("tables").ratio
    even, uneven = ratio([0.5, 1, 2], [1, 2, 4]), ratio([0.9, 1, 1.6], [1, 2, 4])
    assert even["mean"] == pytest.approx(50) and even["half_width"] < 1e-9
    assert uneven["mean"] == pytest.approx(50) and uneven["half_width"] > 1
    assert ratio([], []) == {"mean": 0, "half_width": 0}


def table(**more):
    told = {
        "grid": GRID, "simulated": {"scan": "camera"}, "objects": 28, "buffer": 5, "seed": 3, "workers": 2, "first_case": 0, "cases": 2,
        "without_network": None,
    }
    return told | more


def test_methods_of_tables_stand_beside_the_papers_and_are_compared_with_the_search(module, tmp_path):
    keep(tmp_path, {"a": [packed(2, 0.001, 0.25)] * 2, "b": [packed(4, 0.002)] * 2})
    lines = lambda: [{"key": "random", "method": "Random", "folder": "a"}, {"key": "sdfm", "method": "SDFM", "folder": "b"}]
    pages = module("tables").PAGES
    bounded = [{"grid": "1 cm, 4 yaws", "folder": "b"}]
    results = table(experiment="table1", lines=lines(), bounded=bounded)
    page = pages["table1"](results, tmp_path)
    assert bounded[0]["difference"]["items"]["mean"] == 0 and bounded[0]["floor_compactness_ratio_percent"]["mean"] == 100
    for part in [
        "Container 32 x 32 x 30 cm, cells of 10 mm, 4 yaws, buffer 5, published stability test, camera scan",
        "| Random | 2.000 ± 0.000 ms | 2.0 ± 0.0 | 2000 ± 0 | 25.0 ± 0.0 | 50.0 ± 0.0 | 1000 ± 0 | 25.0 ± 0.0 | 50.0 ± 0.0 | 50.0 ± 0.0 |",
        "| *Random, the paper* | 0.05 s | 27.5 | 10905 | 39.9 |", "| Random | -2.0 ± 0.0 | -2000 ± 0 | -1000 ± 0 | -25.0 ± 0.0 |",
    ]:
        assert part in page, page
    page = pages["table4"](table(experiment="table4", lines=lines(), without_network="no library"), tmp_path)
    for part in ["2 random sequences of 28 objects, seed 3", "missing: no library.", "| *Search all, the paper* | 1.58 s | 34.3 | 25001 | 49.8 |"]:
        assert part in page, page
    classes = [{"name": "regular", "objects": ["a", "b"]}]
    of_class = [line | {"class": "regular"} for line in lines()]
    page = pages["table2"](table(experiment="table2", lines=of_class, classes=classes, regular_share=0.5), tmp_path)
    assert "## 2 regular objects" in page and "| *PPN-Pack* | 0.87 s | 44.2 |  | 47.9 |" in page
    assert of_class[1]["method"] == "Search all" and of_class[1]["cases"] == 2
    grids = [{"name": "fine", "key": "fine", "lines": [{"method": "all", "folder": "b"}, {"method": "bounded", "folder": "a"}]}]
    page = pages["pareto"](table(experiment="pareto", grids=grids), tmp_path)
    assert "| proposals | decision per item | proposing |" in page and grids[0]["lines"][1]["decision_ratio_percent"]["mean"] == 100


def container(placed, meshes_m3, closed_by=None):
    return {
        "items": placed, "placed": placed, "meshes_m3": meshes_m3, "volume_m3": 0.01, "unsteady": 1, "steps_widened": 0, "closed_by": closed_by,
    }


def test_streams_are_measured_by_closed_containers_and_orders_by_all(module, tmp_path):
    more = {"unplaceable": 1, "decision_s": [0.1], "containers_of_orders": [1, 2], "complete_orders": 1, "orders": 2}
    apart = {"closed": [container(2, 0.001, "order complete"), container(4, 0.003, "nothing fits")], "open": [container(1, 0.1)], **more}
    shared = {"closed": [], "open": [container(5, 0.004), container(0, 0.0)], **more}
    keep(tmp_path, {"a": [apart], "b": [shared]})
    setting = lambda sharing: {"open": 1, "sharing": sharing}
    lines = [{"setting": setting("one-order"), "folder": "a"}, {"setting": setting("shared"), "folder": "b"}]
    way = {"name": "tried", "method": {"buffer": 5}}
    results = {"workers": 1, "first_stream": 0, "streams": 1, "source": "2 orders", "way": way, "runs": ["00000"], "lines": lines}
    page = module("stream").page(results, tmp_path)
    assert lines[0]["closed_by"] == {"nothing fits": 1, "order complete": 1} and lines[0]["filled_percent"] == pytest.approx(20)
    assert lines[0]["meshes_cm3"]["mean"] == pytest.approx(2000) and lines[1]["difference_percent"] == pytest.approx(100)
    assert lines[0]["used"]["mean"] == 3 and lines[1]["used"]["mean"] == 1 and lines[1]["containers_an_order"]["mean"] == 1.5
    for part in [
        "| 1, one order at a time | 2 | 2000 ± 0 | 0 ± 0 | +0.0 % | 3.0 ± 0.0 | 333.3 ± 0.0 | 42.9 % (3 of 7) | 0 | 1 | 100.0 ms | 100.0 ms |",
        "| 1, shared | 1.0 ± 0.0 | -2.0 ± 0.0 | -66.7 % | 1.50 ± 0.00 | 50.0 % (1 of 2) | 50.0 % (1 of 2) |",
    ]:
        assert part in page, page


def test_boxes_fill_their_bin_by_setting(module, tmp_path):
    box = lambda side: {"sides": {"x": side, "y": side, "z": side}, "x": 0, "y": 0, "z": 0}
    runs = [{"placed": [box(5), box(5)], "decision_s": [1e-6, 3e-6]}, {"placed": [box(5)] * 4, "decision_s": [2e-6] * 4}]
    # A file holds several instances.
    keep(tmp_path, {"a": [runs]})
    lines = [{"setting": "2", "method": "dbl", "folder": "a"}]
    results = {"first": 0, "instances": 2, "seed": 0, "rollouts": 6, "workers": 1, "runs": ["00000"], "lines": lines}
    page = module("boxes").page(results, tmp_path)
    assert lines[0]["utilisation_percent"]["mean"] == 37.5 and lines[0]["utilisation_variance"]["mean"] == 156.25
    assert "## Setting 2: six" in page and "## Setting 1" not in page
    assert "| DBL | 37.5 ± 158.8 | 3.0 ± 12.7 | 0.002 ms | 0.0 ms |" in page, page
