"""Plans how a robot packs general objects into a container, one at a time.

    import ppnpack

    grid = ppnpack.Grid()                       # 128 x 128 cells of 2.5 mm, heights in units of 2 mm, 16 yaws
    catalogue = ppnpack.Catalogue(grid)         # 96 household objects
    buffer = [catalogue["mug"], catalogue["bowl"]]
    plan = ppnpack.plan(grid, grid.empty(), buffer)
    heightmap = ppnpack.place(grid.empty(), buffer[plan.choice.slot], plan.choice)

Heights are int16 arrays [x, y] in units of the grid; what there is of every placement of an item is an array [yaw, x, y], by the cell of the
footprint's corner with the lowest indices. Everything else is in SI units, and names say them. Whatever computes does so with the
interpreter's lock released. ppnpack.envs has environments for Gymnasium, ppnpack.client is a client of the services.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

# The engine is loaded when it is first used: the client does without.
if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    import numpy as np
    from numpy.typing import NDArray

    from ppnpack._native import (
        Body,
        Catalogue,
        Evaluation,
        Grid,
        Item,
        Observation,
        Packings,
        PlacedReport,
        Placement,
        Plan,
        Planner,
        Scene,
        SimulatedCell,
        Stepped,
        evaluate,
        place,
        resting_heights,
    )

__all__ = [
    "Body",
    "Catalogue",
    "Evaluation",
    "Grid",
    "Item",
    "Observation",
    "Packings",
    "PlacedReport",
    "Placement",
    "Plan",
    "Planner",
    "Scene",
    "SimulatedCell",
    "Stepped",
    "evaluate",
    "place",
    "plan",
    "resting_heights",
]


def plan(
    grid: Grid,
    scene: Scene | NDArray[np.int16],
    buffer: Iterable[Item | Sequence[Item]],
    method: dict[str, Any] | None = None,
    *,
    step: int = 0,
    alternatives: int = 0,
    deadline_s: float | None = None,
    **settings: Any,
) -> Plan:
    """Plans one step. A Planner does the same, and is quicker for more than one."""
    from ppnpack._native import Planner

    planner = Planner(grid, method, **settings)
    return planner.plan(scene, buffer, step=step, alternatives=alternatives, deadline_s=deadline_s)


if not TYPE_CHECKING:

    def __getattr__(name: str) -> Any:
        if name not in __all__:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        value = getattr(importlib.import_module("ppnpack._native"), name)
        globals()[name] = value
        return value

    def __dir__() -> list[str]:
        return sorted({*globals(), *__all__})
