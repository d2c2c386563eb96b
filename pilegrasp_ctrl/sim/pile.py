"""A random pile: objects dropped into a frame, the frame lifted, the rest left to come to rest. Cached by hash."""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco
import numpy as np

from ..exceptions import PileError
from ..planning.layout import BASE_RADIUS, Layout
from ..types import Array
from .backend import Stepper
from .contact import NATURAL_FREQUENCY, OBJECT_IMPEDANCE, SUPPORT, Rule, add_pair
from .drop import FRAME_HEIGHT, drop_poses
from .objects import Objects
from .pile_cache import PileCache
from .scene import add_objects, add_support, contact, new_spec

PANEL_HALF_THICKNESS = 0.02
LIFT_SPEED = 0.3
PEDESTAL = (BASE_RADIUS, 0.1)
"""Radius and half height of the room that the arm's base takes above the table [m]."""
REST_TIME = 0.3
MAX_REST_DISPLACEMENT = 3e-3
"""The pile has come to rest when no centre has moved by more than this [m] in `REST_TIME` [s]."""
AWAKENINGS = 20
STAYS = 3e-4
"""It is settled when it stays within this distance [m] once it is awakened: what moves slowly, such as a cube that
balances on an edge, falls asleep on its way."""
DRIFT_TIME, DRIFTS = 3.0, 1e-3
"""Nor may it have gone farther than this [m] after this time [s], about what an approach takes, if it is awake."""
MAX_DROPS = 6
"""So many times a pile is dropped before it is given up: what is on the brink, or rolls away, in one fall does not in
the next."""
TIME_LIMIT = 20.0
"""Of the simulated settling, for each of its two phases [s]."""
MAX_PENETRATION = 1e-3
"""Two bodies of a settled pile overlap by less than this [m]; 0.04 mm was the most that we saw."""
CACHE_VERSION = 18


@dataclass(frozen=True, slots=True, eq=False)
class Pile:
    """A settled pile.

    Attributes:
        poses: (n, 7) of the objects: position [m] and quaternion wxyz.
        packing_density: share of the frame's volume that the objects filled before it was lifted [-], up to the height
            of a homogeneous filling with the same centre of mass; 0 for no objects. Under a slope it is an estimate.
    """

    poses: Array
    packing_density: float


def settle_pile(kind: Objects, count: int, layout: Layout, seed: int, rule: Rule, timestep: float) -> Pile:
    """Drop, wait, lift the frame, and wait again; and all over again where the pile does not stay.

    The first fall is random by `seed`, the others by `seed` and their number. The same arguments give the same bits,
    whether they come from the cache or not.

    Raises:
        PileError: where the objects do not fit into the frame's height, leave the frame, do not come to rest,
            overlap when they do, or do not stay in any of `MAX_DROPS` falls.
    """
    if count == 0:
        return Pile(np.zeros((0, 7)), 0.0)
    numerics = [OBJECT_IMPEDANCE, NATURAL_FREQUENCY, rule, timestep, mujoco.__version__]
    cache = PileCache(CACHE_VERSION, numerics, repr(kind), count, seed, repr(layout))
    cached = cache.read(count)
    if cached is not None:
        return Pile(*cached)
    pile = _simulate(kind, count, layout, seed, rule, timestep)
    cache.write(pile.poses, pile.packing_density)
    return pile


def pile_model(kind: Objects, count: int, layout: Layout, rule: Rule, timestep: float) -> mujoco.MjModel:
    """Return the compiled frame, supports and objects; the frame is the one mocap body, the objects the only joints."""
    spec = new_spec(timestep)
    supports = add_support(spec, layout)
    panels = [*_add_frame(spec, layout), _add_pedestal(spec)]
    names = add_objects(spec, kind, count, supports, rule)
    for name, each in zip(names, kind.share_out(count), strict=True):
        for panel in panels:
            add_pair(spec, name, panel, contact(spec, each.surface, SUPPORT, rule))
    return spec.compile()


