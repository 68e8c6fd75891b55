"""Packing as environments of Gymnasium: `pip install ppnpack[envs]`.

    import gymnasium
    import ppnpack.envs

    env = gymnasium.make("ppnpack/Packing-v0", physics=False)
    observation, info = env.reset(seed=1)
    action = env.action_space.sample(observation["action_mask"])
    observation, reward, terminated, truncated, info = env.step(action)

An episode packs one container: `items` objects of a catalogue arrive in random order, and a step places one of the `buffer` ones that wait
at a yaw and a cell. The next one that arrives takes the slot of the one that was placed. The reward is by how much the packed share of the
container's volume changed, so that an episode's rewards add up to the share that is packed in the end. It ends when nothing can be placed any
more, or when an action is taken that is not possible.

Observation, a dictionary; arrays are the caller's own:
    heightmap      int16 [nx, ny]              the container's, in units of the grid
    item_top       int16 [slot, yaw, nx, ny]   upper surfaces of the buffer's items from their lowest points, from the footprint's corner on;
                                               0 where there is no material
    item_bottom    int16 [slot, yaw, nx, ny]   lower surfaces; -1 where there is no material
    resting_height int16 [slot, yaw, nx, ny]   where the item would come to rest; -1 where its footprint is not inside the container
    action_mask    int8 [actions]              1 where an action is possible

Action: an index into [slot, yaw, x, y], row-major; `action_shape` is that shape.
"""

from __future__ import annotations

import secrets
from collections.abc import Sequence
from typing import Any, Literal

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from ppnpack import Catalogue, Grid, Observation, Packings

__all__ = ["PackingEnv", "VectorPackingEnv"]


