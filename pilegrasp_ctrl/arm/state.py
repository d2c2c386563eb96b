"""The state of the arm at one instant, with every quantity that a control law needs."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from ..types import Array, Pose

if TYPE_CHECKING:
    from .model import ArmModel


class FrameState(NamedTuple):
    """Kinematics of one frame, in world axes (Pinocchio's LOCAL_WORLD_ALIGNED), linear part first, at its origin.

    Attributes:
        J: (6, nv) Jacobian.
        Jdot_v: (6,) Acceleration at zero joint acceleration [m/s², rad/s²].
        translation: (3,) Position in the world [m].
        rotation: (3, 3) Orientation in the world.
        twist: (6,) Velocity J v [m/s, rad/s].
    """

    J: Array
    Jdot_v: Array
    translation: Array
    rotation: Array
    twist: Array

    @property
    def pose(self) -> Pose:
        """`transform_frame_to_world`."""
        return Pose.trusted(self.translation, self.rotation)


class ArmState(NamedTuple):
    """Kinematics and dynamics at one (q, v).

    Only `ArmModel.update` makes a state, so a state is always consistent. All quantities are in world axes (Pinocchio's
    LOCAL_WORLD_ALIGNED), linear part first, at the tool frame's origin. The arrays belong to this state alone; the next
    update does not touch them.

    Attributes:
        x: (2 nv + 1,) Vector [q; v; 1]; every affine function of the state is one product with it.
        q: (nv,) Joint positions [rad], a view of x.
        v: (nv,) Joint velocities [rad/s], a view of x.
        M: (nv, nv) Joint-space inertia with the drives' reflected inertia [kg·m²].
        h: (nv,) Coriolis, centrifugal and gravity torques [N·m]; M a + h is the torque of acceleration a.
        J: (6, nv) Tool Jacobian.
        Jdot_v: (6,) Tool acceleration at zero joint acceleration [m/s², rad/s²].
        translation: (3,) Position of the tool in the world [m].
        rotation: (3, 3) Orientation of the tool in the world.
        twist: (6,) Velocity of the tool, J v [m/s, rad/s].
        arm: Model that made the state.
        torque: (nv,) Torque that the controller commanded in the last period [N·m]; None where that is not known.
        wrench: (6,) Wrench of the environment on the hand, as in the observation [N, N·m]; None where not known.
    """

    x: Array
    q: Array
    v: Array
    M: Array
    h: Array
    J: Array
    Jdot_v: Array
    translation: Array
    rotation: Array
    twist: Array
    arm: ArmModel
    torque: Array | None = None
    wrench: Array | None = None

    @property
    def pose(self) -> Pose:
        """`transform_tool_to_world`."""
        return Pose.trusted(self.translation, self.rotation)

    @property
    def tool(self) -> FrameState:
        """Kinematics of the tool frame."""
        return FrameState(self.J, self.Jdot_v, self.translation, self.rotation, self.twist)

    def frame(self, name: str) -> FrameState:
        """Return the kinematics of any frame of the arm's model.

        Raises:
            ModelError: The model has no frame of this name.
        """
        return self.arm.frame_state(self, name)
