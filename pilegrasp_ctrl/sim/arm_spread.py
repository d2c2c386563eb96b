"""An arm that differs from its model: friction of joints and mass of links, drawn from the seed of an attempt."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from ..planning.simulated_arm import ArmSpread
from ..types import Array

STREAM = 0xA3
"""Number that keeps these draws apart from others of the same seed; chosen."""


@dataclass(frozen=True, slots=True, eq=False)
class ArmFactors:
    """Factors of a simulated arm over its model.

    Attributes:
        friction: (nv,) Factors on Coulomb and viscous friction of the joints [-].
        mass: Factor on the mass of all links [-].
    """

    friction: Array
    mass: float


def draw_factors(spread: ArmSpread, center: ArmFactors, seed: int | None) -> ArmFactors:
    """Return factors within the spread about `center`, uniformly; the centre itself without a seed.

    Each joint has its own friction. The links share one factor of mass, because gravity terms are identified together.
    """
    if seed is None:
        return center
    draws = np.random.default_rng([seed, STREAM]).uniform(-1.0, 1.0, size=len(center.friction) + 1)
    return ArmFactors(
        friction=center.friction * (1.0 + spread.friction * draws[:-1]),
        mass=center.mass * (1.0 + spread.mass * float(draws[-1])),
    )


def apply_factors(model: mujoco.MjModel, bodies: Sequence[int], factors: ArmFactors) -> None:
    """Change friction of the first joints of a compiled scene, and mass and inertia of the arm's bodies."""
    joints = len(factors.friction)
    model.dof_frictionloss[:joints] *= factors.friction
    model.dof_damping[:joints] *= factors.friction
    if factors.mass != 1.0:
        model.body_mass[list(bodies)] *= factors.mass
        model.body_inertia[list(bodies)] *= factors.mass
        mujoco.mj_setConst(model, mujoco.MjData(model))
