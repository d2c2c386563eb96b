"""The tool follows a reference: operational-space motion control."""

from __future__ import annotations

from math import hypot

from numpy.typing import ArrayLike

from ..arm.state import ArmState
from ..types import Array, Reference
from .frame_task import FrameTask
from .gains import MotionGains
from .singular_directions import SingularDirections

_APPROACH_SPEED = 1.0
_APPROACH_TURN = 3.0


class FrameMotionTask(FrameTask):
    """A second-order, inertia-independent decay of the tool's error.

    The law is `a_ref + damping (v_ref - v) + stiffness e`, bent where it asks for what an arm cannot do:

    - The springs never ask for an approach faster than 1 m/s or 3 rad/s. Spring and damper together hold the speed
      `stiffness e / damping`, and it is that which is shortened, in translation and rotation each as a whole. Large
      errors then ask for a speed rather than for an acceleration, as in O. Khatib, IEEE J-RA 3(1), 1987; without it a
      large error of one kind wins the limits of the arm for itself, and the tool strays in the other.
    - Near singular postures `SingularDirections` takes back what is asked for in the directions that get lost.

    Attributes:
        gains: [1/s²].
        rates: (6,) stiffness over damping, zero on free axes [1/s].
    """

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
        # The error of a free axis must not shorten what is asked for along the others.
        self.rates = gains.stiffness / gains.damping * (self.sqrt_weight > 0.0)
        self._slowest = min(_APPROACH_SPEED, _APPROACH_TURN)
        self._singular = SingularDirections(self.sqrt_weight > 0.0)

    def acceleration(self, state: ArmState, reference: Reference, error: Array) -> Array:
        """Return (6,) the wanted tool acceleration [m/s², rad/s²].

        Args:
            state: the arm.
            reference: where the tool should be.
            error: `pose_error(state, reference)`.
        """
        wanted = self.rates * error
        # What is short as a whole is short in both parts: nearly every period.
        if hypot(*wanted.tolist()) > self._slowest:
            shorten(wanted[:3], _APPROACH_SPEED)
            shorten(wanted[3:], _APPROACH_TURN)
        wanted += reference.twist
        wanted -= state.twist
        wanted *= self._damping
        wanted += reference.acceleration
        return self._singular.bend(state, wanted)

    def thresholds(self) -> tuple[float, float, float]:
        """Return up to where the law is the plain one.

        The length of `rates e`, the square of the length of the wanted acceleration less Jdot v, and the square of the
        least singular value of J above which that may be longer.
        """
        return self._slowest, self._singular.free**2, self._singular.threshold**2


def shorten(vector: Array, length: float) -> None:
    """Scale `vector` in place so that it is not longer than `length`."""
    size = hypot(*vector.tolist())
    if size > length:
        vector *= length / size
