"""Bounds on stiffness, inertia and force gain of an impedance in a sampled loop with a delayed measurement."""

from __future__ import annotations

from dataclasses import replace
from math import inf, sqrt

import numpy as np

from ..arm.model import ArmModel
from ..exceptions import ConfigurationError
from ..kernels.algebra import invert
from ..tasks.gains import Impedance
from ..tasks.impedance_law import ImpedanceLaw
from ..tasks.mobility import mobility_of
from ..tasks.sampled_motion import spectral_radius
from ..tasks.tool_axes import turn_frame
from ..types import Array
from ..vectors import inner, rotated

_RANGE = 1e6
"""Largest stiffness factor that is searched, and the inverse of the smallest; chosen."""
_BISECTIONS = 40
"""Number of bisections of the range of stiffness factors; chosen, enough for nine digits."""
_ROUND_OFF = 1e-9
"""Excess of a spectral radius over 1 that counts as round-off; chosen."""


def tool_mobility(arm: ArmModel, impedance: Impedance, q: Array) -> Array:
    """Return (6, 6) Lambda⁻¹ = J M⁻¹ Jᵀ at a posture, in the axes of the gains [1/kg, 1/(kg m), 1/(kg m²)].

    Args:
        arm: Arm with its tool.
        impedance: Gains that define the axes; a tool frame has the axes of the tool at `q`.
        q: (nv,) Posture [rad].
    """
    state = arm.update(q, np.zeros(arm.nv))
    J = state.J
    if impedance.frame == "tool":
        J = turn_frame(state.rotation, state).J
    return mobility_of(state.M, J)


def stiffness_margin(arm: ArmModel, impedance: Impedance, q: Array, rate: float = 500.0) -> float:
    """Return the factor by which the stiffness can grow until the sampled loop diverges in free motion.

    Below 1 the loop diverges already. The damping ratio and the explicit damping stay as they are. The factor is zero
    if the dampers alone are too strong, and infinite if a millionfold stiffness is still stable. Joint friction, which
    steadies a real arm, is left out. The stiffness at which the loop begins to diverge is the factor times the
    impedance's.

    Args:
        arm: Arm with its tool.
        impedance: Gains.
        q: (nv,) Posture [rad].
        rate: Control rate [Hz].
    """
    mobility = _shown_mobility(arm, impedance, q)
    low, high = 1.0 / _RANGE, _RANGE
    if _diverges(mobility, impedance, rate, low):
        return 0.0
    if not _diverges(mobility, impedance, rate, high):
        return inf
    for _ in range(_BISECTIONS):
        middle = sqrt(low * high)
        low, high = (low, middle) if _diverges(mobility, impedance, rate, middle) else (middle, high)
    return low


def check_stability(arm: ArmModel, impedance: Impedance, q: Array, rate: float, lag: float | None) -> None:
    """Reject gains that cannot work at a posture.

    Args:
        arm: Arm with its tool.
        impedance: Gains.
        q: (nv,) Posture [rad].
        rate: Control rate [Hz].
        lag: Lag of the measured wrench [s]; None leaves the inertia unchecked.

    Raises:
        ConfigurationError: The sampled loop diverges in free motion, or a shaped inertia would ring against a stiff
            wall.
    """
    if _diverges(_shown_mobility(arm, impedance, q), impedance, rate, 1.0):
        margin = stiffness_margin(arm, impedance, q, rate)
        fault, remedy = "strongly damped", "take less damping"
        if margin > 0.0:
            # A slightly smaller share is named, so that it is accepted after rounding.
            fault, remedy = "stiff", f"take at most {0.99 * margin:.3g} of its stiffness"
        raise ConfigurationError(
            f"the impedance is too {fault} for {arm.name} at {rate:g} Hz: computed once per period, it diverges at the "
            f"preferred posture; {remedy}, or a higher rate"
        )
    if impedance.inertia is None or lag is None:
        return
    least = least_inertia(arm, impedance, q, lag)
    if (impedance.inertia < least).any():
        axis = int(np.argmax(least - impedance.inertia))
        raise ConfigurationError(
            f"inertia[{axis}] = {impedance.inertia[axis]:g} is too small for a wrench {1e3 * lag:.3g} ms late: "
            f"against a stiff wall the hand would ring; take at least {1.01 * least[axis]:.3g}, more damping, or a "
            "faster sensor"
        )


