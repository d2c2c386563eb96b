"""Restitution: objects are dropped on table, wall, each other and hand, at every phase of an impact within a step."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from ...sim.hand import Hand
from ...sim.objects import OBJECT_MODELS
from ...types import Array
from .contact_rig import GRAVITY, SHIPPED_STEP, ContactRig, Spot, bouncing, bouncing_hand
from .physics_check import PhysicsCheck

HEIGHTS = (0.1, 0.3, 0.5)
"""Heights of the drops [m]; chosen."""
PHASES = 8
"""Impacts at each height [-], spread evenly over the part of a step at which an object touches; chosen."""
TOLERANCE = 0.03
"""Allowed error of a restitution of 0.3 or more [-]; chosen."""

SOFT_TOLERANCE = 0.06
"""Allowed error of a restitution below 0.3 [-]; chosen. There the contact is damped nearly critically, and two steps
decide whether the object leaves it at all."""

SWEEP = (0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)
"""Restitutions that are requested one after the other [-]; 0.3 is the least that contacts are calibrated for."""

SHOVEL = ("shovel floor", "shovel back")
"""Spots of the shovel."""

SWEPT = (("table", "shovel"), ("wall", "shovel"), ("shovel floor", "shovel"), ("palm", "rbo_hand2"))
"""Spot and hand of every sweep over restitutions."""

MAX_FALL_TIME = 1.0
"""Time after which an object does not reach the surface any more [s]; chosen above a fall of 0.5 m, 0.32 s."""

MAX_CONTACT_TIME = 0.1
"""Time after which an object that has not left the surface counts as at rest [s]; chosen."""

BOUNCING = ("light_sphere", "heavy_sphere", "cylinder", "cube", "apple", "lime")
"""Objects that are dropped."""


@dataclass(frozen=True, slots=True, eq=False)
class Drops:
    """Restitutions of an object on a spot.

    Attributes:
        requested: Restitution in the contact's parameters [-].
        values: (heights, phases) Measured restitutions [-].
    """

    requested: float
    values: Array

    @property
    def worst_mean(self) -> float:
        """Mean over the phases, at the height with the largest error."""
        means = self.values.mean(axis=1)
        return float(means[np.abs(means - self.requested).argmax()])


def rebound(rig: ContactRig, spot: Spot, height: float, axis: int = 2) -> float:
    """Drop the object and return the speed at which it leaves the surface over the speed at which it came.

    Both speeds are taken outside the contact and carried to the surface by conservation of energy. An object that is
    caught on its way gives NaN.
    """
    data = rig.place(spot, height, axis)
    position, velocity = data.qpos[:3], data.qvel[:3]
    surface = position.dot(spot.normal) - height
    impact_speed = 0.0
    while (gap := position.dot(spot.normal) - surface) > 0.0:
        if data.time > MAX_FALL_TIME:
            return math.nan
        impact_speed = math.sqrt(velocity.dot(spot.normal) ** 2 + 2.0 * GRAVITY * gap)
        mujoco.mj_step(rig.model, data)
    deadline = data.time + MAX_CONTACT_TIME
    while (gap := position.dot(spot.normal) - surface) < 0.0:
        if data.time > deadline:
            return 0.0
        mujoco.mj_step(rig.model, data)
    return math.sqrt(max(velocity.dot(spot.normal), 0.0) ** 2 + 2.0 * GRAVITY * gap) / impact_speed


def drops(rig: ContactRig, where: str, axis: int = 2) -> Drops:
    """Drop the object from every height at every phase."""
    spot = rig.spots[where]
    surface = rig.object_model.surface if where in ("table", "wall", "object") else rig.hand.surface
    values = [[rebound(rig, spot, h + phase, axis) for phase in _phases(rig, h)] for h in HEIGHTS]
    return Drops(surface.restitution, np.array(values))


def _phases(rig: ContactRig, height: float) -> Array:
    """Return the additional heights [m] that move the impact through one step."""
    step = rig.model.opt.timestep * math.sqrt(2.0 * GRAVITY * height)
    return np.arange(PHASES) * step / PHASES


def sweep(hand_name: str, where: str, timestep: float = SHIPPED_STEP) -> list[Drops]:
    """Return the drops of a light sphere for each restitution of `SWEEP`, requested of its surface and of the hand."""
    hand, ball = Hand.load(hand_name), OBJECT_MODELS["light_sphere"]
    return [
        drops(ContactRig.build(bouncing(ball, requested), bouncing_hand(hand, requested), timestep), where)
        for requested in SWEEP
    ]


def restitution_checks() -> Iterator[PhysicsCheck]:
    """Check every object on supports, on another object and on both hands; then the whole range of restitutions.

    If several surfaces request the same restitution, the check reports the one with the largest error.
    """
    hands = {name: Hand.load(name) for name in ("shovel", "rbo_hand2")}
    for name in BOUNCING:
        rigs = {hand: ContactRig.build(OBJECT_MODELS[name], hands[hand]) for hand in hands}
        words = name.replace("_", " ")
        on_supports = [drops(rigs["shovel"], where) for where in ("table", "wall", "object")]
        yield _check(f"restitution: {words} on table, wall and another", on_supports)
        if OBJECT_MODELS[name].shape == "cylinder":
            yield _check(f"restitution: {words} on its side on table", [drops(rigs["shovel"], "table", 0)])
        yield _check(f"restitution: {words} on shovel", [drops(rigs["shovel"], where) for where in SHOVEL])
        yield _check(f"restitution: {words} on palm of rbo hand2", [drops(rigs["rbo_hand2"], "palm")])
    finger = ContactRig.build(OBJECT_MODELS["light_sphere"], hands["rbo_hand2"])
    yield _check("restitution: light sphere on finger of rbo hand2", [drops(finger, "finger")])
    swept = [sweep(hand, where) for where, hand in SWEPT]
    for results in zip(*swept, strict=True):
        yield _check(f"restitution: {results[0].requested:g} on table, wall, shovel and palm", results)


def step_halving_checks() -> Iterator[PhysicsCheck]:
    """Check that half the step gives the same restitution: the requested number is that of the half step."""
    hand = Hand.load("shovel")
    for name in ("light_sphere", "heavy_sphere", "cube"):
        half, shipped = (
            drops(ContactRig.build(OBJECT_MODELS[name], hand, step), "table")
            for step in (0.5 * SHIPPED_STEP, SHIPPED_STEP)
        )
        words = f"half step: restitution of {name.replace('_', ' ')} on table"
        yield PhysicsCheck(words, float(half.values.mean()), float(shipped.values.mean()), TOLERANCE, "-")


def _check(name: str, results: Sequence[Drops]) -> PhysicsCheck:
    """Return the mean over the phases, at the surface and the height with the largest error."""
    farthest = max(results, key=lambda result: abs(result.worst_mean - result.requested))
    return PhysicsCheck(name, farthest.requested, farthest.worst_mean, _tolerance(farthest.requested), "-")


def _tolerance(requested: float) -> float:
    return TOLERANCE if requested >= SWEEP[0] else SOFT_TOLERANCE
