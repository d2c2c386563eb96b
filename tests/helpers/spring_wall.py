"""A wall with a known stiffness, so that forces and displacements can be predicted."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf

import numpy as np

from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.types import Array, Pose, frozen_array


@dataclass(frozen=True, slots=True, eq=False)
class SpringWall:
    """An elastic half-space without friction that pushes the tool's origin out along its normal, and never pulls.

    Attributes:
        point: (3,) Point on the surface, world axes [m].
        normal: (3,) Direction out of the wall, of any length but zero; stored as a unit vector.
        stiffness: Stiffness [N/m].
        damping: Damping [N·s/m].

    Raises:
        ConfigurationError: A vector is not three finite numbers, the normal is zero, the stiffness is not positive, or
            the damping is negative.
    """

    point: Array
    normal: Array
    stiffness: float
    damping: float = 0.0
    _none: Array = field(default_factory=lambda: np.zeros(6), init=False, repr=False)

    def __post_init__(self) -> None:
        try:
            point, normal = (frozen_array(getattr(self, name), (3,), name) for name in ("point", "normal"))
        except (TypeError, ValueError) as error:
            raise ConfigurationError(f"a wall needs a point and a normal of three numbers: {error}") from None
        length = float(np.linalg.norm(normal))
        if not (length > 0.0 and 0.0 < self.stiffness < inf and 0.0 <= self.damping < inf):
            raise ConfigurationError(
                f"a wall needs a normal that is not zero, a positive stiffness [N/m] and a damping [N·s/m] that is not "
                f"negative; they are {normal.tolist()}, {self.stiffness} and {self.damping}"
            )
        object.__setattr__(self, "point", point)
        object.__setattr__(self, "normal", frozen_array(normal / length, (3,), "normal"))

    def __call__(self, pose: Pose, twist: Array) -> Array:
        """Return (6,) the wrench on the tool at its origin, world axes [N, N·m].

        Args:
            pose: Pose of the tool, `transform_tool_to_world`.
            twist: (6,) Velocity of the tool [m/s, rad/s].
        """
        depth = float(self.normal @ (self.point - pose.translation))
        if depth <= 0.0:
            return self._none
        force = self.stiffness * depth - self.damping * float(self.normal @ twist[:3])
        return np.concatenate((max(0.0, force) * self.normal, np.zeros(3)))
