"""The arm as the controllers see it: a Pinocchio model, its limits and friction, and one tool frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from os import PathLike
from pathlib import Path

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..exceptions import ModelError
from ..types import STANDARD_GRAVITY, Array, MassProperties, Pose, frozen_array
from .state import ArmState

_JOINT_KEYS = {
    "q_lower": "position_lower",
    "q_upper": "position_upper",
    "velocity_limit": "velocity",
    "torque_limit": "torque_peak",
    "armature": "armature",
    "friction_coulomb": "friction_coulomb",
    "friction_viscous": "friction_viscous",
}
_MOTOR_KEYS = {"joint_to_motor": "joint_to_motor", "motor_torque_limit": "motor_torque_peak"}
_WORLD = pin.Convention.WORLD
_WORLD_ALIGNED = pin.LOCAL_WORLD_ALIGNED


class ArmModel:
    """A fixed-base arm of revolute or prismatic joints, with one tool frame.

    `load` takes an arm that ships, `from_urdf` any other. The model does not change after construction, and its
    limits are read-only arrays.

    Attributes:
        name: the arm's name.
        nv: number of joints.
        joint_names: their names, in the order of every (nv,) array.
        q_lower: (nv,) lower position limits [rad], -inf where there is none.
        q_upper: (nv,) upper position limits [rad].
        velocity_limit: (nv,) largest speeds [rad/s].
        torque_limit: (nv,) largest torques [N·m].
        friction_coulomb: (nv,) Coulomb friction at the joints [N·m], zero where unknown.
        friction_viscous: (nv,) viscous friction at the joints [N·m·s/rad], zero where unknown.
        joint_to_motor: (nv, nv) so that motor speeds are `joint_to_motor v`, where motors share joints; else None.
        motor_torque_limit: (nv,) largest motor torques [N·m]; None with `joint_to_motor`.
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
        """Wrap a Pinocchio model; a copy is kept.

        Args:
            model: a fixed-base model with nq == nv.
            tool_frame: name of the frame that references and Jacobians concern.
            name: how errors call the arm.
            q_lower: (nv,) where it differs from the model's [rad].
            q_upper: (nv,) where it differs from the model's [rad].
            velocity_limit: (nv,) where it differs from the model's [rad/s].
            torque_limit: (nv,) where it differs from the model's [N·m].
            friction_coulomb: (nv,) Coulomb friction [N·m]; zero where absent.
            friction_viscous: (nv,) viscous friction [N·m·s/rad]; zero where absent.
            joint_to_motor: (nv, nv) of a drive in which motors share joints; each joint has its own where absent.
            motor_torque_limit: (nv,) of such a drive's motors [N·m]; needed with `joint_to_motor`.

        Raises:
            ModelError: where the frame is unknown, a joint is not revolute or prismatic, or a limit makes no sense.
        """
        if model.nq != model.nv:
            odd = [model.names[i] for i in range(1, model.njoints) if model.joints[i].nq != model.joints[i].nv]
            raise ModelError(f"{name}: joint {odd[0]!r} is not a revolute or prismatic one; lock it or give it limits")
        if not model.existFrame(tool_frame):
            known = ", ".join(frame.name for frame in model.frames[-8:])
            raise ModelError(f"{name}: no frame {tool_frame!r} for the tool; the last ones of the model are {known}")
        self.name = name
        self.nv: int = model.nv
        self.joint_names = tuple(model.names)[1:]
        self._model = pin.Model(model)
        self._data = self._model.createData()
        self._frame = self._model.getFrameId(tool_frame)
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
        """Return an arm that ships with the library, numbers from its `robot.toml`.

        Args:
            name: a folder of `robots/`.
            tool: what the flange carries, in flange axes.
            tool_frame: `transform_tool_to_flange`; the flange itself where absent.
            base: `transform_base_to_world`; the identity where absent.
            gravity: (3,) acceleration in the world's axes [m/s²].

        Raises:
            ModelError: where there is no such arm, or its files disagree.
        """
        from ..robots import description, path

        table = description(name)
        try:
            robot, joints = table["robot"], table["joints"]
            urdf, flange, names = path(name, robot["urdf"]), robot["flange_frame"], tuple(joints["names"])
            numbers = {argument: joints[key] for argument, key in _JOINT_KEYS.items()}
            if "transmission" in table:
                for argument, key in _MOTOR_KEYS.items():
                    numbers[argument] = table["transmission"][key]
        except KeyError as error:
            raise ModelError(f"{name}: its robot.toml has no key {error}, so it is not an arm to load") from None
        arm = cls.from_urdf(
            urdf,
            tool_frame=flange,
            transform_tool_to_frame=tool_frame,
            tool=tool,
            base=base,
            gravity=gravity,
            name=name,
            **numbers,
        )
        if arm.joint_names != names:
            raise ModelError(f"{name}: the joints of the URDF, {arm.joint_names}, are not those of robot.toml")
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
            path: the URDF file; meshes are not needed.
            tool_frame: name of the frame that carries the tool.
            transform_tool_to_frame: pose of the controlled frame in `tool_frame`; the frame itself where absent.
            tool: what `tool_frame` carries beyond the URDF, in its axes.
            base: `transform_base_to_world`; the identity where absent.
            gravity: (3,) acceleration in the world's axes [m/s²].
            locked_joints: names of joints to hold at their neutral position, or a mapping from name to position.
            name: how errors call the arm; the file's stem where absent.
            q_lower: (nv,) instead of the URDF's [rad].
            q_upper: (nv,) instead of the URDF's [rad].
            velocity_limit: (nv,) instead of the URDF's [rad/s].
            torque_limit: (nv,) instead of the URDF's [N·m].
            armature: (nv,) reflected inertia of the drives [kg·m²].
            friction_coulomb: (nv,) Coulomb friction [N·m].
            friction_viscous: (nv,) viscous friction [N·m·s/rad].
            joint_to_motor: (nv, nv) of a drive in which motors share joints.
            motor_torque_limit: (nv,) of such a drive's motors [N·m].

        Raises:
            ModelError: where the file cannot be read or an argument does not fit it.
        """
        path = Path(path)
        name = path.stem if name is None else name
        if not path.is_file():
            raise ModelError(f"{path}: no such URDF file")
        try:
            model = pin.buildModelFromUrdf(str(path))
        except (ValueError, RuntimeError) as error:
            raise ModelError(f"{path}: is not a URDF that Pinocchio can read: {error}") from error
        model.gravity.linear = frozen_array(gravity, (3,), "gravity")
        model = _lock(model, locked_joints, name)
        if not model.existFrame(tool_frame):
            known = ", ".join(frame.name for frame in model.frames if frame.type == pin.FrameType.BODY)
            raise ModelError(f"{name}: no frame {tool_frame!r} for the tool; the links are {known}")
        if base is not None:
            _place_base(model, base)
        if armature is not None:
            if np.shape(armature) != (model.nv,) or not np.all(np.asarray(armature) >= 0.0):
                raise ModelError(f"{name}: armature must be {model.nv} numbers that are not negative")
            model.armature = np.array(armature, dtype=np.float64)
        frame = model.frames[model.getFrameId(tool_frame)]
        if tool is not None:
            body = pin.Inertia(tool.mass, np.array(tool.center_of_mass), np.array(tool.inertia))
            model.appendBodyToJoint(frame.parentJoint, body, frame.placement)
        controlled = tool_frame
        if transform_tool_to_frame is not None:
            controlled = f"{tool_frame}_tool"
            placement = frame.placement * _se3(transform_tool_to_frame)
            parent = model.getFrameId(tool_frame)
            model.addFrame(pin.Frame(controlled, frame.parentJoint, parent, placement, pin.FrameType.OP_FRAME))
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

    @property
    def pinocchio_model(self) -> pin.Model:
        """A copy of the Pinocchio model, for computations of one's own."""
        return pin.Model(self._model)

    def update(self, q: ArrayLike, v: ArrayLike) -> ArmState:
        """Return a new state with everything a control law needs.

        Args:
            q: (nv,) joint positions [rad].
            v: (nv,) joint velocities [rad/s].

        Raises:
            ModelError: where a shape is wrong or a value is not finite.
        """
        nv = self.nv
        if np.shape(q) != (nv,) or np.shape(v) != (nv,):
            raise ModelError(f"{self.name}: q {np.shape(q)} and v {np.shape(v)} must both have the shape ({nv},)")
        x = self._one.copy()
        x[:nv] = q
        x[nv:-1] = v
        # One product is cheaper than isfinite(), and is not finite where an entry is not.
        if not isfinite(x.dot(x)):
            raise ModelError(f"{self.name}: q or v holds a value that is not finite: {x.tolist()}")
        q, v = x[:nv], x[nv:-1]
        model, data, frame = self._model, self._data, self._frame
        # In world convention the composite rigid bodies leave the joint Jacobians behind.
        M = pin.crba(model, data, q, _WORLD)
        h = pin.nonLinearEffects(model, data, q, v)
        pin.forwardKinematics(model, data, q, v, self._zero)
        # One copy of the placement is cheaper than one of its translation and one of its rotation.
        placement = pin.updateFramePlacement(model, data, frame).homogeneous
        J = pin.getFrameJacobian(model, data, frame, _WORLD_ALIGNED)
        Jdot_v = pin.getFrameClassicalAcceleration(model, data, frame, _WORLD_ALIGNED).vector
        return ArmState(x, q, v, M, h, J, Jdot_v, placement[:3, 3], placement[:3, :3], J.dot(v))

    def _limit(self, value: ArrayLike | None, default: Array, what: str) -> Array:
        array = np.array(default if value is None else value, dtype=np.float64)
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
        if matrix.shape != (self.nv, self.nv) or not np.isfinite(matrix).all() or np.linalg.cond(matrix) > 1e6:
            raise ModelError(f"{self.name}: joint_to_motor must be an invertible matrix ({self.nv}, {self.nv})")
        motors = self._limit(limit, self._zero, "motor_torque_limit")
        if not (motors > 0.0).all():
            raise ModelError(f"{self.name}: motor_torque_limit must be positive; it is {motors.tolist()}")
        shared = (np.count_nonzero(matrix, axis=0) > 1) & (np.abs(matrix).T @ motors > self.torque_limit)
        if shared.any():
            joint = self.joint_names[int(np.argmax(shared))]
            raise ModelError(f"{self.name}: the motors give {joint!r} more than its torque_limit; lower one of the two")
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


def _se3(pose: Pose) -> pin.SE3:
    return pin.SE3(np.array(pose.rotation), np.array(pose.translation))


def _lock(model: pin.Model, joints: Sequence[str] | Mapping[str, float], name: str) -> pin.Model:
    if not joints:
        return model
    q = pin.neutral(model)
    for joint in joints:
        if not model.existJointName(joint):
            raise ModelError(f"{name}: no joint {joint!r} to lock; the joints are {', '.join(list(model.names)[1:])}")
        if isinstance(joints, Mapping):
            q[model.joints[model.getJointId(joint)].idx_q] = joints[joint]
    return pin.buildReducedModel(model, [model.getJointId(joint) for joint in joints], q)


def _place_base(model: pin.Model, base: Pose) -> None:
    transform = _se3(base)
    for joint in range(1, model.njoints):
        if model.parents[joint] == 0:
            model.jointPlacements[joint] = transform * model.jointPlacements[joint]
    for frame in model.frames[1:]:
        if frame.parentJoint == 0:
            frame.placement = transform * frame.placement
