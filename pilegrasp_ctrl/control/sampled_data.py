"""How stiff, how light and how quick an impedance may be that is computed once a period from a late measurement."""

from __future__ import annotations

from dataclasses import replace
from math import inf, sqrt

import numpy as np

from ..arm.model import ArmModel
from ..exceptions import ConfigurationError
from ..tasks.gains import Impedance
from ..tasks.impedance_task import ImpedanceTask
from ..types import Array
from .tool_axes import turn_state

_RANGE = 1e6
_BISECTIONS = 40
_ROUND_OFF = 1e-9


def tool_mobility(arm: ArmModel, impedance: Impedance, q: Array) -> Array:
    """Return (6, 6) Lambda⁻¹ = J M⁻¹ Jᵀ at a posture, in the axes of the gains [1/kg, 1/(kg m), 1/(kg m²)].

    Args:
        arm: with its tool.
        impedance: whose axes are meant; those of a tool frame are taken where the tool is.
        q: (nv,) the posture [rad].
    """
    state = arm.update(q, np.zeros(arm.nv))
    if impedance.frame == "tool":
        state = turn_state(state.rotation, state)
    mobility: Array = state.J @ np.linalg.solve(state.M, state.J.T)
    return mobility


def spectral_radius(mobility: Array, stiffness: Array, damping: Array, rate: float) -> float:
    """Return by which factor the slowest-decaying motion of sampled springs and dampers changes in a period h.

    The tool accelerates with `-L (K e + D e')` of the period's start for the whole of it, so that

        [e ]⁺   [1 - ½ h² L K    h - ½ h² L D] [e ]
        [e']  = [   - h L K        1 - h L D ] [e'],      L the mobility.

    Above 1 the loop diverges. Where all damping comes from a ratio zeta, the modes of (Lambda, K) stay apart, and the
    criterion of Jury gives `omega h < min(1 / zeta, 4 zeta)` for each natural frequency omega: critically damped
    springs need more control periods a second than their fastest mode has radians.

    Args:
        mobility: (6, 6) inverse of the inertia that the tool shows.
        stiffness: (6, 6) [N/m, N·m/rad].
        damping: (6, 6) [N·s/m, N·m·s/rad].
        rate: [Hz].
    """
    h, one = 1.0 / rate, np.eye(6)
    spring, damper = mobility @ stiffness, mobility @ damping
    step = np.block([[one - 0.5 * h * h * spring, h * (one - 0.5 * h * damper)], [-h * spring, one - h * damper]])
    return float(np.abs(np.linalg.eigvals(step)).max())


