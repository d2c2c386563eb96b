"""From the friction and restitution of two bodies to the parameters of their MuJoCo contact pair."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import mujoco

from .bounce import damping_ratio_for
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

SLIP_TIME = 1.0
"""On a slope the friction among objects takes slip away in this many steps. MuJoCo's friction yields like a damper, and
takes the contact's own unless told otherwise: that of a ball that bounces is so weak that a heap of them which leans on
the low wall flows at 2 to 15 mm/s and never falls asleep. On the level nothing pulls."""

RESTING_IMPEDANCE = 0.05
IMPEDANCE_WIDTH = 0.002
"""A contact that need not bounce starts soft and reaches its impedance at this depth [m]; a pressed hand then stays in
contact instead of chattering on it."""


@dataclass(frozen=True, slots=True)
class PairParameters:
    """Fields of an `mjsPair`.

    `friction` (5,), `solref` (2,) in MuJoCo's direct (negative) format, `solimp` (5,), and `solreffriction` (2,), of
    which zeros stand for `solref`.
    """

    friction: tuple[float, float, float, float, float]
    solref: tuple[float, float]
    solimp: tuple[float, float, float, float, float]
    solreffriction: tuple[float, float] = (0.0, 0.0)


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


@lru_cache(maxsize=256)
def pair_parameters(surface: Surface, timestep: float, slope: bool = False) -> PairParameters:
    """Return MuJoCo's numbers for the coefficients of one contact, at a step of the physics [s].

    With `slope` the friction of what is no end-effector holds a load that stands, see `SLIP_TIME`.
    """
    damping_ratio = damping_ratio_for(surface.restitution, NATURAL_FREQUENCY * timestep)
    impedance = HAND_IMPEDANCE if surface.rank == 2 else OBJECT_IMPEDANCE
    first = RESTING_IMPEDANCE if surface.restitution == 0.0 else impedance
    holds = slope and surface.rank < 2
    return PairParameters(
        friction=(surface.lateral, surface.lateral, surface.spinning, surface.rolling, surface.rolling),
        solref=(-(NATURAL_FREQUENCY**2), -2.0 * damping_ratio * NATURAL_FREQUENCY),
        solimp=(first, impedance, IMPEDANCE_WIDTH, 0.5, 2.0),
        solreffriction=(-(NATURAL_FREQUENCY**2), -1.0 / (SLIP_TIME * timestep)) if holds else (0.0, 0.0),
    )


def add_pair(spec: mujoco.MjSpec, geom1: str, geom2: str, parameters: PairParameters, condim: int = 6) -> None:
    """Add an explicit contact pair to `spec`."""
    spec.add_pair(
        geomname1=geom1,
        geomname2=geom2,
        condim=condim,
        friction=parameters.friction,
        solref=parameters.solref,
        solreffriction=parameters.solreffriction,
        solimp=parameters.solimp,
    )
