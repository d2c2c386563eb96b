"""The task of a frame that follows a reference as seen from another frame of the same arm."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arm.model import ArmModel
from ..arm.state import ArmState, FrameState
from ..exceptions import ArgumentError
from ..kernels import frame as kernels
from .frame_task import DEFAULT_GAINS, FrameTask
from .gains import MotionGains


class RelativeFrameTask(FrameTask):
    """`FrameTask` for the pose of a frame in a root frame that may move: `transform_frame_to_root`.

    Target, weights and mask are along the axes of the root frame. The rows are those of the relative motion, Coriolis
    and centrifugal terms included.

    Attributes:
        root_frame: Name of the root frame.
    """

    def __init__(
        self,
        arm: ArmModel,
        frame: str | None,
        root_frame: str,
        gains: MotionGains = DEFAULT_GAINS,
        **options: Any,
    ) -> None:
        """Set both frames and the gains.

        Args:
            arm: Arm whose frames they are.
            frame: Name of the frame; None for the tool frame.
            root_frame: Name of the frame from which it is seen.
            gains: Gains [1/s²].
            options: Further arguments of `FrameTask`.

        Raises:
            ArgumentError: Both frames are the same, or an option cannot be used.
            ModelError: The arm has no such frame.
            GainsError: The gains are those of an impedance.
        """
        super().__init__(arm, frame, gains, **options)
        self.root_frame = arm.check_frame(root_frame)
        if self.root_frame == self.frame:
            raise ArgumentError(f"RelativeFrameTask: frame and root_frame are both {root_frame!r}; name another root")

    def view(self, state: ArmState) -> FrameState:
        """Return the kinematics of the frame in the root frame."""
        own, root = state.frame(self.frame), state.frame(self.root_frame)
        seen = FrameState(np.empty((6, state.arm.nv)), np.empty(6), np.empty(3), np.empty((3, 3)), np.empty(6))
        kernels.relative_frame(*own, *root, *seen)
        return seen
