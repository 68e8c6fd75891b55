"""A packing cell in MuJoCo behind the stack, and how full its containers get.

It is what an integrator writes for a real cell, in one file: a robot behind the bridge, cameras that publish clouds, and a controller that
has containers packed. The physics are not those that the planner tries placements in: they show what it does not know.

    pip install mujoco "scipy>=1.16" trimesh vhacdx -r examples/python/requirements.txt
    export PYTHONPATH=crates/python/python
    python examples/python/mujoco_cell.py --ppnpack target/release/ppnpack --catalogue FOLDER --view camera --sequences 0-3

It starts the other services itself, on this machine alone. Exit codes: 0 done, 1 failed or worse than asked for, 2 wrong use or input.
"""

import argparse
import csv
import hashlib
import json
import math
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

try:
    import mujoco
    import numpy as np
    import trimesh
    import vhacdx  # noqa: F401 (trimesh needs it to make convex pieces)
    import zenoh
    from numpy.typing import NDArray
    from scipy.spatial.transform import RigidTransform, Rotation

    from ppnpack import check_bridge, robot
    from ppnpack.client import Announcement, Cell, ClientError, Connection, ItemState, PlanResult, Unanswered, Unreachable
    from ppnpack.v1 import bridge_pb2 as bridge
    from ppnpack.v1 import cloud_pb2 as cloud
    from ppnpack.v1 import geometry_pb2 as geometry
except ImportError as error:
    sys.exit(f"mujoco_cell: {error}; what is needed, and where it comes from, stands at the beginning of {__file__}")

Array = NDArray[np.float64]

NAME = "cell-1"
SIZE_M, WALL_M = np.array([0.32, 0.32, 0.30]), 0.010
DENSITY_KG_M3 = 400.0  # Of what has no mass in objects.csv; the catalogue's own.
FRICTION_ITEMS, FRICTION_WALLS = 0.5, 0.3
RELEASE_M = 0.01  # How far above its place the robot lets go of an item: the planner tries placements from the same height.
STEP_S, CONTACT_S = 0.002, 0.012  # With stiffer contacts small items in a full container tremble, and nothing ever lies still.
SETTLE_S = 2.0
TOPPLED_RAD, SLID_M = math.radians(30.0), 0.02  # Beyond these an item is unsteady, as in docs/results/filling.md.
CAMERA_M, IMAGE_PX, FOCAL_PX, NOISE_M, DROPOUT = 0.9, (640, 480), 600.0, 0.001, 0.05
SERVICES = ("router", "perception", "planner", "bridge")


class InputError(Exception):
    """Something that was given is wrong: what, and what helps."""


# Objects


@dataclass(frozen=True)
class Shape:
    """An object, in the frame of its mesh file: it is the item's own frame on the wire."""

    mesh: trimesh.Trimesh
    pieces: list[Array]


