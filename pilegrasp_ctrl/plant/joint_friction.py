"""Coulomb and viscous joint friction that stops a joint and holds it, so that no joint creeps through zero."""

from __future__ import annotations

import daqp
import numpy as np

from ..exceptions import SimulationError
from ..kernels.algebra import cholesky, multiply, solve_factored, solve_factored_columns
from ..types import Array

_HELD = 1e-9
"""Relative distance of the friction from its bound above which a joint sticks [-]; chosen above round-off."""

_NOT_FINITE = "the joint friction has no solution: the motion is not finite; use more substeps"


class JointFriction:
    """Friction as one impulse per time step, after Moreau: the largest dissipation that the friction cone allows.

    The velocities at the end of a step of length t are

        (M + ½ t B) v⁺ = M v_free - ½ t B v + t f,        |f| <= coulomb.

    If the friction suffices, f makes a joint stick (v⁺ = 0). Otherwise f opposes the motion with all of coulomb. f is
    the optimum of a quadratic program (J. J. Moreau, "Unilateral contact and dry friction in finite freedom dynamics",
    in Nonsmooth Mechanics and Applications, 1988). An active-set method solves it exactly, so joints that are coupled
    through the inertia stick and slip together. The viscous part B is implicit, so that a light joint with high viscous
    friction stays stable.

    Attributes:
        coulomb: (nv,) Coulomb friction [N·m].
        viscous: (nv,) Viscous friction [N·m·s/rad].
        is_zero: Whether every joint is free of friction.
    """

    def __init__(self, coulomb: Array, viscous: Array) -> None:
        """Take Coulomb (nv,) [N·m] and viscous (nv,) [N·m·s/rad] friction; both must not be negative."""
        self.coulomb, self.viscous = coulomb, viscous
        self.is_zero = not (coulomb.any() or viscous.any())
        self._dry = np.flatnonzero(coulomb > 0.0)
        self._bound = np.ascontiguousarray(coulomb[self._dry])
        self._rows = np.zeros((0, len(self._dry)))
        self._constraint_types = np.zeros(len(self._dry), dtype=np.int32)

    def apply(self, M: Array, v: Array, v_free: Array, step: float) -> tuple[Array, Array]:
        """Return the velocities at the end of a step (nv,) [rad/s] and the Coulomb friction in it (nv,) [N·m].

        Args:
            M: (nv, nv) Joint-space inertia [kg·m²].
            v: (nv,) Velocities at the start [rad/s].
            v_free: (nv,) Velocities at the end without any friction [rad/s].
            step: Time step [s].

        Raises:
            SimulationError: The program has no solution, which happens only if values are not finite.
        """
        damping, factor = 0.5 * step * self.viscous, np.empty(M.shape)
        if not cholesky(M + np.diag(damping), factor):
            raise SimulationError(_NOT_FINITE)
        compliance, v_end, friction, change = np.eye(len(v)), np.empty(len(v)), np.zeros(len(v)), np.empty(len(v))
        solve_factored_columns(factor, compliance)
        multiply(M, v_free, v_end)
        v_end -= damping * v
        solve_factored(factor, v_end)
        dry = self._dry
        if dry.size:
            H = np.ascontiguousarray(compliance[np.ix_(dry, dry)])
            f, _, flag, _ = daqp.solve(
                H, v_end[dry] / step, self._rows, self._bound, -self._bound, self._constraint_types
            )
            if flag <= 0:
                raise SimulationError(_NOT_FINITE)
            friction[dry] = f
            multiply(compliance, friction, change)
            v_end += step * change
            # Round-off would let a held joint creep.
            v_end[dry[np.abs(f) < self._bound * (1.0 - _HELD)]] = 0.0
        return v_end, friction
