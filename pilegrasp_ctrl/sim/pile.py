"""A random pile: objects fall into a frame, the frame is lifted, and the objects come to rest. Piles are cached."""

from __future__ import annotations

import math
import platform
import sys
from dataclasses import dataclass

import mujoco
import numpy as np

from ..exceptions import PileError
from ..planning.layout import Layout
from ..provenance import PILE_ROOMS, code_digest, deciding_packages, python_version, version_of
from ..types import Array
from ..vectors import in_order, rotated
from .contact import CONTACT_STEPS, REST_SAG, Rule
from .drop import drop_poses, pile_model
from .objects import Objects
from .pile_cache import PileCache
from .stepper import Stepper

LIFT_SPEED = 0.3
"""Speed at which the frame is lifted [m/s], chosen."""

REST_TIME = 0.3
"""Time over which the motion of a pile is judged [s], chosen."""

MAX_REST_DISPLACEMENT = 3e-3
"""Largest displacement of a centre in `REST_TIME` for a pile at rest [m], chosen."""

MAX_AWAKENINGS = 20
"""Largest number of awakenings before a drop fails [-], chosen."""

MAX_SETTLED_DISPLACEMENT = 3e-4
"""Largest displacement of a centre after an awakening of a settled pile [m], chosen. The check is needed because slow
objects, such as a cube that balances on an edge, fall asleep while they move."""

DRIFT_TIME = 3.0
"""Time for which the drift of an awakened pile is measured [s]: about that of an approach."""

MAX_DRIFT = 1e-3
"""Largest displacement of a centre in `DRIFT_TIME` [m], chosen."""

MAX_DROPS = 6
"""Largest number of drops before the attempt fails [-], chosen. An object that balances or rolls away in one drop
does not in the next."""

TIME_LIMIT = 20.0
"""Simulated time for each of the two phases of settling [s], chosen."""

FRAME_AWAY = 2.0
"""Height at which the lifted frame is out of the way [m], chosen."""

MAX_RESTING_PENETRATION = 1e-3
"""Largest overlap of two bodies in a settled pile [m], chosen; the largest observed overlap was 0.04 mm."""


class ObjectsLeftError(PileError):
    """Objects left the frame while they fell, which they may not do in the next drop."""


@dataclass(frozen=True, slots=True, eq=False)
class Pile:
    """A settled pile.

    Attributes:
        poses: Poses (n, 7) of the objects: position [m] and quaternion wxyz.
        packing_density: Share of the frame's volume that the objects filled before the lift [-]. The volume extends to
            the height of a homogeneous filling with the same centre of mass. The density is 0 without objects, and an
            estimate on a slope.
    """

    poses: Array
    packing_density: float


def settle_pile(objects: Objects, count: int, layout: Layout, seed: int, rule: Rule, timestep: float) -> Pile:
    """Drop the objects, wait, lift the frame, and wait again; repeat the drop if the pile does not stay.

    The first drop is random by `seed`, the others by `seed` and their number. The same arguments give the same bits,
    with and without the cache.

    Raises:
        PileError: The objects do not fit into the frame's height, leave the frame, overlap at rest, or do not stay at
            rest in any of `MAX_DROPS` drops.
    """
    if count == 0:
        return Pile(np.zeros((0, 7)), 0.0)
    numerics = [REST_SAG, CONTACT_STEPS, rule, timestep]
    cache = PileCache(_origin(), numerics, _exactly(objects), count, seed, _exactly(layout))
    cached = cache.read(count)
    if cached is not None:
        return Pile(*cached)
    pile = _simulate(objects, count, layout, seed, rule, timestep)
    cache.write(pile.poses, pile.packing_density)
    return pile


def without_mutual_contacts(pile: Pile, objects: Objects, layout: Layout, rule: Rule, timestep: float) -> Pile:
    """Take the contacts among the objects of a settled pile off, and wait until all lie on the floor.

    What lay on others falls through them, and may bounce and roll on the floor. The attempt begins at rest then.

    Raises:
        PileError: The objects do not come to rest.
    """
    count = len(pile.poses)
    if count == 0:
        return pile
    model = pile_model(objects, count, layout, rule, timestep, mutual=False)
    data = mujoco.MjData(model)
    data.qpos[:] = pile.poses.ravel()
    data.mocap_pos[0, 2] = FRAME_AWAY
    if not _settle(Stepper(model, data), round(TIME_LIMIT / timestep)):
        raise PileError("the objects do not come to rest without contacts among them; take another seed")
    return Pile(data.qpos.reshape(count, 7).copy(), pile.packing_density)


def _origin() -> list[str]:
    """Return what the piles of this installation rest on: Python, packages, and the code up to the simulator."""
    packages = [f"{package} {version_of(package)}" for package in deciding_packages()]
    return [python_version(), platform.machine(), *packages, code_digest(*PILE_ROOMS)]


