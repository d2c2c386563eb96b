"""Thickness of a fingertip under load: two wooden rods across the tip are pressed together."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from ...sim.contact import SUPPORT, add_pair
from ...sim.hand import Hand
from ...sim.scene import hand_contact, new_spec
from .hand_bench import FINGER, TIMESTEP

ROD_MASS = 0.1
"""Mass of the rod that moves [kg]; chosen."""

ROD_SIZE = (0.002, 0.015)
"""Radius and half length of a rod [m]; chosen."""

SETTLING = 0.5
"""Time after which a loaded rod is at rest [s]; chosen."""


def thickness(hand: Hand, load: float, finger: str = FINGER) -> float:
    """Return the gap of two rods across the last segment of a finger that are pressed together by `load` [N], in m.

    The rods touch the segment at one point each, like the edge of an object or a tilted table.
    """
    spec = new_spec(TIMESTEP)
    hand.add_to(spec, spec.worldbody.add_site(name="flange"))
    data = mujoco.MjData(hand.model)
    mujoco.mj_kinematics(hand.model, data)
    tip = data.geom(f"{finger}_{hand.parameters['fingers']['segments']}")
    body = hand.model.geom(tip.id).bodyid[0]
    radius, axes = float(hand.model.geom(tip.id).size[0]), data.xmat[body].reshape(3, 3)
    normal, quaternion = axes[:, 2], np.zeros(4)
    # A rod's axis is that of the finger's sideways motion.
    mujoco.mju_mat2Quat(quaternion, np.column_stack([axes[:, 2], axes[:, 0], axes[:, 1]]).ravel())
    for side, name in ((-1.0, "below"), (1.0, "above")):
        middle = tip.xpos + side * (radius + ROD_SIZE[0]) * normal
        rod = spec.worldbody.add_body(name=name, pos=middle, quat=quaternion)
        rod.add_geom(
            name=name,
            type=mujoco.mjtGeom.mjGEOM_CAPSULE,
            size=[*ROD_SIZE, 0.0],
            mass=ROD_MASS,
            contype=0,
            conaffinity=0,
        )
        if side > 0.0:
            rod.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[1.0, 0.0, 0.0])
        inverse_mass = 1.0 / ROD_MASS if side > 0.0 else 0.0
        add_pair(spec, tip.name, name, hand_contact(spec, hand, tip.name, SUPPORT, inverse_mass, "paper"), condim=3)
    model = spec.compile()
    model.opt.gravity[:] = 0.0
    model.opt.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)
    state = mujoco.MjData(model)
    state.xfrc_applied[model.body("above").id, :3] = -load * normal
    mujoco.mj_step(model, state, round(SETTLING / TIMESTEP))
    return 2.0 * radius + float(state.joint("above").qpos[0])


def meeting_slope(thick: float, radius: float) -> float:
    """Return the slope above the horizontal at which a tip on the table touches a lying ball or cylinder [rad].

    At a steep slope, a tip of the thickness `thick` [m] lifts what it meets. At a flat slope it jams it against what
    lies behind.
    """
    return math.asin((radius - 0.5 * thick) / (radius + 0.5 * thick))