def listed_meshes(folder: pathlib.Path) -> dict[str, tuple[pathlib.Path, float, float | None]]:
    """File, scale and mass of each object by its name, in the catalogue's order (docs/guides/own-objects.md): the planner has the same."""
    if not folder.is_dir():
        raise InputError(f"--catalogue {folder}: there is no such folder; give one of .ply, .obj or .stl files")
    paths = sorted(path for path in folder.iterdir() if path.suffix.lower() in (".ply", ".obj", ".stl"))
    rows: list[dict[str, str]] = [{"file": path.name} for path in paths]
    scales, listed, table = {"": 1.0, "m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}, {}, folder / "objects.csv"
    try:
        if table.is_file():
            rows = list(csv.DictReader(table.read_text().splitlines()))
            order = {id(row): int(row.get("index") or number) for number, row in enumerate(rows)}
            rows.sort(key=lambda row: order[id(row)])
        for row in rows:
            path = folder / row["file"]
            listed[row.get("name") or path.stem] = path, scales[row.get("unit") or ""], float(row.get("mass_kg") or 0.0) or None
    except (KeyError, ValueError) as error:
        raise InputError(f"{table}: {error}; `ppnpack catalogue check --catalogue {folder}` says what is wrong with it") from error
    if not listed:
        raise InputError(f"--catalogue {folder}: it has no meshes; give a folder of .ply, .obj or .stl files")
    return listed


def load_shape(path: pathlib.Path, scale: float, mass_kg: float | None, cache: pathlib.Path) -> Shape:
    try:
        mesh = trimesh.load(path, force="mesh").apply_scale(scale)
    except Exception as error:  # Each format has its own.
        raise InputError(f"{path} cannot be read as a mesh: {error}") from error
    if not mesh.is_volume:
        mesh.fill_holes()
        mesh.fix_normals()
    if not mesh.volume > 0.0:
        raise InputError(f"{path} encloses no volume; `ppnpack catalogue check` says what is wrong with it")
    mesh.density = mass_kg / mesh.volume if mass_kg else DENSITY_KG_M3
    return Shape(mesh, convex_pieces(mesh, cache))


def convex_pieces(mesh: trimesh.Trimesh, cache: pathlib.Path) -> list[Array]:
    """Vertices of convex pieces that together are about the mesh: a bowl's hull is full. It takes some seconds an object, once."""
    if mesh.volume > 0.95 * mesh.convex_hull.volume:
        return [np.array(mesh.convex_hull.vertices)]
    settings = {"maxConvexHulls": 32, "resolution": 100_000, "minimumVolumePercentErrorAllowed": 0.5, "maxNumVerticesPerCH": 48}
    key = hashlib.sha256(repr(settings).encode() + mesh.vertices.tobytes() + mesh.faces.tobytes()).hexdigest()[:32]
    kept = cache / f"{key}.npz"
    if not kept.is_file():
        cache.mkdir(parents=True, exist_ok=True)
        unfinished = cache / f"{key}.{os.getpid()}.part"
        with unfinished.open("wb") as out:
            np.savez(out, *(piece.vertices for piece in mesh.convex_decomposition(**settings)))
        unfinished.rename(kept)
    with np.load(kept) as pieces:
        return [pieces[name] for name in pieces.files]


def pose_of(message: geometry.Pose) -> RigidTransform:
    at, turn = message.position, message.orientation
    return RigidTransform.from_components([at.x_m, at.y_m, at.z_m], Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]))


def message_of(pose: RigidTransform) -> geometry.Pose:
    (x_m, y_m, z_m), (x, y, z, w) = pose.translation.tolist(), pose.rotation.as_quat().tolist()
    return geometry.Pose(position=geometry.Vector3(x_m=x_m, y_m=y_m, z_m=z_m), orientation=geometry.Quaternion(x=x, y=y, z=z, w=w))


# The cell


@dataclass(frozen=True)
class Finding:
    """What became of a placement, when everything lay still."""

    container_from_item: RigidTransform
    is_inside: bool
    is_lost: bool
    tilt_rad: float
    slide_m: float
    disturbance_m: float

    @property
    def is_unsteady(self) -> bool:
        return self.tilt_rad > TOPPLED_RAD or self.slide_m > SLID_M or not self.is_inside


def fixed_boxes() -> list[Array]:
    """Floor, walls and the table around them, by their lowest and highest corners."""
    (x, y, z), wall = SIZE_M, WALL_M
    boxes = [[[-1, -1, -0.03], [x + 1, y + 1, -wall]], [[-wall, -wall, -wall], [x + wall, y + wall, 0]]]
    boxes += [[[-wall, -wall, -wall], [0, y + wall, z]], [[x, -wall, -wall], [x + wall, y + wall, z]]]
    boxes += [[[-wall, -wall, -wall], [x + wall, 0, z]], [[-wall, y, -wall], [x + wall, y + wall, z]]]
    return [np.array(box, float) for box in boxes]