def _exactly(value: Objects | Layout) -> str:
    """Return the text of a value with every digit of every number; numpy else shows eight, of the outer numbers."""
    with np.printoptions(floatmode="unique", threshold=sys.maxsize):
        return repr(value)


def _simulate(objects: Objects, count: int, layout: Layout, seed: int, rule: Rule, timestep: float) -> Pile:
    for number in range(MAX_DROPS):
        rng = np.random.default_rng([seed, number] if number else seed)
        try:
            pile = _drop(objects, count, layout, rng, rule, timestep)
        except ObjectsLeftError:
            if number + 1 == MAX_DROPS:
                raise
            continue
        if pile is not None:
            return pile
    raise PileError(
        f"the pile did not come to rest, or did not stay at rest, in any of {MAX_DROPS} drops; "
        "lower pile.count or sim.timestep, or take another seed"
    )


def _drop(
    objects: Objects, count: int, layout: Layout, rng: np.random.Generator, rule: Rule, timestep: float
) -> Pile | None:
    """Return the pile after one drop, or None if it does not come to rest or does not stay."""
    model = pile_model(objects, count, layout, rule, timestep)
    data = mujoco.MjData(model)
    stepper = Stepper(model, data)
    data.qpos[:] = drop_poses(objects, count, layout, rng).ravel()
    poses = data.qpos.reshape(count, 7)
    step_limit = round(TIME_LIMIT / timestep)
    if not _settle(stepper, step_limit):
        return None
    _check_inside(poses[:, :2], layout)
    volume = in_order(each.volume for each in objects.assign_models(count))
    density = volume / (layout.frame_size**2 * 2.0 * float(poses[:, 2].mean()))
    lift = LIFT_SPEED * timestep
    while data.mocap_pos[0, 2] < poses[:, 2].max() + objects.bounding_radius:
        data.mocap_pos[0, 2] += lift
        stepper.step()
    if not _settle(stepper, step_limit):
        return None
    for _ in range(MAX_AWAKENINGS):
        before = poses.copy()
        _awaken(model, data)
        if not _settle(stepper, step_limit):
            return None
        settled = poses.copy()
        stays = _largest_displacement(settled, before) < MAX_SETTLED_DISPLACEMENT
        if stays and _measure_drift(stepper) < MAX_DRIFT:
            break
    else:
        return None
    poses[:] = settled
    # Without sleep, because sleeping bodies have no contacts.
    model.opt.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)
    mujoco.mj_forward(model, data)
    deepest = -float(data.contact.dist.min()) if data.ncon else 0.0
    if deepest > MAX_RESTING_PENETRATION:
        raise PileError(f"objects of the settled pile overlap by {1000 * deepest:.1f} mm; take another seed")
    return Pile(settled, density)


def _check_inside(positions: Array, layout: Layout) -> None:
    """Raise if a centre is outside the frame, because a fast or small object can pass a panel within one step."""
    cosine, sine = math.cos(layout.frame_yaw), math.sin(layout.frame_yaw)
    local = rotated([[cosine, sine], [-sine, cosine]], positions - layout.frame_center)
    if outside := int(np.count_nonzero(np.abs(local).max(axis=1) > 0.5 * layout.frame_size)):
        raise ObjectsLeftError(
            f"{outside} of the objects left the frame while they fell; lower sim.timestep or pile.count"
        )


def _awaken(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Start again from the present poses, at rest and awake, like an attempt."""
    poses, frame = data.qpos.copy(), data.mocap_pos.copy()
    mujoco.mj_resetData(model, data)
    data.qpos[:], data.mocap_pos[:] = poses, frame


def _largest_displacement(poses: Array, before: Array) -> float:
    """Return the largest displacement of a centre along an axis [m]."""
    return float(np.abs(poses[:, :3] - before[:, :3]).max())


def _measure_drift(stepper: Stepper) -> float:
    """Step until everything sleeps, but at most for `DRIFT_TIME`; return the largest displacement [m]."""
    data = stepper.data
    before, end = data.qpos.reshape(-1, 7).copy(), data.time + DRIFT_TIME
    while data.ntree_awake and data.time < end:
        stepper.step()
    return _largest_displacement(data.qpos.reshape(-1, 7), before)


def _settle(stepper: Stepper, step_limit: int) -> bool:
    """Step until nothing moves for `REST_TIME`; return whether the pile came to rest within `step_limit` steps.

    The criterion is displacement, not speed, because a jammed object may vibrate for ever without moving away.
    """
    data = stepper.data
    window = round(REST_TIME / stepper.model.opt.timestep)
    for _ in range(step_limit // window):
        before = data.qpos.reshape(-1, 7).copy()
        for _ in range(window):
            stepper.step()
        moved = _largest_displacement(data.qpos.reshape(-1, 7), before)
        if not math.isfinite(moved):
            break
        if moved < MAX_REST_DISPLACEMENT:
            return True
    return False
