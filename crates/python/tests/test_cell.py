"""The simulated cell."""

import numpy as np
import pytest

import ppnpack


def packed(grid, catalogue, names):
    """A cell in which items are packed by plans that are tried first."""
    cell = ppnpack.SimulatedCell(grid)
    planner = ppnpack.Planner(grid)
    for step, name in enumerate(names):
        plan = planner.plan(cell.scan(), [catalogue[name]], step=step)
        report = cell.place(catalogue[name], plan.choice)
        assert report.inside and not report.toppled and not plan.degraded
    return cell


def test_items_lie_where_they_were_placed_and_scans_see_them(grid, catalogue):
    cell = packed(grid, catalogue, ["mug", "bowl", "banana"])
    bodies = cell.contents()
    assert [body.name for body in bodies] == ["mug", "bowl", "banana"]
    assert all(body.inside and body.mass_kg > 0 for body in bodies)
    scene = cell.scan()
    assert scene.solids == 3 and scene.heightmap.shape == (32, 32) and scene.surface_m.shape == (128, 128)
    for body in bodies:
        pose = body.container_from_item
        assert np.allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-6) and pose[3].tolist() == [0, 0, 0, 1]
        x, y = (pose[:2, 3] / grid.cell_m).astype(int)
        assert scene.heightmap[max(x - 3, 0) : x + 4, max(y - 3, 0) : y + 4].max() > 0
    cell.reset()
    assert not cell.contents() and cell.scan().heightmap.max() == 0


def test_a_pose_of_the_catalogue_turns_the_objects_own_frame(grid):
    catalogue = ppnpack.Catalogue(grid, poses=4)
    name = next(name for name in catalogue.names if len(catalogue.poses(name)) > 1)
    turned = catalogue.poses(name)[1]
    cell = ppnpack.SimulatedCell(grid)
    plan = ppnpack.plan(grid, grid.empty(), [turned], trial={"tries_per_item": 0})
    cell.place(turned, plan.choice)
    [body] = cell.contents()
    assert abs(body.container_from_item[2, 2]) < 0.99


def test_a_try_changes_nothing_and_the_same_calls_give_the_same(grid, catalogue):
    at = ppnpack.Placement(0, 4, 4, 0)
    cells = [ppnpack.SimulatedCell(grid, seed=5, release={"jitter_m": 0.002}) for _ in range(2)]
    tried = cells[0].try_place(catalogue["mug"], at)
    assert not cells[0].contents()
    made = [cell.place(catalogue["mug"], at) for cell in cells]
    for report in made:
        assert np.array_equal(report.container_from_item, tried.container_from_item)
    assert cells[0].is_still == tried.still


def test_settings_are_those_of_the_engine(grid, catalogue):
    reference = ppnpack.SimulatedCell(grid, "reference")
    robot = ppnpack.SimulatedCell(grid)
    at = ppnpack.Placement(0, 4, 4, 0)
    assert reference.place(catalogue["mug"], at).simulated_s <= 0.375 + 1e-9
    assert robot.place(catalogue["mug"], at).body == 0
    with pytest.raises(ValueError, match="friction"):
        ppnpack.SimulatedCell(grid, contact={"item_friction": -1.0})
    with pytest.raises(ValueError, match="unknown field"):
        ppnpack.SimulatedCell(grid, gravity=1.0)
    with pytest.raises(ValueError, match="'robot', 'twin' or 'reference'"):
        ppnpack.SimulatedCell(grid, "moon")


def test_what_cannot_be_placed_is_refused_and_the_cell_is_as_before(grid, catalogue, block):
    cell = ppnpack.SimulatedCell(grid)
    with pytest.raises(ValueError, match="solid of item block is not known"):
        cell.place(block, ppnpack.Placement(0, 0, 0, 0))
    with pytest.raises(ValueError, match="no such yaw"):
        cell.place(catalogue["mug"], ppnpack.Placement(4, 0, 0, 0))
    assert not cell.contents() and cell.place(catalogue["mug"], ppnpack.Placement(0, 0, 0, 0)).inside