def stiffness_margin(arm: ArmModel, impedance: Impedance, q: Array, rate: float = 500.0) -> float:
    """Return by which factor the stiffness could grow until the sampled loop diverges in free motion; below 1 it does.

    The damping ratio and the explicit damping stay as they are. Zero where the dampers alone are too much, infinite
    where a millionfold stiffness still is stable. Joint friction, which steadies a real arm, is left out.

    Args:
        arm: with its tool.
        impedance: the gains.
        q: (nv,) the posture [rad].
        rate: of the control [Hz].
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


def largest_stiffness(arm: ArmModel, impedance: Impedance, q: Array, rate: float = 500.0) -> Array:
    """Return (6,) the stiffness at which the sampled loop begins to diverge in free motion [N/m, N·m/rad].

    In the proportions that the impedance has; arguments as for `stiffness_margin`.
    """
    largest = np.zeros(6)
    sprung = impedance.stiffness > 0.0
    largest[sprung] = stiffness_margin(arm, impedance, q, rate) * impedance.stiffness[sprung]
    return largest


def check_stability(arm: ArmModel, impedance: Impedance, q: Array, rate: float, lag: float | None) -> None:
    """Refuse gains that cannot work at a posture.

    Args:
        arm: with its tool.
        impedance: the gains.
        q: (nv,) the posture [rad].
        rate: of the control [Hz].
        lag: of the wrench that shapes an inertia [s]; None leaves the inertia unchecked.

    Raises:
        ConfigurationError: where the sampled loop diverges in free motion, or a shaped inertia would ring against a
            stiff wall.
    """
    if _diverges(_shown_mobility(arm, impedance, q), impedance, rate, 1.0):
        margin = stiffness_margin(arm, impedance, q, rate)
        # A little less, so that what is named is also taken once it is rounded.
        remedy = f"take at most {0.99 * margin:.3g} of its stiffness" if margin > 0.0 else "take less damping"
        raise ConfigurationError(
            f"the impedance is too hard for {arm.name} at {rate:g} Hz: computed once a period, it diverges at the "
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
    """Return (6,) the inertia below which a shaped tool rings against a wall however stiff [kg, kg·m²].

    A wrench that is late by the first-order `lag` T is cancelled too late by T. Against a wall of stiffness k, along an
    axis on which the arm itself shows the inertia m = 1 / (Lambda⁻¹)_ii, the loop is

        m T s³ + (m + r D T) s² + (r (D + K T) + k T) s + r (K + k) = 0,      r = m / inertia

    which Routh's criterion finds stable for every k where

        inertia >= m - D T

    so that more damping and a faster sensor allow a lighter tool, and a tool heavier than the arm needs neither.

    Args:
        arm: with its tool.
        impedance: gains with an inertia.
        q: (nv,) the posture [rad].
        lag: time constant of the sensor's low-pass plus its other delays [s].
    """
    assert impedance.inertia is not None
    apparent = 1.0 / np.diagonal(tool_mobility(arm, impedance, q))
    damping = np.diagonal(ImpedanceTask(impedance).damping(np.diag(1.0 / impedance.inertia)))
    return np.maximum(0.0, apparent - lag * damping)


def check_force_gain(arm: ArmModel, impedance: Impedance, q: Array, directions: Array, lag: float) -> None:
    """Refuse a force gain that would swing against some wall.

    Args:
        arm: with its tool.
        impedance: gains with a force gain.
        q: (nv,) the posture [rad].
        directions: (k, 3) unit vectors along which forces are corrected, in the axes of the gains.
        lag: of the measured wrench [s].

    Raises:
        ConfigurationError: where the gain is not below `largest_force_gain` along a direction.
    """
    mobility = _shown_mobility(arm, impedance, q)
    damping, inertia = ImpedanceTask(impedance).damping(mobility)[:3, :3], np.linalg.inv(mobility)[:3, :3]
    largest = min(largest_force_gain(float(n @ damping @ n), float(n @ inertia @ n), lag) for n in directions)
    if impedance.force_gain >= largest:
        raise ConfigurationError(
            f"force_gain = {impedance.force_gain:g} 1/s is too large: the corrected force would swing from "
            f"{largest:.3g} 1/s on; take about a quarter of that"
        )


def largest_force_gain(damping: float, inertia: float, lag: float = 0.0) -> float:
    """Return the integral gain at which a force that is corrected by a late measurement begins to swing [1/s].

    Against a wall of stiffness k the hand is `m s² + D s + k`, the sensor `1 / (T s + 1)`, and the correction's
    integral `g / s`; Routh's criterion asks of all three together for

        g < D / (m + D T) + T² D k / (m + D T)²

    of which the first part holds for every k. A quarter of it keeps the force from overshooting much.

    Args:
        damping: D along the force [N·s/m].
        inertia: m that the tool shows along it [kg].
        lag: T of the sensor [s].
    """
    return damping / (inertia + damping * lag)


def _shown_mobility(arm: ArmModel, impedance: Impedance, q: Array) -> Array:
    """Return (6, 6) the inverse of the inertia that the tool shows: the shaped one, or the arm's."""
    return tool_mobility(arm, impedance, q) if impedance.inertia is None else np.diag(1.0 / impedance.inertia)


def _diverges(mobility: Array, impedance: Impedance, rate: float, share: float) -> bool:
    task = ImpedanceTask(replace(impedance, stiffness=share * impedance.stiffness))
    # An axis without a spring has an eigenvalue of exactly one.
    return spectral_radius(mobility, task.stiffness, task.damping(mobility), rate) > 1.0 + _ROUND_OFF
