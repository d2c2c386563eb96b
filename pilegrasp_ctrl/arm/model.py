"""The controllers' model of an arm: a Pinocchio model with limits, joint friction and one tool frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from os import PathLike
from pathlib import Path
from threading import local
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..exceptions import ModelError
from ..types import STANDARD_GRAVITY, Array, MassProperties, Pose
from .loading import frame_id, read_arm_folder, read_urdf
from .state import ArmState

_MAX_CONDITION = 1e6
"""Largest condition number of a `joint_to_motor` that counts as invertible; chosen."""
_WORLD = pin.Convention.WORLD
"""Convention of `pin.crba` in which it also computes the joint Jacobians."""
_WORLD_ALIGNED = pin.LOCAL_WORLD_ALIGNED
"""Frame of Jacobian and acceleration: at the tool frame's origin, in world axes."""


class ArmModel:
    """A fixed-base arm of revolute or prismatic joints, with one tool frame.

    `load` makes an arm that ships with the library, `from_urdf` any other. The model does not change after
    construction, and its limits are read-only arrays. Threads may share it: each has buffers of its own.

    Attributes:
        name: Name of the arm, for error messages.
        tool_frame: Name of the controlled frame.
        nv: Number of joints.
        joint_names: Names of the joints, in the order of every (nv,) array.
        q_lower: (nv,) Lower position limits [rad], -inf where there is none.
        q_upper: (nv,) Upper position limits [rad], inf where there is none.
        velocity_limit: (nv,) Largest speeds [rad/s].
        torque_limit: (nv,) Largest torques [N·m].
        friction_coulomb: (nv,) Coulomb friction at the joints [N·m], zero where unknown.
        friction_viscous: (nv,) Viscous friction at the joints [N·m·s/rad], zero where unknown.
        joint_to_motor: (nv, nv) Matrix from joint to motor speeds; None if each joint has its own motor.
        motor_torque_limit: (nv,) Largest motor torques [N·m]; None without `joint_to_motor`.
    """

    def __init__(
        self,
        model: pin.Model,
        tool_frame: str,
        *,
        name: str = "arm",
        q_lower: ArrayLike | None = None,
        q_upper: ArrayLike | None = None,
        velocity_limit: ArrayLike | None = None,
        torque_limit: ArrayLike | None = None,
        friction_coulomb: ArrayLike | None = None,
        friction_viscous: ArrayLike | None = None,
        joint_to_motor: ArrayLike | None = None,
        motor_torque_limit: ArrayLike | None = None,
    ) -> None:
        """Wrap a copy of a Pinocchio model.

        Args:
            model: Fixed-base model with nq == nv.
            tool_frame: Name of the frame that references and Jacobians describe.
            name: Name of the arm, for error messages.
            q_lower: (nv,) Lower position limits in place of the model's [rad].
            q_upper: (nv,) Upper position limits in place of the model's [rad].
            velocity_limit: (nv,) Largest speeds in place of the model's [rad/s].
            torque_limit: (nv,) Largest torques in place of the model's [N·m].
            friction_coulomb: (nv,) Coulomb friction [N·m]; zero by default.
            friction_viscous: (nv,) Viscous friction [N·m·s/rad]; zero by default.
            joint_to_motor: (nv, nv) Matrix from joint to motor speeds, for motors that share joints; by default each
                joint has its own motor.
            motor_torque_limit: (nv,) Largest torques of such motors [N·m]; required with `joint_to_motor`.

        Raises:
            ModelError: The frame is unknown, a joint is neither revolute nor prismatic, or a limit is not usable.
        """
        if model.nq != model.nv:
            odd = [model.names[i] for i in range(1, model.njoints) if model.joints[i].nq != model.joints[i].nv]
            raise ModelError(
                f"{name}: joint {odd[0]!r} is neither revolute nor prismatic; lock it, or give it limits in the URDF"
            )
        self._frame = frame_id(model, tool_frame, name)
        self.name, self.tool_frame = name, tool_frame
        self.nv: int = model.nv
        self.joint_names = tuple(model.names)[1:]
        self._model = pin.Model(model)
        self._buffers = local()
        self._zero = np.zeros(self.nv)
        self._one = np.zeros(2 * self.nv + 1)
        self._one[-1] = 1.0
        self.q_lower = self._limit(q_lower, model.lowerPositionLimit, "q_lower")
        self.q_upper = self._limit(q_upper, model.upperPositionLimit, "q_upper")
        self.velocity_limit = self._limit(velocity_limit, model.velocityLimit, "velocity_limit")
        self.torque_limit = self._limit(torque_limit, model.effortLimit, "torque_limit")
        self.friction_coulomb = self._limit(friction_coulomb, self._zero, "friction_coulomb")
        self.friction_viscous = self._limit(friction_viscous, self._zero, "friction_viscous")
        self._check_limits()
        self.joint_to_motor, self.motor_torque_limit = self._transmission(joint_to_motor, motor_torque_limit)

    @classmethod
    def load(
        cls,
        name: str = "wam7",
        *,
        tool: MassProperties | None = None,
        tool_frame: Pose | None = None,
        base: Pose | None = None,
        gravity: ArrayLike = STANDARD_GRAVITY,
    ) -> ArmModel:
        """Return an arm that ships with the library, with the numbers of its `robot.toml`.

        Args:
            name: Folder in `robots/`.
            tool: Mass properties of the tool on the flange, in flange axes.
            tool_frame: Pose of the controlled frame, `transform_tool_to_flange`; the flange itself by default.
            base: Pose of the base, `transform_base_to_world`; the identity by default.
            gravity: (3,) Acceleration of gravity in world axes [m/s²].

        Raises:
            ModelError: The arm does not exist, or its files disagree.
        """
        folder = read_arm_folder(name)
        arm = cls.from_urdf(
            folder.urdf,
            tool_frame=folder.flange_frame,
            transform_tool_to_frame=tool_frame,
            tool=tool,
            base=base,
            gravity=gravity,
            name=name,
            **folder.numbers,
        )
        if arm.joint_names != folder.joint_names:
            raise ModelError(
                f"{name}: the joints of the URDF, {arm.joint_names}, are not those of robot.toml; correct its names"
            )
        return arm

    @classmethod
    def from_urdf(
        cls,
        path: str | PathLike[str],
        tool_frame: str,
        *,
        transform_tool_to_frame: Pose | None = None,
        tool: MassProperties | None = None,
        base: Pose | None = None,
        gravity: ArrayLike = STANDARD_GRAVITY,
        locked_joints: Sequence[str] | Mapping[str, float] = (),
        name: str | None = None,
        q_lower: ArrayLike | None = None,
        q_upper: ArrayLike | None = None,
        velocity_limit: ArrayLike | None = None,
        torque_limit: ArrayLike | None = None,
        armature: ArrayLike | None = None,
        friction_coulomb: ArrayLike | None = None,
        friction_viscous: ArrayLike | None = None,
        joint_to_motor: ArrayLike | None = None,
        motor_torque_limit: ArrayLike | None = None,
    ) -> ArmModel:
        """Return the arm that a URDF describes.

        Args:
            path: URDF file; meshes are not needed.
            tool_frame: Name of the frame that carries the tool.
            transform_tool_to_frame: Pose of the controlled frame in `tool_frame`; the frame itself by default.
            tool: Mass properties of a tool that the URDF does not hold, in the axes of `tool_frame`.
            base: Pose of the base, `transform_base_to_world`; the identity by default.
            gravity: (3,) Acceleration of gravity in world axes [m/s²].
            locked_joints: Names of joints to hold at their neutral position, or a mapping from name to position.
            name: Name of the arm, for error messages; the file's stem by default.
            q_lower: (nv,) Lower position limits in place of the URDF's [rad].
            q_upper: (nv,) Upper position limits in place of the URDF's [rad].
            velocity_limit: (nv,) Largest speeds in place of the URDF's [rad/s].
            torque_limit: (nv,) Largest torques in place of the URDF's [N·m].
            armature: (nv,) Reflected inertia of the drives [kg·m²].
            friction_coulomb: (nv,) Coulomb friction [N·m].
            friction_viscous: (nv,) Viscous friction [N·m·s/rad].
            joint_to_motor: (nv, nv) Matrix from joint to motor speeds, for motors that share joints.
            motor_torque_limit: (nv,) Largest torques of such motors [N·m].

        Raises:
            ModelError: The file cannot be read, or an argument does not fit it.
        """
        name = Path(path).stem if name is None else name
        model, controlled = read_urdf(
            path,
            tool_frame,
            name,
            transform_tool_to_frame=transform_tool_to_frame,
            tool=tool,
            base=base,
            gravity=gravity,
            locked_joints=locked_joints,
            armature=armature,
        )
        return cls(
            model,
            controlled,
            name=name,
            q_lower=q_lower,
            q_upper=q_upper,
            velocity_limit=velocity_limit,
            torque_limit=torque_limit,
            friction_coulomb=friction_coulomb,
            friction_viscous=friction_viscous,
            joint_to_motor=joint_to_motor,
            motor_torque_limit=motor_torque_limit,
        )

    def __repr__(self) -> str:
        return f"ArmModel({self.name!r}, nv={self.nv}, tool_frame={self.tool_frame!r})"

    @property
    def pinocchio_model(self) -> pin.Model:
        """A copy of the Pinocchio model, for your own computations."""
        return pin.Model(self._model)

    def update(self, q: ArrayLike, v: ArrayLike) -> ArmState:
        """Return a new state with every quantity that a control law needs.

        Args:
            q: (nv,) Joint positions [rad].
            v: (nv,) Joint velocities [rad/s].

        Raises:
            ModelError: A shape is wrong, or a value is not finite.
        """
        nv = self.nv
        if np.shape(q) != (nv,) or np.shape(v) != (nv,):
            raise ModelError(f"{self.name}: q {np.shape(q)} and v {np.shape(v)} must both have the shape ({nv},)")
        x = self._one.copy()
        x[:nv] = q
        x[nv:-1] = v
        # One product is cheaper than isfinite(), and a NaN or infinite entry makes it so too.
        if not isfinite(x.dot(x)):
            raise ModelError(f"{self.name}: q or v holds a value that is not finite: {x.tolist()}")
        q, v = x[:nv], x[nv:-1]
        model, data, frame = self._model, self._thread_data(), self._frame
        M = pin.crba(model, data, q, _WORLD)
        h = pin.nonLinearEffects(model, data, q, v)
        pin.forwardKinematics(model, data, q, v, self._zero)
        # One copy of the placement is cheaper than one of its translation and one of its rotation.
        placement = pin.updateFramePlacement(model, data, frame).homogeneous
        J = pin.getFrameJacobian(model, data, frame, _WORLD_ALIGNED)
        if nv == 1:
            # The bindings return a matrix of one column as a vector.
            M, J = M.reshape(1, 1), J.reshape(6, 1)
        Jdot_v = pin.getFrameClassicalAcceleration(model, data, frame, _WORLD_ALIGNED).vector
        return ArmState(x, q, v, M, h, J, Jdot_v, placement[:3, 3], placement[:3, :3], J.dot(v))

    def _thread_data(self) -> pin.Data:
        """Return Pinocchio's buffers of the present thread."""
        try:
            data: pin.Data = self._buffers.data
        except AttributeError:
            data = self._buffers.data = self._model.createData()
        return data

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name != "_buffers"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state, _buffers=local())
        for value in state.values():
            if isinstance(value, np.ndarray) and value is not self._one:
                value.setflags(write=False)

    def _limit(self, value: ArrayLike | None, default: Array, what: str) -> Array:
        try:
            array = np.array(default if value is None else value, dtype=np.float64)
        except (TypeError, ValueError):
            array = np.empty(0)
        if array.shape != (self.nv,) or np.isnan(array).any():
            joints = ", ".join(self.joint_names)
            raise ModelError(f"{self.name}: {what} must be {self.nv} numbers, one for each of {joints}")
        array.setflags(write=False)
        return array

    def _transmission(
        self, joint_to_motor: ArrayLike | None, limit: ArrayLike | None
    ) -> tuple[Array | None, Array | None]:
        if (joint_to_motor is None) != (limit is None):
            raise ModelError(f"{self.name}: joint_to_motor and motor_torque_limit go together; give both or neither")
        if joint_to_motor is None:
            return None, None
        matrix = np.array(joint_to_motor, dtype=np.float64)
        if (
            matrix.shape != (self.nv, self.nv)
            or not np.isfinite(matrix).all()
            or np.linalg.cond(matrix) > _MAX_CONDITION
        ):
            raise ModelError(f"{self.name}: joint_to_motor must be an invertible matrix ({self.nv}, {self.nv})")
        motors = self._limit(limit, self._zero, "motor_torque_limit")
        if not (motors > 0.0).all():
            raise ModelError(f"{self.name}: motor_torque_limit must be positive; it is {motors.tolist()}")
        shared = (np.count_nonzero(matrix, axis=0) > 1) & (np.abs(matrix).T @ motors > self.torque_limit)
        if shared.any():
            joint = self.joint_names[int(np.argmax(shared))]
            raise ModelError(
                f"{self.name}: the motors give {joint!r} more than its torque_limit; lower motor_torque_limit"
            )
        matrix.setflags(write=False)
        return matrix, motors

    def _check_limits(self) -> None:
        for what, good in (
            ("q_lower < q_upper", self.q_lower < self.q_upper),
            ("velocity_limit > 0", self.velocity_limit > 0.0),
            ("torque_limit > 0", self.torque_limit > 0.0),
            ("friction_coulomb >= 0", (self.friction_coulomb >= 0.0) & np.isfinite(self.friction_coulomb)),
            ("friction_viscous >= 0", (self.friction_viscous >= 0.0) & np.isfinite(self.friction_viscous)),
        ):
            if not good.all():
                joint = self.joint_names[int(np.argmin(good))]
                raise ModelError(f"{self.name}: joint {joint!r} does not have {what}; give the limits as arguments")
