"""Contacts: friction and restitution of two bodies, and the MuJoCo contact pair that reproduces them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal

import mujoco
import numpy as np

from ..exceptions import ArgumentError

END_EFFECTOR_RANK = 2
"""Rank of an end-effector's surface [-]: under the "paper" rule the surface of the higher rank decides a contact."""

OBJECT_RANK = 1
"""Rank of an object's surface [-]."""

SUPPORT_RANK = 0
"""Rank of the surfaces of table, walls and frame [-]."""

Rule = Literal["paper", "product", "maximum"]
"""Name of the rule that combines the coefficients of two bodies; `combine` explains the three rules."""

CONTACT_STEPS = 5
"""Least number of physics steps in a bounce [-]. With fewer a contact gives back more energy than was asked, or more
than came in; with five the restitution is met within 0.03 (`pilegrasp doctor --physics`)."""

FLAT_STEPS = math.pi / 0.3
"""Least number of physics steps in the bounce of a point of a body with flat faces [-], 10.5. A face touches at four
points, whose springs add, so it bounces within half the time: five steps."""

OBJECT_IMPEDANCE = 0.8
"""Largest d in MuJoCo's solimp [-], chosen. It is constant in a contact, so that the damping ratio alone sets the
restitution; see `REST_SAG`."""

REST_SAG = 1.25
"""Least sag of a resting object into its contact, over the way by which gravity moves it in one step from rest [-];
chosen. What sags by less leaves its contact in every step and never rests. A lower d lets it sag by more."""

HAND_IMPEDANCE = 0.96
"""d for contacts of the end-effector [-], chosen. The stiffness of a contact grows with the mass of its lighter
body, and a fingertip has 5 g. At 0.8 a push of 20 N would press it 9 mm into the table."""

SLIP_STEPS = 1.0
"""Number of steps in which friction among objects stops slip on a slope [-], chosen. MuJoCo's friction yields like a
damper, by default the damper of the contact. For a ball that bounces this damper is so weak that a heap of balls at the
low wall flows at 2 to 15 mm/s and never falls asleep. On a level floor no force acts along the floor."""

RESTING_IMPEDANCE = 0.05
"""d at first touch of a contact without restitution [-], chosen. Such a contact starts soft, so that a pressed hand
stays in contact without chatter."""

IMPEDANCE_WIDTH = 0.002
"""Depth at which a contact without restitution reaches its full impedance [m], chosen."""

IMPACT_PHASES = 32
"""Number of moments between two steps at which `restitution_of` computes an impact [-], chosen."""


@dataclass(frozen=True, slots=True)
class Surface:
    """Friction and restitution of one body, in the paper's (and Bullet's) vocabulary.

    Attributes:
        lateral: Sliding friction coefficient [-].
        spinning: Torsional friction [m], the torque about the normal per newton of normal force.
        rolling: Rolling friction [m], the torque about the tangent per newton of normal force.
        restitution: Ratio of separation speed to approach speed [-].
        rank: `END_EFFECTOR_RANK`, `OBJECT_RANK` or `SUPPORT_RANK`; the "paper" rule takes the higher rank.
        contact_time: Duration of a bounce on something hard [s]; 0 for what is hard itself, such as wood.
        flat: Whether the body has flat faces, which touch at several points at once.
    """

    lateral: float
    spinning: float
    rolling: float
    restitution: float
    rank: int
    contact_time: float = 0.0
    flat: bool = False

    def __post_init__(self) -> None:
        if min(self.lateral, self.spinning, self.rolling) < 0.0 or not 0.0 <= self.restitution <= 1.0:
            raise ArgumentError(f"{self}: friction must not be negative, and restitution must lie in [0, 1]")


SUPPORT = Surface(lateral=0.25, spinning=0.001, rolling=0.001, restitution=0.72, rank=SUPPORT_RANK)
"""Table, walls and frame: smooth wood, against which the tennis ball's coefficients were measured (Cross 2002)."""


@dataclass(frozen=True, slots=True)
class PairParameters:
    """The fields of an `mjsPair`.

    Attributes:
        friction: MuJoCo's five coefficients: twice sliding, spinning, twice rolling.
        solref: Stiffness and damping in MuJoCo's direct (negative) format.
        solimp: MuJoCo's impedance: first, full, width, midpoint and power.
        solreffriction: Stiffness and damping of the friction; zeros mean those of `solref`.
    """

    friction: tuple[float, float, float, float, float]
    solref: tuple[float, float]
    solimp: tuple[float, float, float, float, float]
    solreffriction: tuple[float, float] = (0.0, 0.0)


def restitution_for_mass(mass: float) -> float:
    """Return the restitution [-] of an object by its mass [kg].

    This is the paper's line through COR(60 g) = 0.72 and COR(180 g) = 0.37 (V-A), clipped to [0, 1]. The clip is needed
    because the line is negative above 307 g, and the paper's Fig. 11 goes to 720 g.
    """
    return float(np.clip(0.72 + (mass - 0.060) * (0.37 - 0.72) / (0.180 - 0.060), 0.0, 1.0))


