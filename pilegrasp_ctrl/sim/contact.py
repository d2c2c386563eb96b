"""From the friction and restitution of two bodies to the parameters of their MuJoCo contact pair."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import mujoco

from .surface import Surface

Rule = Literal["paper", "product", "maximum"]

NATURAL_FREQUENCY = 300.0
"""Of a contact [rad/s]. A bounce lasts pi / 300 = 10 ms: ten steps of 1 ms, which restitution needs to be met."""

OBJECT_IMPEDANCE = 0.8
"""d in MuJoCo's solimp, constant so that the damping ratio alone sets the restitution; and low enough that a resting
ball sags by 20 um into its contact. At 0.99 it sags by 1 um, leaves the contact in every step, and never rests."""

HAND_IMPEDANCE = 0.96
"""The same for the end-effector. A contact is as stiff as its lighter body is heavy, and a fingertip has 5 g: at 0.8 a
push of 20 N would press it 9 mm into the table."""

RESTING_IMPEDANCE = 0.05
IMPEDANCE_WIDTH = 0.002
"""A contact that need not bounce starts soft and reaches its impedance at this depth [m]; a pressed hand then stays in
contact instead of chattering on it."""

LEAST_RESTITUTION = 0.14
"""That of critical damping. More damping would overshoot in a step of 1 ms and make a pressed hand chatter."""


@dataclass(frozen=True, slots=True)
class PairParameters:
    """Fields of an `mjsPair`: `friction` (5,), `solref` (2,) in MuJoCo's direct (negative) format, `solimp` (5,)."""

    friction: tuple[float, float, float, float, float]
    solref: tuple[float, float]
    solimp: tuple[float, float, float, float, float]


def restitution_of(damping_ratio: float) -> float:
    """Return the restitution of a linear spring-damper contact that cannot pull.

    The contact ends when the force, not the penetration, returns to zero (Schwager & Pöschel 2007, eq. 18); MuJoCo
    cuts the force in the same way, so the text-book exp(-pi z / sqrt(1 - z²)) is too low for it.
    """
    if damping_ratio <= 0.0:
        return 1.0
    if damping_ratio < 1.0:
        root = math.sqrt(1.0 - damping_ratio**2)
        angle = math.pi - math.atan2(2.0 * damping_ratio * root, 1.0 - 2.0 * damping_ratio**2)
        return math.exp(-damping_ratio / root * angle)
    if damping_ratio == 1.0:
        return math.exp(-2.0)
    root = math.sqrt(damping_ratio**2 - 1.0)
    return math.exp(-damping_ratio / root * math.log((damping_ratio + root) / (damping_ratio - root)))


def damping_ratio_for(restitution: float) -> float:
    """Return the damping ratio whose `restitution_of` is `restitution`; a perfectly inelastic contact gets 5.

    Raises:
        ValueError: outside [0, 1].
    """
    if not 0.0 <= restitution <= 1.0:
        raise ValueError(f"restitution is {restitution}; it must lie in [0, 1]")
    low, high = 0.0, 5.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        if restitution_of(middle) > restitution:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def combine(a: Surface, b: Surface, rule: Rule) -> Surface:
    """Return the coefficients of the contact between `a` and `b`.

    `paper` takes the numbers as they were measured: the end-effector's own where it takes part, else the object's,
    which were measured against a hard surface. `product` is Bullet's reading (friction and restitution multiply,
    rolling and spinning cross over), `maximum` MuJoCo's. An end-effector on a support never bounces: the touch-down
    is slower than the 0.2 m/s below which Bullet ignores restitution.
    """
    rank = max(a.rank, b.rank)
    if rule == "product":
        combined = Surface(
            a.lateral * b.lateral,
            a.spinning * b.lateral + b.spinning * a.lateral,
            a.rolling * b.lateral + b.rolling * a.lateral,
            a.restitution * b.restitution,
            rank,
        )
    elif rule == "maximum" or a.rank == b.rank:
        combined = Surface(
            max(a.lateral, b.lateral),
            max(a.spinning, b.spinning),
            max(a.rolling, b.rolling),
            max(a.restitution, b.restitution),
            rank,
        )
    else:
        combined = a if a.rank > b.rank else b
    if {a.rank, b.rank} == {0, 2}:
        return Surface(combined.lateral, combined.spinning, combined.rolling, 0.0, rank)
    return combined


def pair_parameters(surface: Surface, natural_frequency: float = NATURAL_FREQUENCY) -> PairParameters:
    """Return MuJoCo's numbers for the coefficients of one contact."""
    damping_ratio = damping_ratio_for(max(surface.restitution, LEAST_RESTITUTION))
    impedance = HAND_IMPEDANCE if surface.rank == 2 else OBJECT_IMPEDANCE
    first = RESTING_IMPEDANCE if surface.restitution == 0.0 else impedance
    return PairParameters(
        friction=(surface.lateral, surface.lateral, surface.spinning, surface.rolling, surface.rolling),
        solref=(-(natural_frequency**2), -2.0 * damping_ratio * natural_frequency),
        solimp=(first, impedance, IMPEDANCE_WIDTH, 0.5, 2.0),
    )


def add_pair(spec: mujoco.MjSpec, geom1: str, geom2: str, parameters: PairParameters, condim: int = 6) -> None:
    """Add an explicit contact pair to `spec`."""
    spec.add_pair(
        geomname1=geom1,
        geomname2=geom2,
        condim=condim,
        friction=parameters.friction,
        solref=parameters.solref,
        solreffriction=(0.0, 0.0),
        solimp=parameters.solimp,
    )
