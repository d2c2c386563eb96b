"""What the arm is doing at one instant, with every quantity that a control law needs already computed."""

from __future__ import annotations

from typing import NamedTuple

from ..types import Array, Pose


class ArmState(NamedTuple):
    """Kinematics and dynamics at one (q, v); only `ArmModel.update` makes one, so holding it proves they are current.

    World axes throughout (Pinocchio's LOCAL_WORLD_ALIGNED): linear part first, at the tool frame's origin. The arrays
    belong to this state alone; the next update does not touch them.

    Attributes:
        x: (2 nv + 1,) q, v and a one, so that whatever is affine in the state is one product.
        q: (nv,) joint positions [rad], a view of x.
        v: (nv,) joint velocities [rad/s], a view of x.
        M: (nv, nv) joint-space inertia, the drives' reflected inertia included [kg·m²].
        h: (nv,) Coriolis, centrifugal and gravity torques [N·m], so that M a + h is the torque of acceleration a.
        J: (6, nv) tool Jacobian.
        Jdot_v: (6,) the tool's acceleration at zero joint acceleration [m/s², rad/s²].
        translation: (3,) position of the tool in the world [m].
        rotation: (3, 3) orientation of the tool in the world.
        twist: (6,) velocity of the tool, J v [m/s, rad/s].
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

    @property
    def pose(self) -> Pose:
        """`transform_tool_to_world`."""
        return Pose.trusted(self.translation, self.rotation)