def restitution_of(damping_ratio: float, step: float) -> float:
    """Return the restitution of a contact of spring and damper that cannot pull, at steps of finite length.

    The contact is integrated by semi-implicit Euler, as in the engine. The result is the mean over the moments between
    two steps at which an impact can happen, because impacts in a pile happen at all of them. As `step` goes to zero the
    mean goes to the law of Schwager & Pöschel (2007, eq. 18), whose contact ends when the force, not the penetration,
    returns to zero.

    Args:
        damping_ratio: Damping ratio of spring and damper, not negative.
        step: Integration step times the contact's natural frequency [-].
    """
    position = -step * (np.arange(IMPACT_PHASES) + 0.5) / IMPACT_PHASES
    velocity = np.full(IMPACT_PHASES, -1.0)
    touching = np.ones(IMPACT_PHASES, dtype=bool)
    while touching.any():
        force = np.maximum(-position - 2.0 * damping_ratio * velocity, 0.0)
        velocity += touching * step * force
        position += touching * step * velocity
        touching = position < 0.0
    return float(velocity.mean())


@lru_cache(maxsize=256)
def damping_ratio_for(restitution: float, step: float) -> float:
    """Return the damping ratio whose `restitution_of` is `restitution`.

    The ratio never exceeds critical damping, nor the ratio that would reverse the velocity within one step. This limits
    the restitution from below (0.2 at five steps a bounce); for a smaller one, the ratio at the limit is returned.

    Raises:
        ArgumentError: The restitution lies outside [0, 1].
    """
    if not 0.0 <= restitution <= 1.0:
        raise ArgumentError(f"restitution is {restitution}; it must lie in [0, 1]")
    low, high = 0.0, min(1.0, 0.5 / step)
    for _ in range(math.ceil(math.log2(1e12))):
        middle = 0.5 * (low + high)
        if restitution_of(middle, step) > restitution:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def combine(a: Surface, b: Surface, rule: Rule) -> Surface:
    """Return the coefficients of the contact between `a` and `b`.

    - `paper` takes the measured numbers: the end-effector's if it takes part, otherwise the object's, which were
      measured against a hard surface.
    - `product` is Bullet's rule: friction and restitution are multiplied, and the rolling and spinning friction of each
      body is multiplied by the sliding friction of the other.
    - `maximum` is MuJoCo's rule.

    The softer body decides how long the contact lasts. An end-effector on a support never bounces: the touch-down is
    slower than the 0.2 m/s below which Bullet ignores restitution.
    """
    rank, time, flat = max(a.rank, b.rank), max(a.contact_time, b.contact_time), a.flat or b.flat
    if rule == "product":
        combined = Surface(
            a.lateral * b.lateral,
            a.spinning * b.lateral + b.spinning * a.lateral,
            a.rolling * b.lateral + b.rolling * a.lateral,
            a.restitution * b.restitution,
            rank,
            time,
            flat,
        )
    elif rule == "maximum" or a.rank == b.rank:
        combined = Surface(
            max(a.lateral, b.lateral),
            max(a.spinning, b.spinning),
            max(a.rolling, b.rolling),
            max(a.restitution, b.restitution),
            rank,
            time,
            flat,
        )
    else:
        combined = replace(a if a.rank > b.rank else b, contact_time=time, flat=flat)
    if {a.rank, b.rank} == {SUPPORT_RANK, END_EFFECTOR_RANK}:
        return replace(combined, restitution=0.0)
    return combined


def natural_frequency(surface: Surface, timestep: float) -> float:
    """Return the natural frequency of a contact [rad/s], whose bounce lasts half a period, at a physics step [s].

    A contact of something hard lasts as short as the steps allow.
    """
    steps = FLAT_STEPS if surface.flat else CONTACT_STEPS
    return math.pi / max(surface.contact_time, steps * timestep)


def largest_timestep(*surfaces: Surface) -> float:
    """Return the largest physics step that leaves `CONTACT_STEPS` in every stated contact time [s]; may be infinity."""
    return min((each.contact_time for each in surfaces if each.contact_time > 0.0), default=math.inf) / CONTACT_STEPS


@lru_cache(maxsize=256)
def pair_parameters(surface: Surface, timestep: float, slope: bool = False) -> PairParameters:
    """Return MuJoCo's numbers for the coefficients of one contact, at a physics step [s].

    With `slope`, friction among objects and supports holds a load at rest; see `SLIP_STEPS`.
    """
    frequency = natural_frequency(surface, timestep)
    step = frequency * timestep
    resting = min(OBJECT_IMPEDANCE, 1.0 - REST_SAG * step * step)
    impedance = HAND_IMPEDANCE if surface.rank == END_EFFECTOR_RANK else resting
    damping_ratio = damping_ratio_for(surface.restitution, step)
    first = RESTING_IMPEDANCE if surface.restitution == 0.0 else impedance
    holds = slope and surface.rank < END_EFFECTOR_RANK
    return PairParameters(
        friction=(surface.lateral, surface.lateral, surface.spinning, surface.rolling, surface.rolling),
        solref=(-(frequency**2), -2.0 * damping_ratio * frequency),
        solimp=(first, impedance, IMPEDANCE_WIDTH, 0.5, 2.0),
        solreffriction=(-(frequency**2), -1.0 / (SLIP_STEPS * timestep)) if holds else (0.0, 0.0),
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
