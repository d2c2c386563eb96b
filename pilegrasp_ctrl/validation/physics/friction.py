"""Friction: the slope at which an object begins to slip, and the deceleration of a rolling object."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import mujoco
import numpy as np

from ...sim.hand import Hand
from ...sim.objects import OBJECT_MODELS
from ...types import Array
from .contact_rig import GRAVITY, ContactRig, Spot, tangent
from .physics_check import PhysicsCheck

SETTLE_TIME, TILT_TIME, SLIP_TIME = 0.5, 1.0, 1.5
"""Times of the rest on the level, of the tilt to `SLIP_MARGIN` below the expected slope, and of the tilt to as much
above [s]; chosen."""

SLIP_MARGIN = math.radians(4.0)
"""Range below and above the expected slope in which the tilt is slow [rad]; chosen."""

SLIP_SPEEDS = (0.03, 0.12)
"""Speeds between which the acceleration of a slipping object is taken [m/s]; chosen above a soft contact's creep."""

SLIP_TOLERANCE, HAND_TOLERANCE = 1.0, 2.0
"""Allowed error of the slope on supports, and on hands [deg]; chosen. On a hand steeper slopes load the leading edge,
and objects slip up to 1.7° early."""

ROLL_SPEED = 0.5
"""Speed at the start of the roll [m/s]; chosen."""

ROLL_WAIT, ROLL_TIME = 0.2, 0.5
"""Time before the deceleration is taken, and time over which it is taken [s]; chosen."""

ROLL_TOLERANCE = 0.05
"""Allowed error of the deceleration as a share of the formula's [-]; chosen."""

ROLLING = (("light_sphere", 2, "hollow ball"), ("heavy_sphere", 2, "solid ball"), ("cylinder", 0, "cylinder"))
"""Object, axis that is normal to the table, and name of each rolling object."""


@dataclass(frozen=True, slots=True, eq=False)
class Roll:
    """A rolling object.

    Attributes:
        times: (n,) Times [s].
        speeds: (n,) Speeds [m/s].
        formula: Deceleration of the formula [m/s²].
    """

    times: Array
    speeds: Array
    formula: float

    @property
    def deceleration(self) -> float:
        """Mean deceleration [m/s²]."""
        return float((self.speeds[0] - self.speeds[-1]) / (self.times[-1] - self.times[0]))


@dataclass(frozen=True, slots=True, eq=False)
class Slip:
    """An object on a growing slope.

    Attributes:
        slopes: (n,) Slopes [rad].
        speeds: (n,) Speeds down the slope [m/s].
    """

    slopes: Array
    speeds: Array

    @property
    def angle(self) -> float:
        """Slope beyond which the object accelerates [rad]; NaN if it does not slip.

        A slipping object is accelerated by g (sin - mu cos) of the slope, and mu follows from the acceleration between
        two speeds. The first motion says nothing, because a soft contact creeps at up to 20 mm/s before it slips.
        """
        fast = np.flatnonzero(self.speeds > SLIP_SPEEDS[1])
        if not fast.size:
            return math.nan
        first = np.flatnonzero(self.speeds[: fast[0]] <= SLIP_SPEEDS[0])[-1] + 1
        slopes, speeds = self.slopes[first : fast[0]], self.speeds[first : fast[0]]
        rate = (self.slopes[-1] - self.slopes[0]) / SLIP_TIME
        slope, acceleration = float(slopes.mean()), rate * float(np.polyfit(slopes, speeds, 1)[0])
        return math.atan(math.tan(slope) - acceleration / (GRAVITY * math.cos(slope)))


def slip(rig: ContactRig, spot: Spot, friction: float) -> Slip:
    """Put the object on a spot and tilt until it slips, slowly near the expected slope atan(friction)."""
    data = rig.place(spot, 0.0)
    down, expected, step = tangent(spot), math.atan(friction), rig.model.opt.timestep
    before, beyond = expected - SLIP_MARGIN, expected + SLIP_MARGIN
    phases = ((SETTLE_TIME, 0.0, 0.0), (TILT_TIME, 0.0, before), (SLIP_TIME, before, beyond))
    for duration, first, last in phases:
        slopes, speeds = np.linspace(first, last, round(duration / step)), []
        for slope in slopes:
            rig.lean(spot, slope)
            mujoco.mj_step(rig.model, data)
            speeds.append(float(data.qvel[:3].dot(down)))
    return Slip(slopes, np.array(speeds))


def roll(rig: ContactRig, axis: int = 2) -> Roll:
    """Let the object roll along the table; the formula is mu_r g / (R (1 + k)), with the inertia k m R²."""
    spot = rig.spots["table"]
    data = rig.place(spot, 0.0, axis)
    radius, rolling = rig.object_model.half_size[0], rig.object_model
    along = tangent(spot)
    # The object's own frame: a cylinder lies with its axis, z, across the motion.
    spin = np.cross(spot.normal, along) * ROLL_SPEED / radius
    data.qvel[:3] = along * ROLL_SPEED
    mujoco.mju_rotVecQuat(data.qvel[3:6], spin, data.qpos[3:7] * [1.0, -1.0, -1.0, -1.0])
    times, speeds = [], []
    for _ in range(round((ROLL_WAIT + ROLL_TIME) / rig.model.opt.timestep)):
        mujoco.mj_step(rig.model, data)
        times.append(data.time)
        speeds.append(float(data.qvel[:3].dot(along)))
    k = rolling.inertia_factor * rolling.solid_inertia()[2] / (rolling.mass * radius**2)
    start = round(ROLL_WAIT / rig.model.opt.timestep)
    formula = rolling.surface.rolling * GRAVITY / (radius * (1.0 + k))
    return Roll(np.array(times[start:]), np.array(speeds[start:]), formula)


def friction_checks() -> Iterator[PhysicsCheck]:
    """Check the slopes at which cubes and cylinders slip on supports, each other and hands; then rolling objects."""
    shovel, soft = Hand.load("shovel"), Hand.load("rbo_hand2")
    for name in ("cube", "cylinder"):
        slipping = OBJECT_MODELS[name]
        for hand, places in ((shovel, ("table", "object", "shovel floor")), (soft, ("palm",))):
            rig = ContactRig.build(slipping, hand)
            for where in places:
                if (name, where) == ("cylinder", "palm"):
                    continue  # A standing cylinder falls over on that slope.
                friction = (slipping.surface if where in ("table", "object") else hand.surface).lateral
                angle = slip(rig, rig.spots[where], friction).angle
                on = f"another {name}" if where == "object" else where
                requested = math.degrees(math.atan(friction))
                tolerance = SLIP_TOLERANCE if where in ("table", "object") else HAND_TOLERANCE
                yield PhysicsCheck(f"slip: {name} on {on}", requested, math.degrees(angle), tolerance, "deg")
    for name, axis, words in ROLLING:
        result = roll(ContactRig.build(OBJECT_MODELS[name], shovel), axis)
        tolerance = ROLL_TOLERANCE * result.formula
        yield PhysicsCheck(f"rolling: {words} slows down", result.formula, result.deceleration, tolerance, "m/s²")