class PhysicalCell:
    """The container on a table and what lies in it. MuJoCo's world is the container's frame: its origin is an inner bottom corner."""

    def __init__(self, shapes: dict[str, Shape]) -> None:
        self.shapes = shapes
        self.empty()

    def empty(self) -> None:
        """Another container, with nothing in it."""
        self.items: dict[str, str] = {}  # The objects by the ids of what lies there.
        self._spec = mujoco.MjSpec()
        option = self._spec.option
        option.timestep, option.gravity, option.integrator = STEP_S, [0.0, 0.0, -9.8], mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        option.cone, option.impratio = mujoco.mjtCone.mjCONE_ELLIPTIC, 10.0  # Otherwise things creep.
        for low, high in fixed_boxes():
            box = self._spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=(high - low) / 2, pos=(high + low) / 2)
            # By the priority the container's friction counts where an item touches it.
            box.friction, box.priority, box.solref = [FRICTION_WALLS, 0.005, 0.0001], 1, [CONTACT_S, 1.0]
        self._model = self._spec.compile()
        self._data = mujoco.MjData(self._model)

    def pose(self, item_id: str) -> RigidTransform:
        body = self._data.body(item_id)
        return RigidTransform.from_components(body.xpos, Rotation.from_quat(body.xquat, scalar_first=True))

    def centre_m(self, item_id: str) -> Array:
        return self._data.body(item_id).xipos.copy()

    def is_inside(self, item_id: str) -> bool:
        return not outside_m(self.centre_m(item_id)).any()

    def place(self, item_id: str, name: str, planned: RigidTransform) -> Finding:
        """Lets go of an item at rest a little above its planned pose, and waits until everything is still."""
        before_m = {other: self.centre_m(other) for other in self.items}
        self._add(item_id, name, planned)
        self._settle()
        pose, is_inside = self.pose(item_id), self.is_inside(item_id)
        tilt_rad = math.acos(np.clip((pose.rotation * planned.rotation.inv()).as_matrix()[2, 2], -1.0, 1.0))
        slide_m = np.linalg.norm((self.centre_m(item_id) - planned.apply(self.shapes[name].mesh.center_mass))[:2])
        disturbance_m = max((np.linalg.norm(self.centre_m(other) - at_m) for other, at_m in before_m.items()), default=0.0)
        lost = [other for other in self.items if outside_m(self.centre_m(other))[:2].max() > WALL_M + 0.05]
        for other in lost:
            self._spec.delete(self._spec.body(other))
            del self.items[other]
        self._compile()
        return Finding(pose, is_inside, item_id in lost, tilt_rad, float(slide_m), float(disturbance_m))

    def surfaces(self) -> Iterator[Array]:
        """All that a sensor sees, as corners of triangles [triangle, corner, coordinate]."""
        for box in fixed_boxes():
            yield trimesh.creation.box(bounds=box).triangles
        for item_id, name in self.items.items():
            mesh = self.shapes[name].mesh
            yield self.pose(item_id).apply(mesh.vertices)[mesh.faces]

    def _add(self, item_id: str, name: str, planned: RigidTransform) -> None:
        mesh, quaternion = self.shapes[name].mesh, planned.rotation.as_quat(scalar_first=True)
        body = self._spec.worldbody.add_body(name=item_id, pos=planned.translation + [0.0, 0.0, RELEASE_M], quat=quaternion)
        body.add_freejoint()
        # Mass and inertia are the mesh's: its pieces overlap and hold some air.
        body.explicitinertial, body.mass, body.ipos = True, mesh.mass, mesh.center_mass
        body.fullinertia = mesh.moment_inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        for number, vertices in enumerate(self.shapes[name].pieces):
            piece = f"{name}/{number}"
            if self._spec.mesh(piece) is None:
                self._spec.add_mesh(name=piece, uservert=vertices.ravel())
            geom = body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=piece)
            geom.friction, geom.solref = [FRICTION_ITEMS, 0.005, 0.0001], [CONTACT_S, 1.0]
        self.items[item_id] = name
        self._compile()

    def _compile(self) -> None:
        """Takes over what came and went; the rest is where it was, and moves as it did."""
        self._model, self._data = self._spec.recompile(self._model, self._data)
        mujoco.mj_forward(self._model, self._data)

    def _settle(self) -> None:
        still_s, end_s = 0.0, self._data.time + SETTLE_S
        while still_s < 0.1 and self._data.time < end_s:
            mujoco.mj_step(self._model, self._data, nstep=5)
            # Three speeds along the axes and three about them for each body, whose surface is some 5 cm away.
            speeds = np.abs(self._data.qvel.reshape(-1, 6)) * [1.0, 1.0, 1.0, 0.05, 0.05, 0.05]
            still_s = still_s + 5 * STEP_S if speeds.max() < 0.01 else 0.0


def outside_m(point_m: Array) -> Array:
    """How far a point is outside the container, along each axis."""
    return np.abs(point_m - np.clip(point_m, 0.0, SIZE_M))


# Sensors


