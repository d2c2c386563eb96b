"""The tool follows a reference: operational-space motion control."""

from __future__ import annotations

from numpy.typing import ArrayLike

from ..arm_state import ArmState
from ..control.gains import MotionGains
from ..types import Array, Reference
from .frame_task import FrameTask


class FrameMotionTask(FrameTask):
    """A second-order, inertia-independent decay of the tool's error."""

    def __init__(self, gains: MotionGains, weight: ArrayLike = 1.0, mask: ArrayLike | None = None) -> None:
        """Take gains in 1/s²; `weight` and `mask` as in `FrameTask`.

        Raises:
            TypeError: where the gains are those of an impedance.
        """
        if not isinstance(gains, MotionGains):
            raise TypeError(f"motion control takes MotionGains in 1/s², not {type(gains).__name__}")
        super().__init__(weight, mask)
        self.gains = gains
        self._damping = gains.damping

    def acceleration(self, state: ArmState, reference: Reference, error: Array) -> Array:
        """Return (6,) the wanted tool acceleration `a_ref + damping (v_ref - v) + stiffness e` [m/s², rad/s²].

        Args:
            state: the arm.
            reference: where the tool should be.
            error: `pose_error(state, reference)`.
        """
        wanted = reference.twist - state.twist
        wanted *= self._damping
        wanted += self.gains.stiffness * error
        wanted += reference.acceleration
        return wanted