def _simulate(kind: Objects, count: int, layout: Layout, seed: int, rule: Rule, timestep: float) -> Pile:
    for fall in range(MAX_DROPS):
        rng = np.random.default_rng([seed, fall] if fall else seed)
        pile = _drop(kind, count, layout, rng, rule, timestep)
        if pile is not None:
            return pile
    raise PileError(
        f"the pile did not come to rest, or did not stay where it had, in any of {MAX_DROPS} falls; "
        "lower pile.count or sim.timestep, or take another seed"
    )


def _drop(
    kind: Objects, count: int, layout: Layout, rng: np.random.Generator, rule: Rule, timestep: float
) -> Pile | None:
    """Return the pile that one fall ends in, or None where it does not come to rest or does not stay."""
    model = pile_model(kind, count, layout, rule, timestep)
    data = mujoco.MjData(model)
    stepper = Stepper(model, data)
    data.qpos[:] = drop_poses(kind, count, layout, rng).ravel()
    poses = data.qpos.reshape(count, 7)
    step_limit = round(TIME_LIMIT / timestep)
    if not _comes_to_rest(stepper, data, step_limit):
        return None
    _stayed_inside(poses[:, :2], layout)
    volume = sum(each.volume for each in kind.share_out(count))
    density = volume / (layout.frame_size**2 * 2.0 * float(poses[:, 2].mean()))
    lift = LIFT_SPEED * timestep
    while data.mocap_pos[0, 2] < poses[:, 2].max() + kind.bounding_radius:
        data.mocap_pos[0, 2] += lift
        stepper.step()
    if not _comes_to_rest(stepper, data, step_limit):
        return None
    for _ in range(AWAKENINGS):
        before = poses.copy()
        _awaken(model, data)
        if not _comes_to_rest(stepper, data, step_limit):
            return None
        settled = poses.copy()
        if _distance(settled, before) < STAYS and _drift(stepper, data) < DRIFTS:
            break
    else:
        return None
    poses[:] = settled
    # What sleeps has no contacts.
    model.opt.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)
    mujoco.mj_forward(model, data)
    deepest = -float(data.contact.dist.min()) if data.ncon else 0.0
    if deepest > MAX_PENETRATION:
        raise PileError(f"objects of the settled pile overlap by {1000 * deepest:.1f} mm; take another seed")
    return Pile(settled, density)


def _stayed_inside(positions: Array, layout: Layout) -> None:
    """Raise where a centre lies outside the frame: something so fast or so small that it passed a panel in a step."""
    cosine, sine = math.cos(layout.frame_yaw), math.sin(layout.frame_yaw)
    local = (positions - layout.frame_center) @ np.array([[cosine, -sine], [sine, cosine]])
    if outside := int(np.count_nonzero(np.abs(local).max(axis=1) > 0.5 * layout.frame_size)):
        raise PileError(
            f"{outside} of the objects got out of the frame while they fell; lower sim.timestep or pile.count"
        )


def _awaken(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Start again from the present poses, at rest and wide awake, as an attempt does."""
    poses, frame = data.qpos.copy(), data.mocap_pos.copy()
    mujoco.mj_resetData(model, data)
    data.qpos[:], data.mocap_pos[:] = poses, frame


def _distance(poses: Array, before: Array) -> float:
    """Return how far the centre that has moved most has moved along an axis [m]."""
    return float(np.abs(poses[:, :3] - before[:, :3]).max())


def _drift(stepper: Stepper, data: mujoco.MjData) -> float:
    """Go on until everything is asleep, `DRIFT_TIME` at most; return the distance gone [m]."""
    before, end = data.qpos.reshape(-1, 7).copy(), data.time + DRIFT_TIME
    while data.ntree_awake and data.time < end:
        stepper.step()
    return _distance(data.qpos.reshape(-1, 7), before)


def _comes_to_rest(stepper: Stepper, data: mujoco.MjData, step_limit: int) -> bool:
    """Go on until nothing moves in a while: a jammed object may tremble for ever, and does not go anywhere."""
    window = round(REST_TIME / data.model.opt.timestep)
    for _ in range(step_limit // window):
        before = data.qpos.reshape(-1, 7).copy()
        for _ in range(window):
            stepper.step()
        moved = _distance(data.qpos.reshape(-1, 7), before)
        if not math.isfinite(moved):
            break
        if moved < MAX_REST_DISPLACEMENT:
            return True
    return False


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