def draw(image: Array, corners: Array) -> None:
    """Raises an image [row, column] to triangles [triangle, corner, (column, row, value)], in the pixels whose middle is in one."""
    first = np.maximum(np.ceil(corners[:, :, :2].min(1) - 0.5), 0).astype(np.int64)
    last = np.minimum(np.floor(corners[:, :, :2].max(1) - 0.5), [image.shape[1] - 1, image.shape[0] - 1]).astype(np.int64)
    a, b, c = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0]
    is_seen = np.all(last >= first, axis=1) & (area != 0.0)
    first, last, a, b, c, area = (part[is_seen] for part in (first, last, a, b, c, area))
    # The pixels of the rectangles around all triangles, one after another.
    sides = last - first + 1
    counts = sides.prod(1)
    of = np.repeat(np.arange(len(counts)), counts)
    nth = np.arange(len(of)) - np.repeat(np.cumsum(counts) - counts, counts)
    column, row = first[of, 0] + nth % sides[of, 0], first[of, 1] + nth // sides[of, 0]
    x, y = column + 0.5 - a[of, 0], row + 0.5 - a[of, 1]
    to_b, to_c = (x * c[of, 1] - y * c[of, 0]) / area[of], (y * b[of, 0] - x * b[of, 1]) / area[of]
    is_hit = (to_b >= -1e-9) & (to_c >= -1e-9) & (to_b + to_c <= 1.0 + 1e-9)
    values = a[of, 2] + to_b * b[of, 2] + to_c * c[of, 2]
    np.maximum.at(image, (row[is_hit], column[is_hit]), values[is_hit])


class Camera:
    """A depth camera that looks at the middle of the floor. x of its frame is to the right of the image, y down, z ahead."""

    def __init__(self, name: str, beside_m: float) -> None:
        self.name = name
        place_m = SIZE_M * [0.5, 0.5, 0.0] + [beside_m, 0.0, CAMERA_M]
        ahead, down = np.array([-beside_m, 0.0, -CAMERA_M]) / math.hypot(beside_m, CAMERA_M), np.array([0.0, -1.0, 0.0])
        self.container_from_sensor = RigidTransform.from_components(
            place_m, Rotation.from_matrix(np.column_stack([np.cross(down, ahead), down, ahead]))
        )

    def see(self, surfaces: Iterator[Array]) -> NDArray[np.float32]:
        """The points of all pixels, row by row, in the camera's frame; NaN where there is nothing."""
        width, height = IMAGE_PX
        inverse_depth = np.zeros((height, width))
        for corners in surfaces:
            x, y, z = self.container_from_sensor.inv().apply(corners.reshape(-1, 3)).T.reshape(3, -1, 3)
            draw(inverse_depth, np.stack([FOCAL_PX * x / z + width / 2, FOCAL_PX * y / z + height / 2, 1.0 / z], -1))
        row, column = np.indices(inverse_depth.shape) + 0.5
        rays = np.stack([(column - width / 2) / FOCAL_PX, (row - height / 2) / FOCAL_PX, np.ones_like(row)], -1)
        return (rays / np.where(inverse_depth > 0.0, inverse_depth, np.nan)[..., None]).reshape(-1, 3).astype(np.float32)

    def measured(self, points_m: NDArray[np.float32], noise: np.random.Generator) -> NDArray[np.float32]:
        """As a sensor gives them: with noise along the rays, and holes."""
        stretch = 1.0 + np.float32(NOISE_M) * noise.standard_normal(len(points_m), np.float32) / np.linalg.norm(points_m, axis=1)
        stretch[noise.random(len(points_m), np.float32) < DROPOUT] = np.nan
        return points_m * stretch[:, None]


class Scanner:
    """An exact scan of the inside from straight above, in the container's frame."""

    name, container_from_sensor, pitch_m = "", RigidTransform.identity(), 0.00125

    def see(self, surfaces: Iterator[Array]) -> NDArray[np.float32]:
        heights_m = np.zeros(np.round(SIZE_M[[1, 0]] / self.pitch_m).astype(int))
        for corners in surfaces:
            draw(heights_m, corners / [self.pitch_m, self.pitch_m, 1.0])
        y, x = (np.indices(heights_m.shape) + 0.5) * self.pitch_m
        return np.stack([x, y, heights_m], -1).reshape(-1, 3).astype(np.float32)

    def measured(self, points_m: NDArray[np.float32], noise: np.random.Generator) -> NDArray[np.float32]:
        return points_m


def sensors_of(view: str, cameras: int) -> list[Camera | Scanner]:
    if view == "exact":
        return [Scanner()]
    return [Camera("camera", 0.0)] if cameras == 1 else [Camera("left", -0.15), Camera("right", 0.15)]


# The robot


