"""A random pile: objects dropped into a frame, the frame lifted, the rest left to come to rest. Cached by hash."""

from __future__ import annotations

import hashlib
import json
import math
import os
import tempfile
from pathlib import Path

import mujoco
import numpy as np

from ..exceptions import PileError
from ..types import Array
from .contact import NATURAL_FREQUENCY, OBJECT_IMPEDANCE, Rule, add_pair, combine, pair_parameters
from .layout import Layout
from .object_kind import ObjectKind
from .scene import add_objects, add_support, new_spec
from .surface import SUPPORT

FRAME_HEIGHT = 0.6
PANEL_HALF_THICKNESS = 0.02
SPACINGS = (2.08, 2.02)
"""Of the grid that objects drop from, over their bounding radius; the second where the first leaves no room."""
LIFT_SPEED = 0.3
PEDESTAL = (0.2, 0.1)
"""Radius and half height of the room that the arm's base takes above the table [m]."""
REST_SPEED = 0.01
"""An object whose centre moves slower than this [m/s] counts as resting."""
REST_TIME = 0.3
"""The pile is settled when all objects have rested for this long [s]."""
TIME_LIMIT = 20.0
"""Of the simulated settling, for each of its two phases [s]."""
CACHE_VERSION = 11


def settle_pile(kind: ObjectKind, count: int, layout: Layout, seed: int, rule: Rule, timestep: float) -> Array:
    """Return the objects' settled poses (count, 7): position [m] and quaternion wxyz.

    The same arguments give the same bits, whether they come from the cache or not.

    Raises:
        PileError: where the objects do not fit into the frame's height or do not come to rest.
    """
    if count == 0:
        return np.zeros((0, 7))
    cache = _cache_file(kind, count, layout, seed, rule, timestep)
    poses = _read_cache(cache, count)
    if poses is None:
        poses = _simulate(kind, count, layout, seed, rule, timestep)
        _write_cache(cache, poses)
    return poses


def pile_model(kind: ObjectKind, count: int, layout: Layout, rule: Rule, timestep: float) -> mujoco.MjModel:
    """Return the compiled frame, supports and objects; the frame is the one mocap body, the objects the only joints."""
    spec = new_spec(timestep)
    supports = add_support(spec, layout)
    panels = [*_add_frame(spec, layout), _add_pedestal(spec)]
    names = add_objects(spec, kind, count, supports, rule)
    side = pair_parameters(combine(kind.surface, SUPPORT, rule), timestep)
    for name in names:
        for panel in panels:
            add_pair(spec, name, panel, side)
    return spec.compile()


def _simulate(kind: ObjectKind, count: int, layout: Layout, seed: int, rule: Rule, timestep: float) -> Array:
    model = pile_model(kind, count, layout, rule, timestep)
    data = mujoco.MjData(model)
    data.qpos[:] = drop_poses(kind, count, layout, np.random.default_rng(seed)).ravel()
    speed_limit = round(TIME_LIMIT / timestep)
    _until_rest(model, data, speed_limit, "inside the frame")
    lift = LIFT_SPEED * timestep
    while data.mocap_pos[0, 2] < FRAME_HEIGHT:
        data.mocap_pos[0, 2] += lift
        mujoco.mj_step(model, data)
    _until_rest(model, data, speed_limit, "after the frame was lifted")
    return data.qpos.reshape(count, 7).copy()


def _until_rest(model: mujoco.MjModel, data: mujoco.MjData, step_limit: int, where: str) -> None:
    resting, wanted = 0, round(REST_TIME / model.opt.timestep)
    for _ in range(step_limit):
        mujoco.mj_step(model, data)
        speed = np.abs(data.qvel.reshape(-1, 6)[:, :3]).max()
        if not np.isfinite(speed):
            break
        resting = resting + 1 if speed < REST_SPEED else 0
        if resting >= wanted:
            return
    raise PileError(
        f"the pile did not come to rest within {TIME_LIMIT:.0f} s {where}; "
        "lower pile.count or sim.timestep, or take another seed"
    )


def _add_frame(spec: mujoco.MjSpec, layout: Layout) -> list[str]:
    """Add the four panels as one body that is moved by hand; their inner faces bound the frame."""
    half, thick = 0.5 * layout.frame_size, PANEL_HALF_THICKNESS
    yaw = layout.frame_yaw
    frame = spec.worldbody.add_body(
        name="frame", mocap=True, pos=[*layout.frame_center, 0.0], quat=[math.cos(yaw / 2), 0, 0, math.sin(yaw / 2)]
    )
    panels = {
        "frame_front": ([-(half + thick), 0.0], [thick, half + 2 * thick]),
        "frame_back": ([half + thick, 0.0], [thick, half + 2 * thick]),
        "frame_left": ([0.0, half + thick], [half, thick]),
        "frame_right": ([0.0, -(half + thick)], [half, thick]),
    }
    for name, (center, size) in panels.items():
        frame.add_geom(
            name=name,
            type=mujoco.mjtGeom.mjGEOM_BOX,
            pos=[*center, FRAME_HEIGHT / 2.0],
            size=[*size, FRAME_HEIGHT / 2.0],
            contype=0,
            conaffinity=0,
        )
    return list(panels)


