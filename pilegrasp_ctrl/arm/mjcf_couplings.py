"""What couples the joints of a MuJoCo model beyond its tree of bodies: equality constraints and tendons."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from ..exceptions import ModelError


def enum_values(kind: str, *names: str) -> list[int]:
    """Return the numbers that stand in a compiled model for members of one of MuJoCo's enumerations."""
    import mujoco

    return [int(getattr(getattr(mujoco, kind), name)) for name in names]


def movers_of(mj: Any, body: int) -> list[int]:
    """Return the joints that move a body, from the world to the body."""
    movers: list[int] = []
    while body > 0:
        first = int(mj.body_jntadr[body])
        movers[:0] = range(first, first + int(mj.body_jntnum[body]))
        body = int(mj.body_parentid[body])
    return movers


def followers_in(mj: Any) -> dict[int, int]:
    """Return the joints that an equality lets follow another joint, and that joint; -1 for one that is held still."""
    joints = enum_values("mjtEq", "mjEQ_JOINT")
    return {int(mj.eq_obj1id[i]): int(mj.eq_obj2id[i]) for i in _active(mj) if mj.eq_type[i] in joints}


def _active(mj: Any) -> list[int]:
    """Return the equality constraints that hold."""
    none = mj.opt.disableflags & enum_values("mjtDisableBit", "mjDSBL_EQUALITY")[0]
    return [] if none else [i for i in range(mj.neq) if mj.eq_active0[i]]


def check_couplings(mj: Any, kept: set[int], names: list[str], arm: str) -> None:
    """Refuse couplings of the joints that are kept. A weld to a mocap body is not the arm's, and is left out.

    Raises:
        ModelError: A joint that is kept follows another one, is part of a closed loop, or carries a tendon that acts.
    """
    for joint, leader in followers_in(mj).items():
        if joint in kept:
            what = f"follows {names[leader]!r}" if leader >= 0 else "is held still"
            raise ModelError(f"{arm}: joint {names[joint]!r} {what} (equality of joints); add it to locked_joints")
    for index in _active(mj):
        joints = sorted(_closed_by(mj, index) & kept)
        if joints:
            raise ModelError(
                f"{arm}: joint {names[joints[0]]!r} is part of a closed loop (equality {_name(mj.eq(index), index)}), "
                "which an arm cannot have; lock the joints of the loop"
            )
    for index in range(mj.ntendon):
        joints = sorted(_moving(mj, index) & kept) if _acts(mj, index) else []
        if joints:
            raise ModelError(
                f"{arm}: joint {names[joints[0]]!r} carries the tendon {_name(mj.tendon(index), index)} with a spring, "
                "friction, inertia or limit, which an arm's model does not have; lock the joint or take the tendon out"
            )


def _name(thing: Any, index: int) -> str:
    return repr(thing.name) if thing.name else str(index)


def _closed_by(mj: Any, index: int) -> set[int]:
    """Return the joints whose motion a constraint between two bodies, or of tendons, restrains."""
    kind, ends = mj.eq_type[index], [int(mj.eq_obj1id[index]), int(mj.eq_obj2id[index])]
    if kind in enum_values("mjtEq", "mjEQ_TENDON"):
        return set().union(*(_moving(mj, tendon) for tendon in ends if tendon >= 0))
    if kind not in enum_values("mjtEq", "mjEQ_CONNECT", "mjEQ_WELD"):
        return set()
    if mj.eq_objtype[index] in enum_values("mjtObj", "mjOBJ_SITE"):
        ends = [int(mj.site_bodyid[site]) for site in ends]
    if any(mj.body_mocapid[mj.body_rootid[body]] >= 0 for body in ends):
        return set()
    return _between(mj, ends)


def _between(mj: Any, bodies: Iterable[int]) -> set[int]:
    """Return the joints that move some of the bodies against others."""
    movers = [set(movers_of(mj, body)) for body in bodies]
    common = set.intersection(*movers) if movers else set()
    return set().union(*movers) - common


def _moving(mj: Any, tendon: int) -> set[int]:
    """Return the joints that change the length of a tendon."""
    turned, passed = enum_values("mjtWrap", "mjWRAP_JOINT", "mjWRAP_SITE")
    first = int(mj.tendon_adr[tendon])
    parts = range(first, first + int(mj.tendon_num[tendon]))
    joints = {int(mj.wrap_objid[i]) for i in parts if mj.wrap_type[i] == turned}
    sites = [int(mj.wrap_objid[i]) for i in parts if mj.wrap_type[i] == passed]
    return joints | _between(mj, [int(mj.site_bodyid[site]) for site in sites])


def _acts(mj: Any, tendon: int) -> bool:
    """Return whether a tendon does something beyond what actuators do through it."""
    numbers = (mj.tendon_stiffness, mj.tendon_stiffnesspoly, mj.tendon_damping, mj.tendon_dampingpoly)
    more = (mj.tendon_frictionloss, mj.tendon_armature, mj.tendon_limited)
    return any(bool(np.any(value[tendon])) for value in numbers + more)