class MujocoRobot(robot.Robot):
    """The cell as a robot behind the bridge that ships, and its sensors, which publish what they see by themselves."""

    def __init__(self, connection: Connection, cell: PhysicalCell, sensors: list[Camera | Scanner], cloud_period_s: float) -> None:
        self._session, self._cell, self._sensors, self._cloud_period_s = connection.session, cell, sensors, cloud_period_s
        self.findings: list[Finding] = []
        self.least_place_s = 0.0
        self._state = bridge.CellState()
        self._is_ended = False
        self._changed = threading.Condition()  # Guards all of these and what was looked at last.
        self._look()
        self._states = self._session.declare_subscriber(f"ppnpack/v1/{NAME}/state", self._on_state)
        self._publisher = threading.Thread(target=self._publish)
        self._publisher.start()

    def close(self) -> None:
        self._states.undeclare()
        with self._changed:
            self._is_ended = True
            self._changed.notify_all()
        self._publisher.join()

    def take_over(self, bodies: list[bridge.Body]) -> list[bridge.Body]:
        return self._bodies

    def bodies(self) -> list[bridge.Body]:
        return self._bodies

    def place(self, placement: bridge.PlaceRequest, is_given_up: threading.Event) -> bridge.Outcome:
        if is_given_up.wait(self.least_place_s):
            return robot.not_placed("it was given up before anything was touched")
        if placement.object not in self._cell.shapes or placement.item_id in self._cell.items:
            return robot.not_placed(f"there is no '{placement.object}', or {placement.item_id} lies in the container")
        found = self._cell.place(placement.item_id, placement.object, pose_of(placement.container_from_item))
        self.findings.append(found)
        # Before the new state is told: a cloud shows the state whose number it has.
        self._look()
        if found.is_lost:
            return robot.lost("the item fell beside the container")
        # Where it was found to lie: the planner tries the next items beside it there. A robot that does not look gives no pose.
        where = message_of(found.container_from_item)
        return robot.placed(where, is_inside=found.is_inside, slide_m=found.slide_m, tilt_rad=found.tilt_rad)

    def renew(self) -> None:
        self._cell.empty()
        self.findings = []
        self._look()

    def _look(self) -> None:
        views, bodies = [sensor.see(self._cell.surfaces()) for sensor in self._sensors], []
        for item, name in self._cell.items.items():
            pose = message_of(self._cell.pose(item))
            is_inside = self._cell.is_inside(item)
            bodies.append(bridge.Body(item_id=item, object=name, container_from_item=pose, is_inside=is_inside, is_found=True))
        with self._changed:
            self._views, self._bodies = views, bodies

    # The sensors

    def _on_state(self, told: zenoh.Sample) -> None:
        with self._changed:
            self._state = bridge.CellState.FromString(told.payload.to_bytes())
            self._changed.notify_all()

    def _publish(self) -> None:
        """Clouds of the state that the bridge told last, on each change and once a period, while the robot is not at work."""
        noise, sequence = np.random.default_rng(), 0
        fields = [cloud.PackedField(name=name, offset=4 * index, type=cloud.NUMERIC_TYPE_FLOAT32) for index, name in enumerate("xyz")]
        while not self._is_ended:
            with self._changed:
                self._changed.wait(self._cloud_period_s)
                state, views = self._state, self._views
            if state.executing_placement_id or not state.state_number:
                continue
            sequence += 1
            for sensor, points_m in zip(self._sensors, views):
                message = cloud.PointCloud(sequence=sequence, captured_at_ns=time.time_ns(), sensor=sensor.name, cell=NAME, fields=fields)
                message.container_from_sensor.CopyFrom(message_of(sensor.container_from_sensor))
                message.state_number, message.point_stride = state.state_number, 12
                message.data = sensor.measured(points_m, noise).astype("<f4").tobytes()
                encoding = f"application/protobuf;{message.DESCRIPTOR.full_name}"
                self._session.put(f"ppnpack/v1/{NAME}/cloud", message.SerializeToString(), encoding=encoding)


# The other services