def least_inertia(arm: ArmModel, impedance: Impedance, q: Array, lag: float) -> Array:
    """Return (6,) the inertia below which a shaped tool rings against some stiff wall [kg, kg·m²].

    A wrench with the first-order `lag` T is cancelled too late by T. Take a wall of stiffness k, along an axis on which
    the arm itself shows the inertia m = 1 / (Lambda⁻¹)_ii. The loop is

        m T s³ + (m + r D T) s² + (r (D + K T) + k T) s + r (K + k) = 0,      r = m / inertia

    which Routh's criterion finds stable for every k if

        inertia >= m - D T

    More damping and a faster sensor allow a lighter tool. A tool with more inertia than the arm needs neither.

    Args:
        arm: Arm with its tool.
        impedance: Gains with an inertia.
        q: (nv,) Posture [rad].
        lag: Time constant of the sensor's low-pass plus its other delays [s].

    Raises:
        ConfigurationError: The impedance has no inertia.
    """
    if impedance.inertia is None:
        raise ConfigurationError("the impedance has no inertia, so there is no least one; give it an inertia")
    apparent = 1.0 / np.diagonal(tool_mobility(arm, impedance, q))
    damping = np.diagonal(ImpedanceLaw(impedance).damping(np.diag(1.0 / impedance.inertia)))
    return np.maximum(0.0, apparent - lag * damping)


def check_force_gain(arm: ArmModel, impedance: Impedance, q: Array, directions: Array, lag: float) -> None:
    """Reject a force gain with which the force would oscillate against some wall.

    Args:
        arm: Arm with its tool.
        impedance: Gains with a force gain.
        q: (nv,) Posture [rad].
        directions: (k, 3) Unit vectors along which forces are corrected, in the axes of the gains.
        lag: Lag of the measured wrench [s].

    Raises:
        ConfigurationError: The gain is not below `largest_force_gain` along a direction.
    """
    mobility = _shown_mobility(arm, impedance, q)
    inertia = np.empty((6, 6))
    invert(mobility, inertia)
    D, L = ImpedanceLaw(impedance).damping(mobility)[:3, :3], inertia[:3, :3]
    largest = min(largest_force_gain(inner(n, rotated(D, n)), inner(n, rotated(L, n)), lag) for n in directions)
    if impedance.force_gain >= largest:
        raise ConfigurationError(
            f"force_gain = {impedance.force_gain:g} 1/s is too large: the corrected force would oscillate "
            f"from {largest:.3g} 1/s on; take about a quarter of that"
        )


def largest_force_gain(damping: float, inertia: float, lag: float = 0.0) -> float:
    """Return the integral gain at which a force that is corrected by a late measurement begins to oscillate [1/s].

    Against a wall of stiffness k the hand is `m s² + D s + k`, the sensor `1 / (T s + 1)`, and the correction's
    integral `g / s`. Routh's criterion for all three together is

        g < D / (m + D T) + T² D k / (m + D T)²

    The first term holds for every k and is returned. With a quarter of it, the force overshoots little.

    Args:
        damping: Damping D along the force [N·s/m].
        inertia: Inertia m that the tool shows along it [kg].
        lag: Lag T of the sensor [s].
    """
    return damping / (inertia + damping * lag)


def _shown_mobility(arm: ArmModel, impedance: Impedance, q: Array) -> Array:
    """Return (6, 6) the inverse of the inertia that the tool shows: the shaped one, or the arm's."""
    return tool_mobility(arm, impedance, q) if impedance.inertia is None else np.diag(1.0 / impedance.inertia)


def _diverges(mobility: Array, impedance: Impedance, rate: float, share: float) -> bool:
    task = ImpedanceLaw(replace(impedance, stiffness=share * impedance.stiffness))
    # An axis without a spring has an eigenvalue of exactly one.
    return spectral_radius(mobility, task.stiffness, task.damping(mobility), rate) > 1.0 + _ROUND_OFF
