"""Plans where to put a bowl beside a mug, in ten lines."""

import ppnpack

grid = ppnpack.Grid()
catalogue = ppnpack.Catalogue(grid)
planner = ppnpack.Planner(grid)
cell = ppnpack.SimulatedCell(grid)
for name in ["mug", "bowl"]:
    choice = planner.plan(cell.scan(), [catalogue[name]]).choice
    report = cell.place(catalogue[name], choice)
    height_mm = choice.resting_height * grid.height_unit_m * 1000
    print(f"{name}: cell ({choice.x}, {choice.y}), yaw {choice.yaw}, {height_mm:.0f} mm up, slid {report.slide_m * 1000:.1f} mm")