class Stack:
    """Router, perception, planner and bridge, each a process of this machine; this program is the robot behind the bridge."""

    def __init__(self, options: argparse.Namespace, view: str) -> None:
        self._folder = pathlib.Path(tempfile.mkdtemp(prefix="ppnpack-mujoco-"))
        self._processes: dict[str, subprocess.Popen[bytes]] = {}
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.endpoint = f"tcp/127.0.0.1:{free.getsockname()[1]}"
        for service, text in zip(SERVICES, configurations(options, view, self.endpoint)):
            (self._folder / f"{service}.toml").write_text(text)
        self._programs = options.ppnpack.resolve().parent

    def start(self) -> None:
        for service in SERVICES:
            with (self._folder / f"{service}.log").open("wb") as log:
                command = [self._programs / f"ppnpack-{service}", "--config", self._folder / f"{service}.toml"]
                self._processes[service] = subprocess.Popen(command, stdout=log, stderr=log)

    def connect(self, patience_s: float) -> Connection:
        """A connection, once all services are ready: the planner takes a while to prepare a catalogue that is new to it."""
        connection = self._wait(lambda: Connection(self.endpoint), patience_s)
        cell = connection.cell(NAME, limit_s=1.0, patience_s=2.0)
        for service in SERVICES[1:]:
            self._wait(lambda: cell.health(service).is_ready or None, patience_s)  # noqa: B023
        return connection

    def _wait(self, ask: Callable[[], Any], patience_s: float) -> Any:
        end_s = time.monotonic() + patience_s
        while time.monotonic() < end_s:
            self.check()
            try:
                if (answer := ask()) is not None:
                    return answer
            except (Unanswered, Unreachable):
                pass
            time.sleep(0.2)
        raise RuntimeError(f"the services are not ready after {patience_s:g} s; are there other programs that keep the machine busy?")

    def check(self) -> None:
        """Raises where a service has ended, with its last words."""
        for service, process in self._processes.items():
            if process.poll() is not None:
                words = (self._folder / f"{service}.log").read_text(errors="replace").splitlines()[-3:]
                raise RuntimeError(f"ppnpack-{service} ended with {process.returncode}: {' | '.join(words)}")

    def close(self) -> None:
        for process in reversed(self._processes.values()):
            process.terminate()
        for process in self._processes.values():
            try:
                process.wait(10.0)
            except subprocess.TimeoutExpired:
                process.kill()
        shutil.rmtree(self._folder, ignore_errors=True)


def configurations(options: argparse.Namespace, view: str, endpoint: str) -> tuple[str, ...]:
    """The files of the services."""
    # On a machine that is busy with other things processes may be silent, and clouds on their way, for longer than in a cell.
    start = '[admin]\nlisten = "off"\n[zenoh]\nlease_s = 30.0\n'
    client = f'{start}connect = "{endpoint}"\n[service]\n'
    x_m, y_m, z_m = SIZE_M
    grid = f"""
[service.cells.{NAME}]
container = {{ x_m = {x_m}, y_m = {y_m}, z_m = {z_m} }}
cell_m = {options.cell}
height_unit_m = 0.002
yaws = {options.yaws}
"""
    # As docs/perception.md has it for a real camera.
    mapper = f"""
[service.sensors]
{NAME} = {json.dumps([sensor.name for sensor in sensors_of(view, options.cameras)])}
[service.mapper]
noise_m = {NOISE_M}
point_radius_m = 0.001
largest_hole_m = 0.005
wall_margin_m = 0.003
still = {{ clouds = 3 }}
doubts = {{ wall_thickness_m = {WALL_M}, reach_above_rim_m = 0.05 }}
"""
    method = f"""
buffer = {options.buffer}
poses = {options.poses}
evaluate = "in-process"
heightmap_age_limit_s = 60.0
"""
    router = f'{start}listen = "{endpoint}"\n'
    perception = f"{client}has_unlisted_cells = false\n{grid}{mapper if view == 'camera' else ''}"
    planner = f"{client}catalogue = {json.dumps(str(options.catalogue.resolve()))}\n{grid}{method}"
    # A simulated cell forgets with its process: the bridge of a real one has a journal.
    container = f"physics.container = {{ x_m = {x_m}, y_m = {y_m}, z_m = {z_m} }}"
    behind = f"{client}[service.cells.{NAME}]\n{container}\nremote = {{ is_simulated = true }}\n"
    return router, perception, planner, behind


# Packing


