"""Friction: the slope at which an object begins to slip, and how fast a rolling one slows down."""

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
"""At rest on the level, tilting to `SLIP_MARGIN` below the expected slope, and on to as much above it [s]."""
SLIP_MARGIN = math.radians(4.0)
SLIP_SPEEDS = (0.03, 0.12)
"""Between which the acceleration of what slips is taken [m/s]."""
SLIP_TOLERANCE, HAND_TOLERANCE = 1.0, 2.0
"""The second on a hand, where steeper slopes load the leading edge, and what slips does so up to 1.7° early [deg]."""
ROLL_SPEED = 0.5
ROLL_WAIT, ROLL_TIME = 0.2, 0.5
ROLL_TOLERANCE = 0.05
ROLLING = (("light_sphere", 2, "hollow ball"), ("heavy_sphere", 2, "solid ball"), ("cylinder", 0, "cylinder"))


@dataclass(frozen=True, slots=True, eq=False)
class Roll:
    """A rolling object: `times` (n,) [s], `speeds` (n,) [m/s], and the deceleration [m/s²] of the formula."""

    times: Array
    speeds: Array
    formula: float

    @property
    def deceleration(self) -> float:
        """Mean deceleration [m/s²]."""
        return float((self.speeds[0] - self.speeds[-1]) / (self.times[-1] - self.times[0]))


@dataclass(frozen=True, slots=True, eq=False)
class Slip:
    """An object on a slope that grows: `slopes` (n,) [rad] and `speeds` (n,) [m/s] down it."""

    slopes: Array
    speeds: Array

    @property
    def angle(self) -> float:
        """Slope beyond which the object is accelerated [rad]; NaN where it does not slip.

        What slips is accelerated by g (sin - mu cos) of the slope; a soft contact also creeps at up to 20 mm/s before,
        so that the first motion says nothing. mu follows from the acceleration between two speeds.
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
    """Lay the object on a spot and tilt until it slips, slowly where atan(friction) says that it should."""
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
    """Let the object roll along the table, and compare with mu_r g / (R (1 + k)), where its inertia is k m R²."""
    spot = rig.spots["table"]
    data = rig.place(spot, 0.0, axis)
    radius, kind = rig.kind.half_size[0], rig.kind
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
    k = kind.inertia_factor * kind.solid_inertia()[2] / (kind.mass * radius**2)
    start = round(ROLL_WAIT / rig.model.opt.timestep)
    formula = kind.surface.rolling * GRAVITY / (radius * (1.0 + k))
    return Roll(np.array(times[start:]), np.array(speeds[start:]), formula)


def friction_checks() -> Iterator[PhysicsCheck]:
    """Check the slopes at which cubes and cylinders slip on supports, each other and hands; then what rolls."""
    shovel, soft = Hand.load("shovel"), Hand.load("rbo_hand2")
    for name in ("cube", "cylinder"):
        kind = OBJECT_MODELS[name]
        for hand, places in ((shovel, ("table", "object", "shovel floor")), (soft, ("palm",))):
            rig = ContactRig.build(kind, hand)
            for where in places:
                if (name, where) == ("cylinder", "palm"):
                    continue  # on that slope a standing cylinder falls over
                friction = (kind.surface if where in ("table", "object") else hand.surface).lateral
                angle = slip(rig, rig.spots[where], friction).angle
                on = f"another {name}" if where == "object" else where
                asked = math.degrees(math.atan(friction))
                tolerance = SLIP_TOLERANCE if where in ("table", "object") else HAND_TOLERANCE
                yield PhysicsCheck(f"slip: {name} on {on}", asked, math.degrees(angle), tolerance, "deg")
    for name, axis, words in ROLLING:
        result = roll(ContactRig.build(OBJECT_MODELS[name], shovel), axis)
        tolerance = ROLL_TOLERANCE * result.formula
        yield PhysicsCheck(f"rolling: {words} slows down", result.formula, result.deceleration, tolerance, "m/s²")
