"""Coulomb and viscous friction of the joints that stops a joint and holds it, rather than creeping through zero."""

from __future__ import annotations

import daqp
import numpy as np

from ..exceptions import SimulationError
from ..types import Array

_HELD = 1e-9


class JointFriction:
    """Friction as one impulse per time step, after Moreau: the largest dissipation that the friction cone allows.

    The velocities at the end of a step of length t are

        (M + ½ t B) v⁺ = M v_free - ½ t B v + t f,        |f| <= coulomb

    with f such that a joint stands still (v⁺ = 0) wherever the friction suffices, and is opposed by all of it
    elsewhere. That is the optimum of a quadratic program in f (J. J. Moreau, "Unilateral contact and dry friction in
    finite freedom dynamics", in Nonsmooth Mechanics and Applications, 1988), which an active-set method solves exactly;
    so joints that are coupled through the inertia stick and slip together as they should. The viscous part B is
    implicit, so that a light joint with much of it does not blow up.

    Attributes:
        coulomb: (nv,) [N·m].
        viscous: (nv,) [N·m·s/rad].
        none: whether there is no friction at all.
    """

    def __init__(self, coulomb: Array, viscous: Array) -> None:
        """Take both frictions, not negative."""
        self.coulomb, self.viscous = coulomb, viscous
        self.none = not (coulomb.any() or viscous.any())
        self._dry = np.flatnonzero(coulomb > 0.0)
        self._bound = np.ascontiguousarray(coulomb[self._dry])
        self._rows = np.zeros((0, len(self._dry)))
        self._kinds = np.zeros(len(self._dry), dtype=np.int32)

    def slow(self, M: Array, v: Array, v_free: Array, step: float) -> tuple[Array, Array]:
        """Return (nv,) the velocities at the end of a step [rad/s] and (nv,) the Coulomb friction in it [N·m].

        Args:
            M: (nv, nv) joint-space inertia [kg·m²].
            v: (nv,) velocities at the start [rad/s].
            v_free: (nv,) velocities at the end without any friction [rad/s].
            step: [s].

        Raises:
            SimulationError: where the program has no solution, which only values that are not finite can bring about.
        """
        damping = 0.5 * step * self.viscous
        compliance = np.linalg.inv(M + np.diag(damping))
        v_end = compliance @ (M @ v_free - damping * v)
        friction = np.zeros(len(v))
        dry = self._dry
        if dry.size:
            H = np.ascontiguousarray(compliance[np.ix_(dry, dry)])
            f, _, flag, _ = daqp.solve(H, v_end[dry] / step, self._rows, self._bound, -self._bound, self._kinds)
            if flag <= 0:
                raise SimulationError("the joint friction has no solution: the motion is not finite; use more substeps")
            friction[dry] = f
            v_end = v_end + step * (compliance[:, dry] @ f)
            # Round-off would let a joint that is held creep.
            v_end[dry[np.abs(f) < self._bound * (1.0 - _HELD)]] = 0.0
        return v_end, friction
