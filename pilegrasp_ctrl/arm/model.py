"""The controllers' model of an arm: a Pinocchio model with limits, joint friction and one tool frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from math import isfinite
from os import PathLike
from typing import Any, Unpack, cast

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..exceptions import ModelError
from ..kernels.algebra import length_square, multiply
from ..types import Array, MassProperties, Pose, frozen_array
from .buffers import Buffers
from .controllability import check_model, check_strength
from .frames import add_body, add_frame, frame_id, place_base
from .joint_numbers import check_numbers, joint_array, transmission
from .joints import check_joints, simple_joints
from .loading import read_arm_folder, read_model
from .options import NUMBERS, ArmOptions, checked, merged
from .state import ArmState, FrameState

_WORLD = pin.Convention.WORLD
"""Convention of `pin.crba` in which it also computes the joint Jacobians."""
_WORLD_ALIGNED = pin.LOCAL_WORLD_ALIGNED
"""Frame of Jacobian and acceleration: at the tool frame's origin, in world axes."""


class ArmModel:
    """A fixed-base arm of revolute or prismatic joints, with one tool frame.

    `load` makes an arm from a folder, `from_urdf` and `from_mjcf` from a file, and the constructor from a Pinocchio
    model. An arm that cannot be controlled is refused, with the name of the joint. The model does not change after
    construction, and its limits are read-only arrays. Threads may share it: each has buffers of its own. `replace` and
    `with_payload` make changed copies.

    Attributes:
        name: Name of the arm, for error messages.
        tool_frame: Name of the controlled frame.
        nv: Number of joints.
        joint_names: Names of the joints, in the order of every (nv,) array.
        q_lower: (nv,) Lower position limits [rad], -inf where there is none.
        q_upper: (nv,) Upper position limits [rad], inf where there is none.
        velocity_limit: (nv,) Largest speeds [rad/s], inf where there is no limit.
        torque_limit: (nv,) Largest torques [N·m], finite.
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
        transform_tool_to_frame: Pose | None = None,
        tool: MassProperties | None = None,
        base: Pose | None = None,
        gravity: ArrayLike | None = None,
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
    ) -> None:
        """Wrap a copy of a Pinocchio model.

        Args:
            model: Fixed-base model of revolute, continuous and prismatic joints. A continuous joint becomes a revolute
                joint without position limits, so that every joint has one coordinate.
            tool_frame: Name of the frame that carries the tool.
            transform_tool_to_frame: Pose of the controlled frame in `tool_frame`; the frame itself by default.
            tool: Mass properties of a tool that the model does not hold, in the axes of `tool_frame`.
            base: Pose of the model's base, `transform_base_to_world`; the identity by default.
            gravity: (3,) Acceleration of gravity in world axes in place of the model's [m/s²].
            name: Name of the arm, for error messages; "arm" by default.
            q_lower: (nv,) Lower position limits in place of the model's [rad], -inf for none.
            q_upper: (nv,) Upper position limits in place of the model's [rad], inf for none.
            velocity_limit: (nv,) Largest speeds in place of the model's [rad/s], inf for none.
            torque_limit: (nv,) Largest torques in place of the model's [N·m].
            armature: (nv,) Reflected inertia of the drives in place of the model's [kg·m²].
            friction_coulomb: (nv,) Coulomb friction [N·m]; zero by default.
            friction_viscous: (nv,) Viscous friction [N·m·s/rad]; zero by default.
            joint_to_motor: (nv, nv) Matrix from joint to motor speeds, for motors that share joints; by default each
                joint has its own motor.
            motor_torque_limit: (nv,) Largest torques of such motors [N·m]; required with `joint_to_motor`.

        Raises:
            ModelError: The arm cannot be controlled, or an argument does not fit it.
        """
        self.name = checked("name", "arm" if name is None else name, str)
        self._model = model = simple_joints(checked("model", model, pin.Model))
        check_joints(model, {}, self.name)
        if gravity is not None:
            model.gravity.linear = frozen_array(gravity, (3,), "gravity")
        if base is not None:
            place_base(model, checked("base", base, Pose))
        self.nv: int = model.nv
        self.joint_names = tuple(model.names)[1:]
        self._frame = frame_id(model, tool_frame, self.name)
        if tool is not None:
            add_body(model, self._frame, checked("tool", tool, MassProperties))
        if transform_tool_to_frame is not None:
            transform = checked("transform_tool_to_frame", transform_tool_to_frame, Pose)
            self._frame = add_frame(model, self._frame, transform)
        self.tool_frame: str = model.frames[self._frame].name
        self._buffers = Buffers()
        self._frames: dict[str, int] = {}
        self._zero = np.zeros(self.nv)
        self._one = np.zeros(2 * self.nv + 1)
        self._one[-1] = 1.0
        self.q_lower = self._numbers(q_lower, model.lowerPositionLimit, "q_lower")
        self.q_upper = self._numbers(q_upper, model.upperPositionLimit, "q_upper")
        self.velocity_limit = self._numbers(velocity_limit, model.velocityLimit, "velocity_limit")
        self.torque_limit = self._numbers(torque_limit, model.effortLimit, "torque_limit")
        self.friction_coulomb = self._numbers(friction_coulomb, self._zero, "friction_coulomb")
        self.friction_viscous = self._numbers(friction_viscous, self._zero, "friction_viscous")
        model.armature = self._numbers(armature, model.armature, "armature")
        check_numbers({**vars(self), "armature": model.armature}, self.name, self.joint_names)
        self.joint_to_motor, self.motor_torque_limit = transmission(
            joint_to_motor, motor_torque_limit, self.torque_limit, self.name, self.joint_names
        )
        check_model(model, self._frame, self.q_lower, self.q_upper, self.name)
        self._check_strength()

    @classmethod
    def load(cls, name: str | PathLike[str] = "wam7", *, tool_frame: Pose | None = None, **options: Any) -> ArmModel:
        """Return an arm from its folder, with the numbers of its `robot.toml`.

        Args:
            name: Name of an arm that ships with the library (a folder in `robots/`), or path of a folder.
            tool_frame: Pose of the controlled frame, `transform_tool_to_flange`; the flange itself by default.
            **options: Keyword arguments of `ArmModel`, in place of what the folder says; `tool` is in flange axes.

        Raises:
            ModelError: The arm does not exist, or its files disagree.
        """
        folder = read_arm_folder(name)
        given = merged(folder.options, {"transform_tool_to_frame": tool_frame}, cast(ArmOptions, options))
        read, numbers = read_model(
            folder.model, folder.flange_frame, folder.joint_names, folder.locked_joints, given, folder.without
        )
        arm = cls(read, folder.flange_frame, **numbers)
        if arm.joint_names != folder.joint_names:
            raise ModelError(
                f"{arm.name}: robot.toml must name the joints, and give their numbers, in the order of the model: "
                f"{', '.join(arm.joint_names)}"
            )
        return arm

    @classmethod
    def from_urdf(
        cls,
        path: str | PathLike[str],
        tool_frame: str,
        *,
        joints: Sequence[str] | int | None = None,
        locked_joints: Sequence[str] | Mapping[str, float] = (),
        **options: Unpack[ArmOptions],
    ) -> ArmModel:
        """Return the arm that a URDF describes; an MJCF is read as `from_mjcf` reads it.

        Args:
            path: URDF file; meshes are not needed.
            tool_frame: Name of the frame that carries the tool.
            joints: Names of the joints to keep, or a number N for the first N movable joints between base and tool
                frame; all others are locked. By default every joint is kept.
            locked_joints: Names of joints to hold at their neutral position, or a mapping from name to position.
            **options: Keyword arguments of `ArmModel`; `name` is the file's by default. `<dynamics>` is not read.

        Raises:
            ModelError: The file cannot be read, the arm cannot be controlled, or an argument does not fit it.
        """
        read, numbers = read_model(path, tool_frame, joints, locked_joints, options)
        return cls(read, tool_frame, **numbers)

    @classmethod
    def from_mjcf(
        cls,
        model: Any,
        tool_frame: str,
        *,
        joints: Sequence[str] | int | None = None,
        locked_joints: Sequence[str] | Mapping[str, float] = (),
        **options: Unpack[ArmOptions],
    ) -> ArmModel:
        """Return the arm in a MuJoCo model; a URDF is read as `from_urdf` reads it.

        Joint positions equal MuJoCo's `qpos`. Position limits, armature, viscous friction (damping), Coulomb friction
        (frictionloss), gravity and the pose of the base are the model's. Torque limits are those of the joints
        (actuatorfrcrange) and of the actuators: forcerange, or ctrlrange of a motor, times gear. A MuJoCo model has no
        velocity limits: without `velocity_limit` the speeds are not limited.

        Args:
            model: MJCF file, `mujoco.MjSpec` or `mujoco.MjModel`. Meshes are needed only where a body takes its mass
                from them. Other bodies may be in the model, as in a scene.
            tool_frame: Name of the body or site that carries the tool.
            joints: Joints to keep, as for `from_urdf`.
            locked_joints: Names of joints to hold at their position in the file, or a mapping from name to `qpos`.
            **options: Keyword arguments of `ArmModel`; `base` places the world of the MuJoCo model.

        Raises:
            ModelError: The model cannot be read, the arm cannot be controlled, or an argument does not fit it.
        """
        read, numbers = read_model(model, tool_frame, joints, locked_joints, options)
        return cls(read, tool_frame, **numbers)

    def replace(self, **changes: Any) -> ArmModel:
        """Return a copy with other numbers, such as `arm.replace(torque_limit=0.5 * arm.torque_limit)`.

        Args:
            **changes: Numbers of the joints, `name` and `gravity` as the constructor takes them; None stands for its
                default, such as no friction. `model` is a changed `pinocchio_model` with the same joints and frames.

        Raises:
            ModelError: A name is unknown, or a number does not fit the arm.
        """
        allowed = ("model", "name", "gravity", *NUMBERS)
        for change in changes:
            if change not in allowed:
                raise ModelError(
                    f"{self.name}: cannot replace {change!r}; what can be replaced is {', '.join(allowed)}"
                )
        kept = {name: getattr(self, name) for name in ("name", *NUMBERS) if name != "armature"}
        model = changes.pop("model", self._model)
        return type(self)(model, self.tool_frame, **{**kept, **changes})

    def with_payload(self, mass: float, center_of_mass: ArrayLike, inertia: ArrayLike | None = None) -> ArmModel:
        """Return a copy whose tool carries a further body, such as an object that was just grasped.

        It takes a fraction of a millisecond. The copy has the limits and names of this arm, which stays as it is.

        Args:
            mass: Mass of the payload [kg].
            center_of_mass: (3,) Its centre of mass in the tool frame [m].
            inertia: (3, 3) Its inertia about the centre of mass, in the tool frame's axes [kg·m²]; zero by default.

        Raises:
            ArgumentError: A number is not a mass, a position or an inertia.
            ModelError: A joint could not carry the payload in any posture.
        """
        about = np.zeros((3, 3)) if inertia is None else inertia
        body = MassProperties(mass, cast(Array, center_of_mass), cast(Array, about))
        loaded = copy(self)
        loaded._buffers = Buffers()
        loaded._model = pin.Model(self._model)
        add_body(loaded._model, self._frame, body)
        loaded._check_strength()
        return loaded

    def _check_strength(self) -> None:
        check_strength(self._model, self.q_lower, self.q_upper, self.torque_limit - self.friction_coulomb, self.name)

    def _numbers(self, value: ArrayLike | None, default: Array, what: str) -> Array:
        return joint_array(default if value is None else value, what, self.name, self.joint_names)

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
        for value in (q, v):
            # np.shape costs an array more than the rest of the check.
            if (value.shape if type(value) is np.ndarray else np.shape(value)) != (nv,):
                raise ModelError(f"{self.name}: q {np.shape(q)} and v {np.shape(v)} must both have the shape ({nv},)")
        x = self._one.copy()
        x[:nv] = q
        x[nv:-1] = v
        # One sum is cheaper than isfinite(), and a NaN or infinite entry makes it so too.
        if not isfinite(length_square(x)):
            raise ModelError(f"{self.name}: q or v holds a value that is not finite: {x.tolist()}")
        q, v = x[:nv], x[nv:-1]
        model, data = self._model, self._buffers.of(self._model)
        M = pin.crba(model, data, q, _WORLD)
        h = pin.nonLinearEffects(model, data, q, v)
        pin.forwardKinematics(model, data, q, v, self._zero)
        self._buffers.x = x
        if nv == 1:  # the bindings return a matrix of one column as a vector
            M = M.reshape(1, 1)
        return ArmState(x, q, v, M, h, *self._read_frame(data, self._frame, v), self)

    def check_frame(self, name: str) -> str:
        """Return the name of a frame of the model.

        Raises:
            ModelError: The model has no frame of this name.
        """
        if name not in self._frames:
            self._frames[name] = frame_id(self._model, name, self.name)
        return name

    def frame_state(self, state: ArmState, name: str) -> FrameState:
        """Return the kinematics of the frame `name` at a state; `ArmState.frame` is the short form.

        Raises:
            ModelError: The model has no frame of this name.
        """
        if name == self.tool_frame:
            return state.tool
        index = self._frames[self.check_frame(name)]
        model, data = self._model, self._buffers.of(self._model)
        # Pinocchio's buffers hold the last state of this thread, which is nearly always the one that is asked about.
        if self._buffers.x is not state.x:
            pin.computeJointJacobians(model, data, state.q)
            pin.forwardKinematics(model, data, state.q, state.v, self._zero)
            self._buffers.x = state.x
        return self._read_frame(data, index, state.v)

    def _read_frame(self, data: pin.Data, index: int, v: Array) -> FrameState:
        """Return the kinematics of a frame at the state that Pinocchio's buffers hold."""
        # One copy of the placement is cheaper than one of its translation and one of its rotation.
        placement = pin.updateFramePlacement(self._model, data, index).homogeneous
        J = pin.getFrameJacobian(self._model, data, index, _WORLD_ALIGNED)
        if self.nv == 1:
            J = J.reshape(6, 1)
        Jdot_v = pin.getFrameClassicalAcceleration(self._model, data, index, _WORLD_ALIGNED).vector
        twist = np.empty(6)
        multiply(J, v, twist)
        return FrameState(J, Jdot_v, placement[:3, 3], placement[:3, :3], twist)

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        for value in state.values():
            if isinstance(value, np.ndarray) and value is not self._one:
                value.setflags(write=False)