def pack(cell: Cell, arm: MujocoRobot, shapes: dict[str, Shape], names: list[str], options: argparse.Namespace, what: str) -> dict[str, Any]:
    """Packs one container with objects that arrive in this order; gives its figures."""
    began_s, decisions_s = time.monotonic(), []
    session = f"mujoco-{uuid.uuid4().hex}"
    cell.begin(session, least_state_number=cell.renew(request_id=session), set_aside=options.set_aside)
    cell.announce(Announcement(item_id=f"item-{number}", object=name, poses=options.poses) for number, name in enumerate(names))
    while (step := cell.next_step()).HasField("decision"):
        # Waiting for a heightmap is no part of the decision.
        stages = [stage for stage in step.decision.stages if stage.stage in ("propose", "evaluate", "check")]
        decisions_s.append(sum(stage.duration_ns for stage in stages) / 1e9)
        cell.report(step.decision, cell.carry_out(step.decision))
        progress(f"{what}: {len(decisions_s)} placed")
    inside = [shapes[body.object].mesh.volume for body in cell.state().bodies if body.is_inside]
    median_s, p95_s = np.quantile(decisions_s or [0.0], [0.5, 0.95]).tolist()
    return {
        "items": len(inside),
        "litres": 1000.0 * sum(inside),
        "placed": len(arm.findings),
        "unsteady": sum(finding.is_unsteady for finding in arm.findings),
        "moved_another": sum(finding.disturbance_m > SLID_M for finding in arm.findings),
        "set_aside": sum(item.state == ItemState.ITEM_STATE_SET_ASIDE for item in cell.session().items),
        "decision_s": {"median": median_s, "p95": p95_s},
        "took_s": time.monotonic() - began_s,
        "end": PlanResult.Name(step.result).removeprefix("PLAN_RESULT_").lower().replace("_", " "),
    }


def sequence_of(number: int, options: argparse.Namespace, names: list[str]) -> list[str]:
    """The objects that arrive: by a line of indices, or drawn by the seed where there is none or the catalogue has fewer objects."""
    if options.sequence_file is not None:
        try:
            lines = np.load(options.sequence_file)
        except (OSError, ValueError) as error:
            raise InputError(f"--sequence-file {options.sequence_file}: {error}; give a .npy file, or none for random sequences") from error
        if lines.ndim != 2 or not 0 <= number < len(lines):
            raise InputError(f"--sequences {number}: {options.sequence_file} has the shape {lines.shape}; give numbers of its lines")
        if 0 <= lines[number].min() and lines[number].max() < len(names):
            return [names[index] for index in lines[number, : options.items]]
        print(f"line {number} names other objects than {options.catalogue} has: a random sequence is packed", file=sys.stderr)
    return [names[index] for index in np.random.default_rng([options.seed, number]).integers(len(names), size=options.items)]


def pack_all(options: argparse.Namespace, view: str, sequences: dict[int, list[str]], shapes: dict[str, Shape]) -> list[dict[str, Any]]:
    """Packs the sequences one after another, seen by exact scans or by cameras."""
    runs, stack = [], Stack(options, view)
    try:
        stack.start()
        progress("waiting for the services")
        with stack.connect(patience_s=900.0) as connection:
            arm = MujocoRobot(connection, PhysicalCell(shapes), sensors_of(view, options.cameras), options.cloud_period)
            served = robot.serve(connection, arm, NAME)
            try:
                cell = connection.cell(NAME, limit_s=60.0, patience_s=900.0)
                if options.check_bridge and view == options.view:
                    of_kit = ["--connect", stack.endpoint, "--object", next(iter(shapes)), "--at", "0.16,0.16,0.15", "--moves-the-robot"]
                    arm.least_place_s = 2.0  # So that requests come while it moves.
                    if check_bridge.main(of_kit) != 0:
                        raise RuntimeError("the bridge with this robot does not do what the protocol asks of bridges")
                    arm.least_place_s = 0.0
                for number, names in sequences.items():
                    run = {"view": view, "sequence": number, **pack(cell, arm, shapes, names, options, f"{view}, sequence {number}")}
                    runs.append(run)
                    print(json.dumps(run), flush=True)
            finally:
                served.close()
                arm.close()
    except (ClientError, RuntimeError, zenoh.ZError):
        stack.check()  # Where a service has ended, that is why.
        raise
    finally:
        stack.close()
    return runs


def summary(runs: list[dict[str, Any]]) -> dict[str, float]:
    items, litres = (float(np.mean([run[name] for run in runs])) for name in ("items", "litres"))
    placed, unsteady = (sum(run[name] for run in runs) for name in ("placed", "unsteady"))
    return {"items": items, "litres": litres, "placed": placed, "unsteady": unsteady, "unsteady_share": unsteady / max(placed, 1)}


def progress(text: str) -> None:
    print(f"\r\033[K{text}" if sys.stderr.isatty() else text, end="" if sys.stderr.isatty() else "\n", file=sys.stderr, flush=True)


