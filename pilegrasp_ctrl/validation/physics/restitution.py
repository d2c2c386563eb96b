"""Restitution: objects dropped on table, wall, each other and hand, over the phases at which an impact meets a step."""

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
"""Of the drops [m]."""
PHASES = 8
"""Impacts, evenly over the part of a step at which an object touches."""
TOLERANCE = 0.03
SOFT_TOLERANCE = 0.06
"""Below 0.3, where a contact that is damped nearly critically decides within two steps whether it is left at all."""
SWEEP = (0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)
SHOVEL = ("shovel floor", "shovel back")
SWEPT = (("table", "shovel"), ("wall", "shovel"), ("shovel floor", "shovel"), ("palm", "rbo_hand2"))
LONGEST_CONTACT = 0.1
BOUNCING = ("light_sphere", "heavy_sphere", "cylinder", "cube", "apple", "lime")


@dataclass(frozen=True, slots=True, eq=False)
class Drops:
    """Restitutions `values` (heights, phases) of an object on a spot, and the `requested` one of their contact."""

    requested: float
    values: Array

    @property
    def worst_mean(self) -> float:
        """Mean over the phases, at the height where it is farthest from the requested."""
        means = self.values.mean(axis=1)
        return float(means[np.abs(means - self.requested).argmax()])

    @property
    def worst(self) -> float:
        """The single drop that is farthest from the requested."""
        flat = self.values.ravel()
        return float(flat[np.abs(flat - self.requested).argmax()])


def rebound(rig: ContactRig, spot: Spot, height: float, axis: int = 2) -> float:
    """Drop the object and return the speed at which it leaves the surface over that at which it came.

    Both are taken beside the contact and carried to the surface by the conservation of energy.
    """
    data = rig.place(spot, height, axis)
    position, velocity = data.qpos[:3], data.qvel[:3]
    surface = position.dot(spot.normal) - height
    came = 0.0
    while (gap := position.dot(spot.normal) - surface) > 0.0:
        came = math.sqrt(velocity.dot(spot.normal) ** 2 + 2.0 * GRAVITY * gap)
        mujoco.mj_step(rig.model, data)
    patience = data.time + LONGEST_CONTACT
    while (gap := position.dot(spot.normal) - surface) < 0.0:
        if data.time > patience:
            return 0.0
        mujoco.mj_step(rig.model, data)
    return math.sqrt(max(velocity.dot(spot.normal), 0.0) ** 2 + 2.0 * GRAVITY * gap) / came


def drops(rig: ContactRig, where: str, axis: int = 2) -> Drops:
    """Drop the object from every height at every phase."""
    spot = rig.spots[where]
    surface = rig.kind.surface if where in ("table", "wall", "object") else rig.hand.surface
    values = [[rebound(rig, spot, h + phase, axis) for phase in _phases(rig, h)] for h in HEIGHTS]
    return Drops(surface.restitution, np.array(values))


def _phases(rig: ContactRig, height: float) -> Array:
    """Return differences of height [m] over which the impact moves through one step."""
    step = rig.model.opt.timestep * math.sqrt(2.0 * GRAVITY * height)
    return np.arange(PHASES) * step / PHASES


def sweep(hand_name: str, where: str, timestep: float = SHIPPED_STEP) -> list[Drops]:
    """Return the drops of a light sphere whose contact, or whose hand, is asked for each restitution of `SWEEP`."""
    hand, ball = Hand.load(hand_name), OBJECT_MODELS["light_sphere"]
    return [
        drops(ContactRig.build(bouncing(ball, asked), bouncing_hand(hand, asked), timestep), where) for asked in SWEEP
    ]


def restitution_checks() -> Iterator[PhysicsCheck]:
    """Check every object that bounces on supports, on another of its kind and on both hands; then the whole range.

    Where several surfaces ask for the same restitution, the one that is missed by most is stated.
    """
    hands = {name: Hand.load(name) for name in ("shovel", "rbo_hand2")}
    for name in BOUNCING:
        stages = {hand: ContactRig.build(OBJECT_MODELS[name], hands[hand]) for hand in hands}
        words = name.replace("_", " ")
        on_supports = [drops(stages["shovel"], where) for where in ("table", "wall", "object")]
        yield _check(f"restitution: {words} on table, wall and another", on_supports)
        if OBJECT_MODELS[name].shape == "cylinder":
            yield _check(f"restitution: {words} on its side on table", [drops(stages["shovel"], "table", 0)])
        yield _check(f"restitution: {words} on shovel", [drops(stages["shovel"], where) for where in SHOVEL])
        yield _check(f"restitution: {words} on palm of rbo hand2", [drops(stages["rbo_hand2"], "palm")])
    yield _check("restitution: light sphere on finger of rbo hand2", [drops(_ball_and_hand(hands), "finger")])
    swept = [sweep(hand, where) for where, hand in SWEPT]
    for results in zip(*swept, strict=True):
        yield _check(f"restitution: {results[0].requested:g} on table, wall, shovel and palm", results)


def _ball_and_hand(hands: dict[str, Hand]) -> ContactRig:
    return ContactRig.build(OBJECT_MODELS["light_sphere"], hands["rbo_hand2"])


def _check(name: str, results: Sequence[Drops]) -> PhysicsCheck:
    """State the mean over the phases, at the surface and the height where it is farthest from the requested."""
    farthest = max(results, key=lambda result: abs(result.worst_mean - result.requested))
    return PhysicsCheck(name, farthest.requested, farthest.worst_mean, _tolerance(farthest.requested), "-")


def _tolerance(requested: float) -> float:
    return TOLERANCE if requested >= SWEEP[0] else SOFT_TOLERANCE