def _add_pedestal(spec: mujoco.MjSpec) -> str:
    """Add what stands in for the arm's base, so that no stray object comes to rest inside it."""
    radius, half_height = PEDESTAL
    spec.worldbody.add_geom(
        name="pedestal",
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        pos=[0.0, 0.0, half_height],
        size=[radius, half_height, 0.0],
        contype=0,
        conaffinity=0,
    )
    return "pedestal"


def drop_poses(kind: ObjectKind, count: int, layout: Layout, rng: np.random.Generator) -> Array:
    """Return random poses (count, 7) above the frame's floor that do not overlap: a jittered grid, layer on layer.

    The objects of a net are dropped together, upright and side by side; whatever stands alone falls as it likes.
    """
    if kind.net is None:
        return _grid(kind.bounding_radius, count, layout, rng)
    radius = max(kind.net.ring_radius(kind.flank_radius) + kind.flank_radius, kind.bounding_radius)
    if 2.0 * radius > layout.frame_size:
        raise PileError(
            f"{kind.net.members} tied objects need {2000 * radius:.0f} mm side by side and do not fit into the frame "
            f"of {1000 * layout.frame_size:.0f} mm; raise pile.frame_size or lower pile.scale"
        )
    bags = _grid(radius, count // kind.net.members, layout, rng)
    yaw = rng.uniform(-math.pi, math.pi, size=len(bags))
    bags[:, 3:] = np.stack([np.cos(yaw / 2.0), 0.0 * yaw, 0.0 * yaw, np.sin(yaw / 2.0)], axis=-1)
    return kind.net.spread(bags, kind.flank_radius)


def _grid(radius: float, count: int, layout: Layout, rng: np.random.Generator) -> Array:
    """Return random poses (count, 7) of balls of `radius` [m]."""
    for spacing in SPACINGS:
        cell = spacing * radius
        per_side = max(1, int(layout.frame_size // cell))
        layers = math.ceil(count / per_side**2)
        if layers * cell <= FRAME_HEIGHT:
            break
    else:
        raise PileError(
            f"{count} objects need {layers} layers of {1000 * cell:.0f} mm and overflow the frame's height of "
            f"{1000 * FRAME_HEIGHT:.0f} mm; lower pile.count or raise pile.frame_size"
        )
    pitch = layout.frame_size / per_side
    slack = max(0.0, 0.5 * pitch - 1.02 * radius)
    cosine, sine = math.cos(layout.frame_yaw), math.sin(layout.frame_yaw)
    poses = np.zeros((count, 7))
    for layer in range(layers):
        cells = rng.permutation(per_side**2)
        for k in range(per_side**2):
            index = layer * per_side**2 + k
            if index >= count:
                break
            row, column = divmod(int(cells[k]), per_side)
            x = (row + 0.5) * pitch - 0.5 * layout.frame_size + rng.uniform(-slack, slack)
            y = (column + 0.5) * pitch - 0.5 * layout.frame_size + rng.uniform(-slack, slack)
            poses[index, :2] = layout.frame_center + np.array([cosine * x - sine * y, sine * x + cosine * y])
            poses[index, 2] = (layer + 0.5) * cell
            quaternion = rng.normal(size=4)
            poses[index, 3:] = quaternion / np.linalg.norm(quaternion)
    return poses


def _cache_file(kind: ObjectKind, count: int, layout: Layout, seed: int, rule: Rule, timestep: float) -> Path:
    numerics = [OBJECT_IMPEDANCE, NATURAL_FREQUENCY, rule, timestep, mujoco.__version__]
    content = [CACHE_VERSION, numerics, repr(kind), count, seed, repr(layout)]
    digest = hashlib.sha256(json.dumps(content).encode()).hexdigest()[:24]
    return _cache_folder() / "pilegrasp" / "piles" / f"{digest}.npy"


def _cache_folder() -> Path:
    root = Path(os.environ.get("XDG_CACHE_HOME", ""))
    if root.is_absolute():
        return root
    try:
        return Path.home() / ".cache"
    except RuntimeError:  # a user without a home, as in some containers
        return Path(tempfile.gettempdir())


def _read_cache(file: Path, count: int) -> Array | None:
    """Return the cached poses, or None where there are none or the file is damaged (it is then made anew)."""
    try:
        poses = np.load(file, allow_pickle=False)
    except (OSError, ValueError, EOFError):
        return None
    return poses if poses.shape == (count, 7) and np.isfinite(poses).all() else None


def _write_cache(file: Path, poses: Array) -> None:
    """Write through a temporary file, so that a killed process leaves nothing half-written; the cache is optional."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=file.parent, suffix=".npy", delete=False) as temporary:
            np.save(temporary, poses)
        os.replace(temporary.name, file)
    except OSError:
        return
