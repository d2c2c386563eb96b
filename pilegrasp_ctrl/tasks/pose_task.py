"""What the tasks of a frame share: the frame, the weights of its axes, the target, and the error of its pose."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..arm.fitting import check_arm
from ..arm.model import ArmModel
from ..arm.state import ArmState, FrameState
from ..exceptions import ArgumentError, ConfigurationError
from ..kernels import frame as kernels
from ..types import Array, Pose, Reference

FRICTION_APPROACH = 0.1, 0.4
"""Largest speed [m/s] and angular speed [rad/s] that an error asks for of the friction feed-forward; chosen.

They are enough for all of the Coulomb friction, and they bound the viscous part if a target is out of reach.
"""


class PoseTask:
    """A task with a target for the pose of one frame; `FrameTask` and `ImpedanceTask` give it a law.

    Attributes:
        arm: Arm whose frame it is.
        frame: Name of the frame.
        root: (6,) Square roots of the weights; zero leaves an axis free.
        target: Target of the frame; None until `set_target`.
    """

    def __init__(self, arm: ArmModel, frame: str | None, weight: ArrayLike, mask: ArrayLike | None) -> None:
        """Set the frame and the weights.

        Args:
            arm: Arm whose frame it is.
            frame: Name of the frame; None for the tool frame.
            weight: Scalar or (6,) weights, linear axes first, relative to other tasks.
            mask: (6,) Booleans; False leaves an axis free.

        Raises:
            ModelError: The arm has no such frame.
            ArgumentError: A weight is negative or not finite, no axis is left, or `arm` is not an arm.
        """
        check_arm(arm, type(self).__name__)
        self.arm = arm
        self.frame = arm.tool_frame if frame is None else arm.check_frame(frame)
        self.target: Reference | None = None
        self._weight, self._mask = _read_weight(weight), _read_mask(mask)
        self._error = np.zeros(6)
        self._update_axes()

    @property
    def weight(self) -> Array:
        """(6,) Weights of the axes, whatever the mask."""
        return self._weight

    @weight.setter
    def weight(self, weight: ArrayLike) -> None:
        before, self._weight = self._weight, _read_weight(weight)
        try:
            self._update_axes()
        except ArgumentError:
            self._weight = before
            raise

    @property
    def mask(self) -> Array:
        """(6,) Booleans; False leaves an axis free."""
        return self._mask

    @mask.setter
    def mask(self, mask: ArrayLike | None) -> None:
        before, self._mask = self._mask, _read_mask(mask)
        try:
            self._update_axes()
        except ArgumentError:
            self._mask = before
            raise

    def _update_axes(self) -> None:
        weights = self._weight * self._mask
        if not weights.any():
            raise ArgumentError(
                f"weight = {self._weight.tolist()} and mask = {self._mask.tolist()} leave the {type(self).__name__} no "
                "axis to control; keep one"
            )
        self.root: Array = np.sqrt(weights)
        self.root.setflags(write=False)

    def set_target(self, target: Reference | Pose) -> None:
        """Set the target of the frame for the coming periods.

        Args:
            target: Reference, or a pose to rest at.

        Raises:
            ArgumentError: The target is neither.
        """
        self.target = as_reference(target)

    def require_target(self) -> Reference:
        """Return the target.

        Raises:
            ConfigurationError: The task has none yet.
        """
        if self.target is None:
            raise ConfigurationError(
                f"the {type(self).__name__} of {self.frame!r} has no target; call set_target(reference) before step"
            )
        return self.target

    def view(self, state: ArmState) -> ArmState | FrameState:
        """Return the kinematics of the frame at a state."""
        return state if self.frame == state.arm.tool_frame else state.frame(self.frame)

    def velocity(self, error_rate: float) -> Array:
        """Return (6,) the weighted velocity that the rows ask for, for the friction feed-forward; see `Task`."""
        velocity = np.empty(6)
        twist = self.require_target().twist
        kernels.frame_velocity(self._error, twist, self.root, error_rate, *FRICTION_APPROACH, velocity)
        return velocity


def pose_error(state: ArmState | FrameState, reference: Reference) -> Array:
    """Return (6,) the error of a frame's pose [m, rad], world axes.

    The rotational part is the rotation vector of R_ref Rᵀ. Its derivative is the difference of the angular velocities,
    to first order in the error. It is the shortest rotation, at most half a turn. If the reference is half a turn
    ahead, the sense is arbitrary. Farther ahead, the vector changes its sense at once. The frame does not stay at that
    border, because a controller turns it away on either side.
    """
    error = np.empty(6)
    pose = reference.pose
    kernels.pose_error(pose.translation, pose.rotation, state.translation, state.rotation, error)
    return error


def as_reference(target: Reference | Pose) -> Reference:
    """Return a target as a reference; a pose is one at rest.

    Raises:
        ArgumentError: The target is neither a reference nor a pose.
    """
    if isinstance(target, Reference):
        return target
    if isinstance(target, Pose):
        return Reference(target)
    raise ArgumentError(f"a target is a Reference or a Pose, not {type(target).__name__}; give Reference(pose, twist)")


def _read_weight(weight: ArrayLike) -> Array:
    try:
        weights = np.array(np.broadcast_to(np.asarray(weight, dtype=np.float64), (6,)))
    except (TypeError, ValueError):
        raise ArgumentError(f"weight = {weight!r:.80} must be one number or six, linear axes first") from None
    if not np.isfinite(weights).all() or (weights < 0.0).any():
        raise ArgumentError(f"weight = {weights.tolist()} must be finite and not negative")
    weights.setflags(write=False)
    return weights


def _read_mask(mask: ArrayLike | None) -> Array:
    if mask is None:
        mask = np.ones(6, dtype=bool)
    array = np.asarray(mask)
    if array.shape != (6,) or array.dtype.kind not in "biuf":
        raise ArgumentError(f"mask = {mask!r:.80} must be six booleans, linear axes first")
    array = array.astype(bool)
    array.setflags(write=False)
    return array
