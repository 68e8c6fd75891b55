"""Grids, items, catalogues and plans."""

import copy
import pickle

import numpy as np
import pytest

import ppnpack

UNTRIED = {"tries_per_item": 0}
# The objective alone, with the weights of the paper.
PUBLISHED = {"weights": {}, "scene_value": {"weight": 0.0}}


def test_the_default_grid_is_the_papers(grid):
    assert grid.shape == (4, 32, 32) and grid.rim == 150
    assert np.allclose(np.degrees(grid.yaws_rad), [0, 45, 90, 135])
    assert grid == ppnpack.Grid((0.32, 0.32, 0.30), 0.01, 0.002, [0, np.pi / 4, np.pi / 2, 3 * np.pi / 4])
    assert pickle.loads(pickle.dumps(grid)) == grid and copy.deepcopy(grid) == grid


def test_heights_round_up_to_units(grid):
    heights_m = np.array([[0.0, 0.004], [0.0041, 0.3]])
    units = grid.units(heights_m)
    assert units.dtype == np.int16 and units.tolist() == [[0, 2], [3, 150]]
    assert np.allclose(grid.metres(units), [[0.0, 0.004], [0.006, 0.3]])


def test_a_plan_packs_the_larger_item_and_place_lays_it_down(grid, catalogue):
    buffer = [catalogue["mug"], catalogue["bowl"]]
    plan = ppnpack.plan(grid, grid.empty(), buffer, alternatives=3, **PUBLISHED)
    choice = plan.choice
    larger = max(range(2), key=lambda slot: buffer[slot].voxel_count())
    assert choice.slot == larger and choice.resting_height == 0
    assert len(plan.alternatives) == 3 and all(next.value >= choice.value for next in plan.alternatives)
    item = buffer[choice.slot]
    heightmap = ppnpack.place(grid.empty(), item, choice)
    top = item.top(choice.yaw)
    there = heightmap[choice.x : choice.x + top.shape[0], choice.y : choice.y + top.shape[1]]
    assert np.array_equal(there, top) and heightmap.sum() == top.sum()


def test_a_plan_is_the_best_of_the_evaluations(grid, catalogue):
    """What the planner ranks and what `evaluate` says are two ways through the engine."""
    heightmap = np.random.default_rng(2).integers(0, 60, (32, 32), np.int16)
    buffer = [catalogue["mug"], catalogue["banana"], catalogue[40]]
    for heuristic in ["sdfm", "dbl", "hm", "mta"]:
        for proposals in ["all", "bounded"]:
            plan = ppnpack.plan(
                grid, heightmap, buffer, heuristic=heuristic, proposals={"from": proposals}, trial=UNTRIED, **PUBLISHED
            )
            values = np.stack([ppnpack.evaluate(grid, heightmap, item, heuristic).value for item in buffer])
            best = np.unravel_index(values.argmin(), values.shape)
            choice = plan.choice
            assert (choice.slot, choice.yaw, choice.x, choice.y) == tuple(int(index) for index in best)
            assert choice.value == pytest.approx(values.min(), abs=1e-9)


def test_methods_are_those_of_the_json(grid):
    planner = ppnpack.Planner(grid, {"heuristic": "hm", "buffer": 3}, heuristic="dbl", trial=UNTRIED)
    method = planner.method
    assert method["heuristic"] == "dbl" and method["buffer"] == 3
    assert method["trial"]["tries_per_item"] == 0 and method["trial"]["neighbour_m"] == 0.005
    assert ppnpack.Planner(grid, method).method == method


def test_an_item_comes_in_several_poses(grid):
    catalogue = ppnpack.Catalogue(grid, poses=4)
    poses = max((catalogue.poses(name) for name in catalogue.names), key=len)
    assert len(poses) > 1 and [item.pose for item in poses] == list(range(len(poses)))
    plan = ppnpack.plan(grid, grid.empty(), [poses], trial=UNTRIED)
    assert plan.choice.slot == 0 and plan.choice.pose < len(poses) and len(plan.reasons) == 1


def test_the_catalogue_is_a_sequence(catalogue):
    assert len(catalogue) == 96 and catalogue.names[3] == catalogue[3].name
    assert catalogue[-1].name == catalogue.names[-1]
    assert [item.name for item in catalogue] == catalogue.names
    assert catalogue["mug"].mass_kg > 0 and catalogue["mug"].has_solid
    with pytest.raises(KeyError, match="no object 'unicorn'"):
        catalogue["unicorn"]
    with pytest.raises(IndexError, match="0 to 95"):
        catalogue[96]


def test_folders_of_meshes_are_catalogues(grid, shared):
    folder = shared / "data" / "ycb_apc"
    if not folder.is_dir():
        pytest.skip(f"{folder} is absent")
    catalogue = ppnpack.Catalogue(grid, str(folder))
    assert len(catalogue) == 96


