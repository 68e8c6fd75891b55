"""Heightmaps as arrays."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from ppnpack.v1.grid_pb2 import Grid
from ppnpack.v1.scene_pb2 import Heightmap as HeightmapMessage

# As the services do it: a length that is a whole number of cells, but for rounding, has all of them.
_SLACK = 1e-6
_LARGEST_SIDE = 2048
_LARGEST_SAMPLES = 400


@dataclasses.dataclass(frozen=True, eq=False)
class Heightmap:
    """What perception saw of a container.

    heights is int16 [x, y], in units of height_unit_m; cell (x, y) begins at (x, y) * cell_m in the container frame. Everything below a
    height counts as full, what was not seen as what the lines of sight leave open. surface_m is the surface in more detail, float32 [x, y] in metres, with
    whole numbers of samples a cell; None where it is not known. doubts says why nothing is to be planned on it; empty where it can be trusted.
    age_s is how old it was when it was asked for; None from the stream.
    """

    heights: NDArray[np.int16]
    cell_m: float
    height_unit_m: float
    state_number: int
    doubts: tuple[str, ...]
    surface_m: NDArray[np.float32] | None
    age_s: float | None
    message: HeightmapMessage

    @property
    def heights_m(self) -> NDArray[np.float64]:
        """The heights in metres."""
        return self.heights.astype(np.float64) * self.height_unit_m

    @classmethod
    def of(cls, message: HeightmapMessage, age_s: float | None = None) -> Heightmap:
        """Reads a message. Raises ValueError where its parts do not fit together."""
        scene = message.scene
        shape = _cells(scene.grid)
        heights = _array(scene.heights, "<i2", shape, "heights").astype(np.int16)
        surface_m = None
        if scene.HasField("surface"):
            samples = scene.surface.samples_per_cell
            if not 1 <= samples <= _LARGEST_SAMPLES:
                raise ValueError(f"a heightmap has {samples} samples along a cell")
            shape = (shape[0] * samples, shape[1] * samples)
            surface_m = _array(scene.surface.heights_m, "<f4", shape, "samples").astype(np.float32)
        return cls(
            heights=heights,
            cell_m=scene.grid.cell_m,
            height_unit_m=scene.grid.height_unit_m,
            state_number=message.state_number,
            doubts=tuple(doubt.message or str(doubt.kind) for doubt in message.quality.doubts),
            surface_m=surface_m,
            age_s=age_s,
            message=message,
        )


def _cells(grid: Grid) -> tuple[int, int]:
    sides_m = (grid.container.x_m, grid.container.y_m)
    if not (math.isfinite(grid.cell_m) and grid.cell_m > 0 and all(map(math.isfinite, sides_m))):
        raise ValueError("a heightmap's grid has no size")
    nx, ny = (math.floor(side_m / grid.cell_m + _SLACK) for side_m in sides_m)
    if not (1 <= nx <= _LARGEST_SIDE and 1 <= ny <= _LARGEST_SIDE):
        raise ValueError(f"a heightmap has {nx} x {ny} cells")
    return nx, ny


def _array(data: bytes, dtype: str, shape: tuple[int, int], what: str) -> NDArray[np.generic]:
    values = np.frombuffer(data, dtype) if len(data) % np.dtype(dtype).itemsize == 0 else None
    if values is None or values.size != shape[0] * shape[1]:
        raise ValueError(f"a heightmap has {len(data)} bytes of {what}, which are not {shape[0]} x {shape[1]}")
    return values.reshape(shape)