class PackingEnv(gymnasium.Env[dict[str, NDArray[Any]], np.int64]):
    """One container.

    grid: the paper's where none is given. catalogue: the objects, made for the grid; the built-in ones where none is given. buffer: how many
    items a step may choose from. items: how many arrive in an episode. physics: whether they are released in a simulated cell, settle and are
    scanned; else each stays where it comes to rest. stability: "published" has only placements possible that the paper's test accepts, "none"
    all that fit below the rim. cell: settings of the simulated cell that differ, as of ppnpack.SimulatedCell. camera: with physics, has
    depth cameras see the container in place of an exact scan, as of ppnpack.SimulatedCell; {} is one.
    render_mode: "rgb_array" draws the container, 640 x 480.

    reset takes as options {"objects": [...]}: the indices in the catalogue of those that arrive, in place of random ones.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 4}

    def __init__(
        self,
        grid: Grid | None = None,
        catalogue: Catalogue | None = None,
        *,
        buffer: int = 5,
        items: int = 80,
        physics: bool = False,
        stability: Literal["none", "published"] = "none",
        cell: dict[str, Any] | None = None,
        camera: dict[str, Any] | None = None,
        render_mode: Literal["rgb_array"] | None = None,
    ) -> None:
        self.render_mode = _mode(render_mode)
        self.grid = Grid.reference() if grid is None else grid
        self.catalogue = Catalogue(self.grid) if catalogue is None else catalogue
        self._packings = Packings(
            self.grid,
            self.catalogue,
            buffer=buffer,
            items=items,
            physics=physics,
            stability=stability,
            cell=cell,
            camera=camera,
            seed=_random_seed(),
        )
        self.action_shape = (buffer, *self.grid.shape)
        self.observation_space: spaces.Space[Any] = _observation_space(self.action_shape, self._packings)
        self.action_space = spaces.Discrete(_size(self.action_shape))
        self._mask = np.zeros(_size(self.action_shape), np.int8)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
        super().reset(seed=seed)
        objects = _objects(options)
        observed = self._packings.reset([seed], None if objects is None else [list(objects)])
        return self._observation(observed), {"objects": observed.objects[0], "volume_share": 0.0, "packed": 0}

    def step(self, action: Any) -> tuple[dict[str, NDArray[Any]], float, bool, bool, dict[str, Any]]:
        observed, stepped = self._packings.step(_whole([action]))
        info = {
            "objects": observed.objects[0],
            "volume_share": float(stepped.volume_share[0]),
            "packed": int(stepped.packed[0]),
            "is_valid": bool(stepped.is_valid[0]),
        }
        return self._observation(observed), float(stepped.reward[0]), bool(stepped.is_over[0]), False, info

    def render(self) -> Any:
        """The container from above, uint8 [480, 640, 3], where the render mode is "rgb_array"."""
        return None if self.render_mode is None else self._packings.picture()

    def action_masks(self) -> NDArray[np.bool_]:
        """Which actions are possible: bool [actions]. Some libraries ask an environment for it by this name."""
        possible: NDArray[np.bool_] = self._mask == 1
        return possible

    def _observation(self, observed: Observation) -> dict[str, NDArray[Any]]:
        self._mask = observed.action_mask[0].copy()
        return {
            "heightmap": observed.heightmap[0],
            "item_top": observed.item_top[0],
            "item_bottom": observed.item_bottom[0],
            "resting_height": observed.resting_height[0],
            "action_mask": observed.action_mask[0],
        }


class VectorPackingEnv(VectorEnv[dict[str, NDArray[Any]], NDArray[np.int64], NDArray[Any]]):
    """Containers that are stepped together, on so many threads; as many as the machine has cores where it is not said.

    The rest is as in PackingEnv. One that is over begins anew at the next step, whatever its action is.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 4, "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        num_envs: int = 1,
        grid: Grid | None = None,
        catalogue: Catalogue | None = None,
        *,
        buffer: int = 5,
        items: int = 80,
        physics: bool = False,
        stability: Literal["none", "published"] = "none",
        cell: dict[str, Any] | None = None,
        camera: dict[str, Any] | None = None,
        threads: int | None = None,
        render_mode: Literal["rgb_array"] | None = None,
    ) -> None:
        super().__init__()
        self.num_envs = num_envs
        self.render_mode = _mode(render_mode)
        self.grid = Grid.reference() if grid is None else grid
        self.catalogue = Catalogue(self.grid) if catalogue is None else catalogue
        self._packings = Packings(
            self.grid,
            self.catalogue,
            num_envs,
            buffer=buffer,
            items=items,
            physics=physics,
            stability=stability,
            cell=cell,
            camera=camera,
            threads=threads,
            seed=_random_seed(),
        )
        self.action_shape = (buffer, *self.grid.shape)
        self.single_observation_space = _observation_space(self.action_shape, self._packings)
        self.single_action_space = spaces.Discrete(_size(self.action_shape))
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
        # As Gymnasium's own vectors count on from one seed.
        seeds: list[int | None]
        if seed is None:
            seeds = [None] * self.num_envs
        elif isinstance(seed, int | np.integer):
            seeds = [int(seed) + number for number in range(self.num_envs)]
        else:
            seeds = list(seed)
        objects = _objects(options)
        observed = self._packings.reset(seeds, None if objects is None else [list(each) for each in objects])
        infos = {
            "objects": observed.objects,
            "volume_share": np.zeros(self.num_envs),
            "packed": np.zeros(self.num_envs, np.int64),
        }
        return _observation(observed), _of_all(infos, self.num_envs)

    def step(
        self, actions: NDArray[np.int64]
    ) -> tuple[dict[str, NDArray[Any]], NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        observed, stepped = self._packings.step(_whole(actions), autoreset=True)
        infos = {
            "objects": observed.objects,
            "volume_share": stepped.volume_share,
            "packed": stepped.packed,
            "is_valid": stepped.is_valid,
        }
        truncations = np.zeros(self.num_envs, np.bool_)
        return _observation(observed), stepped.reward, stepped.is_over, truncations, _of_all(infos, self.num_envs)

    def render(self) -> Any:
        """Each container as PackingEnv draws it, where the render mode is "rgb_array"."""
        return None if self.render_mode is None else tuple(map(self._packings.picture, range(self.num_envs)))


def _size(shape: Sequence[int]) -> int:
    return int(np.prod(shape))


def _random_seed() -> int:
    return secrets.randbits(63)


def _mode(render_mode: Any) -> Any:
    if render_mode not in (None, "rgb_array"):
        raise ValueError(f"the render mode is 'rgb_array' or none, not {render_mode!r}")
    return render_mode


def _objects(options: dict[str, Any] | None) -> Any:
    """The objects that options name; what else they say is refused."""
    options = dict(options or {})
    objects = options.pop("objects", None)
    if options:
        raise ValueError(f"reset takes the option 'objects' alone, not {', '.join(options)}")
    return objects


def _whole(actions: Any) -> NDArray[np.int64]:
    given: NDArray[Any] = np.asarray(actions)
    if given.dtype.kind not in "iu":
        raise TypeError(f"actions are whole numbers, not {given.dtype}")
    return given.astype(np.int64)


def _observation_space(action_shape: tuple[int, ...], packings: Packings) -> spaces.Dict:
    greatest = packings.greatest_height
    return spaces.Dict(
        {
            "heightmap": spaces.Box(0, greatest, action_shape[2:], np.int16),
            "item_top": spaces.Box(0, greatest, action_shape, np.int16),
            "item_bottom": spaces.Box(-1, greatest, action_shape, np.int16),
            "resting_height": spaces.Box(-1, greatest, action_shape, np.int16),
            "action_mask": spaces.MultiBinary(_size(action_shape)),
        }
    )


def _observation(observed: Observation) -> dict[str, NDArray[Any]]:
    return {
        "heightmap": observed.heightmap,
        "item_top": observed.item_top,
        "item_bottom": observed.item_bottom,
        "resting_height": observed.resting_height,
        "action_mask": observed.action_mask,
    }


def _of_all(infos: dict[str, NDArray[Any]], num_envs: int) -> dict[str, Any]:
    """With the masks that say that each environment has each information."""
    return infos | {f"_{key}": np.ones(num_envs, np.bool_) for key in infos}


gymnasium.register(
    id="ppnpack/Packing-v0",
    entry_point="ppnpack.envs:PackingEnv",
    vector_entry_point="ppnpack.envs:VectorPackingEnv",
)