def run(options: argparse.Namespace) -> int:
    listed = listed_meshes(options.catalogue)
    sequences = {number: sequence_of(number, options, list(listed)) for number in options.sequences}
    shapes: dict[str, Shape] = {}
    for name in dict.fromkeys(name for names in sequences.values() for name in names):
        progress(f"convex pieces of {name}")
        shapes[name] = load_shape(*listed[name], options.cache)
    views = [options.view] if options.least_volume_share is None else ["exact", "camera"]
    runs = {view: pack_all(options, view, sequences, shapes) for view in views}
    summaries = {view: summary(of_view) for view, of_view in runs.items()}
    problems = []
    for view, figures in summaries.items():
        print(f"{view}: {figures['items']:.1f} items, {figures['litres']:.2f} l, {100.0 * figures['unsteady_share']:.1f} % unsteady")
        if options.most_unsteady is not None and figures["unsteady_share"] > options.most_unsteady:
            problems.append(f"{view}: {figures['unsteady_share']:.3f} did not stay, and --most-unsteady is {options.most_unsteady:g}")
    if options.least_volume_share is not None:
        share = summaries["camera"]["litres"] / summaries["exact"]["litres"]
        print(f"cameras have {share:.3f} of the volume of exact scans")
        if not share >= options.least_volume_share:
            problems.append(f"cameras have {share:.3f} of the volume, and --least-volume-share is {options.least_volume_share:g}")
    if options.json is not None:
        options.json.write_text(json.dumps({"runs": sum(runs.values(), []), "summaries": summaries, "problems": problems}, indent=1))
    for problem in problems:
        print(f"mujoco_cell: {problem}", file=sys.stderr)
    return 1 if problems else 0


def numbers_of(text: str) -> list[int]:
    parts = [part.partition("-") for part in text.split(",")]
    try:
        return [number for first, _, last in parts for number in range(int(first), int(last or first) + 1)]
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"'{text}' are no numbers; give such as 0-9 or 0,3,7") from error


def read_options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], formatter_class=argparse.ArgumentDefaultsHelpFormatter)
    add = parser.add_argument
    add("--ppnpack", type=pathlib.Path, default=shutil.which("ppnpack"), help="the program; the services are beside it")
    add("--catalogue", type=pathlib.Path, required=True, metavar="FOLDER", help="a folder of meshes")
    add("--view", choices=["exact", "camera"], default="camera", help="what the container is seen by")
    add("--cameras", type=int, choices=[1, 2], default=1, help="how many cameras there are")
    add("--sequences", type=numbers_of, default=[0], metavar="0-9", help="which are packed, a container each")
    add("--sequence-file", type=pathlib.Path, metavar="FILE.npy", help="lines of indices of objects; without it they are random")
    add("--seed", type=int, default=0, help="of random sequences")
    add("--items", type=int, default=80, help="how many items arrive")
    add("--buffer", type=int, default=5, help="how many of them may be chosen from")
    add("--set-aside", type=int, default=20, help="how many may be set aside")
    add("--poses", type=int, default=1, help="in how many resting poses an object may be packed")
    add("--cell", type=float, default=0.0025, help="the edge of a cell of the grid, in metres")
    add("--yaws", type=int, default=16, help="of the grid")
    add("--cloud-period", type=float, default=0.2, help="how often clouds are published, in seconds")
    add("--cache", type=pathlib.Path, default=pathlib.Path.home() / ".cache" / "ppnpack-mujoco", help="where convex pieces are kept")
    add("--check-bridge", action="store_true", help="first hold the bridge with this robot against ppnpack.check_bridge")
    add("--json", type=pathlib.Path, metavar="FILE", help="where the figures are written")
    add("--least-volume-share", type=float, metavar="SHARE", help="pack by both views; fail where cameras have less of the scan's")
    add("--most-unsteady", type=float, metavar="SHARE", help="fail where a greater share of what was placed did not stay")
    options = parser.parse_args()
    missing = [f"ppnpack-{name}" for name in SERVICES if not options.ppnpack or not options.ppnpack.with_name(f"ppnpack-{name}").is_file()]
    if missing:
        raise InputError(f"--ppnpack {options.ppnpack}: {', '.join(missing)} should be beside it; `cargo build --release --bins` makes them")
    return options


def main() -> int:
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # So that the services end, too.
    try:
        return run(read_options())
    except (InputError, ClientError, RuntimeError, OSError, zenoh.ZError) as error:
        print(f"mujoco_cell: {error}", file=sys.stderr)
        return 2 if isinstance(error, InputError) else 1


if __name__ == "__main__":
    sys.exit(main())