def test_items_are_made_of_meshes(grid):
    corners = np.array([[x, y, z] for x in (0, 0.2) for y in (0, 0.1) for z in (0, 0.05)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = np.array([(a, b, c) for a, b, c, _ in quads] + [(a, c, d) for a, _, c, d in quads], np.uint32)
    brick = ppnpack.Item.from_mesh(grid, "brick", corners, triangles, mass_kg=2.0)
    assert brick.top().shape == (20, 10) and brick.height() == 25
    assert brick.mesh_volume_m3 == pytest.approx(0.001) and brick.mass_kg == pytest.approx(2.0)
    with pytest.raises(ValueError):
        ppnpack.Item.from_mesh(grid, "torn", corners, triangles[:5])
    with pytest.raises(ValueError, match="3 columns"):
        ppnpack.Item.from_mesh(grid, "flat", corners[:, :2].copy(), triangles)


def test_surfaces_of_an_item_are_shared_and_cannot_be_written_to(catalogue):
    mug = catalogue["mug"]
    top, bottom = mug.top(1), mug.bottom(1)
    assert top is mug.top(1) and top.shape == bottom.shape
    assert bottom.min() == -1 and (top[bottom < 0] == 0).all()
    with pytest.raises(ValueError, match="read-only"):
        top[0, 0] = 5


def test_items_and_scenes_of_another_grid_are_refused(grid, catalogue):
    finer = ppnpack.Grid((0.32, 0.32, 0.30), 0.005, 0.002, [0, np.pi / 4, np.pi / 2, 3 * np.pi / 4])
    mug, scene = catalogue["mug"], ppnpack.SimulatedCell(grid).scan()
    for refused in (
        lambda: ppnpack.plan(finer, finer.empty(), [mug], trial=UNTRIED),
        lambda: ppnpack.evaluate(finer, finer.empty(), mug),
        lambda: ppnpack.resting_heights(finer, finer.empty(), mug),
        lambda: ppnpack.SimulatedCell(finer).place(mug, ppnpack.Placement(0, 0, 0, 0)),
    ):
        with pytest.raises(ValueError, match="item mug is made for another cell"):
            refused()
    own = ppnpack.Catalogue(finer)["mug"]
    with pytest.raises(ValueError, match=r"cells \[32, 32\], and the grid \[64, 64\]"):
        ppnpack.evaluate(finer, scene, own)


def test_arrays_of_another_type_are_refused_by_the_argument_s_name(grid, catalogue):
    mug = catalogue["mug"]
    with pytest.raises(TypeError, match=r"the scene is neither a Scene nor an int16 array .* grid.units"):
        ppnpack.evaluate(grid, np.zeros((32, 32)), mug)
    with pytest.raises(TypeError, match="heightmap"):
        ppnpack.place(np.zeros((32, 32)), mug, ppnpack.Placement(0, 0, 0, 0))
    with pytest.raises(TypeError, match="actions"):
        ppnpack.Packings(grid, catalogue).step(np.zeros(1))
    planner = ppnpack.Planner(grid, evaluator=lambda *_: "low", trial=UNTRIED)
    with pytest.raises(TypeError, match=r"the evaluator gave no array of numbers where \[4, 32, 32\]"):
        planner.plan(grid.empty(), [mug])


def test_a_catalogue_is_pickled_by_its_source_and_settings(grid):
    catalogue = ppnpack.Catalogue(grid, poses=2, pose="most-probable", density_kg_m3=300.0)
    other = pickle.loads(pickle.dumps(catalogue))
    assert other.content_hash() == catalogue.content_hash()
    assert copy.deepcopy(catalogue) is catalogue


def test_any_memory_layout_is_read(grid, block):
    heightmap = np.random.default_rng(3).integers(0, 50, (32, 32), np.int16)
    expected = ppnpack.resting_heights(grid, heightmap, block)
    for other in [np.asfortranarray(heightmap), np.repeat(heightmap, 2, 1)[:, ::2], heightmap[::-1][::-1]]:
        assert np.array_equal(ppnpack.resting_heights(grid, other, block), expected)


def test_wrong_input_raises_and_leaves_things_usable(grid, block, catalogue):
    planner = ppnpack.Planner(grid, trial=UNTRIED)
    empty = grid.empty()
    with pytest.raises(TypeError, match="int16|dtype"):
        planner.plan(empty.astype(np.float64), [block])
    with pytest.raises(ValueError, match="16 x 32.*32 x 32|needs 32 x 32"):
        planner.plan(empty[:16], [block])
    with pytest.raises(ValueError, match=r"height -1 of cell \(2, 3\)"):
        low = empty.copy()
        low[2, 3] = -1
        planner.plan(low, [block])
    with pytest.raises(TypeError, match="slot 1 of the buffer"):
        planner.plan(empty, [block, "mug"])
    with pytest.raises(ValueError, match="has 1 yaws, but the grid 4"):
        planner.plan(empty, [ppnpack.Item("once", [block.top()], [block.bottom()])])
    with pytest.raises(ValueError, match="item bad"):
        ppnpack.Item("bad", [np.zeros((2, 2), np.int16)], [np.zeros((2, 2), np.int16)])
    with pytest.raises(ValueError, match="unknown field `heuristics`"):
        ppnpack.Planner(grid, heuristics="sdfm")
    with pytest.raises(ValueError, match="weight"):
        ppnpack.Planner(grid, weights={"distance": -1.0})
    with pytest.raises(ValueError, match="needs a network"):
        network = {"from": "network", "percent": 5.0, "coarsening": {"cells": 1, "yaws": 1}}
        ppnpack.Planner(grid, proposals=network)
    with pytest.raises(ValueError, match="no folder"):
        ppnpack.Catalogue(grid, "/no/such/folder")
    with pytest.raises(ValueError, match="positive number of metres"):
        ppnpack.Grid(cell_m=0.0)
    with pytest.raises(ValueError, match="not inside the container"):
        ppnpack.place(empty, block, ppnpack.Placement(0, 30, 0, 0))
    assert planner.plan(empty, [block]).choice is not None


def test_what_has_no_place_has_a_reason(grid, block):
    full = np.full((32, 32), 149, np.int16)
    plan = ppnpack.plan(grid, full, [block], trial=UNTRIED)
    assert plan.choice is None and plan.reasons == ["would stick out above the rim everywhere"]
