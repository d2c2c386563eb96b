"""A reference that jumps: what step responses are measured with."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..types import Array, Pose, Reference, frozen_array


@dataclass(frozen=True, slots=True, eq=False, init=False)
class Step:
    """A jump at time 0 from one pose at rest to another, without twist or acceleration to feed forward.

    Attributes:
        start: `transform_tool_to_world` before time 0.
        end: and from then on.
        displacement: (3,) [m].
        rotation: (3,) rotation vector, world axes [rad].
        duration: 0; a jump takes no time.
    """

    start: Pose
    displacement: Array
    rotation: Array
    end: Pose = field(repr=False)

    def __init__(self, start: Pose, displacement: ArrayLike, rotation: ArrayLike = (0.0, 0.0, 0.0)) -> None:
        """Take the jump.

        Raises:
            ValueError: where a vector has a wrong shape or a value is not finite.
        """
        set_ = object.__setattr__
        set_(self, "start", start)
        set_(self, "displacement", frozen_array(displacement, (3,), "displacement"))
        set_(self, "rotation", frozen_array(rotation, (3,), "rotation"))
        turned = pin.exp3(np.array(self.rotation)) @ start.rotation
        set_(self, "end", Pose(start.translation + self.displacement, turned))

    @property
    def duration(self) -> float:
        """Time from rest to rest [s]."""
        return 0.0

    def at(self, time: float) -> Reference:
        """Return the reference at `time` [s]."""
        return Reference(self.start if time < 0.0 else self.end)
