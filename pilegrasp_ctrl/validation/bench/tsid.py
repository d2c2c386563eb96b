"""TSID's tick on the project's control problem, as a comparison and an independent check of the torques.

This module needs the package tsid of the same release as the installed Pinocchio.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
import pinocchio as pin

from ...arm.model import ArmModel
from ...control.operational_space import DEFAULT_GAINS
from ...limits.braking import braking_acceleration
from ...limits.motion_limits import VelocityLimit
from ...tasks.gains import MotionGains
from ...tasks.posture_task import PostureTask
from ...types import Array, Observation, Reference
from .motion import RATE, RecordedLine

with warnings.catch_warnings():
    # The bindings register a type twice and warn of it.
    warnings.simplefilter("ignore", RuntimeWarning)
    import tsid  # type: ignore[import-not-found,import-untyped,unused-ignore]


class TsidController:
    """`InverseDynamicsFormulationAccForce` with an SE3 task, a posture task, torque and joint-speed bounds.

    The tool and the posture share the cost's level, weighted 1 and `posture.weight`; bounds are on the hard level. The
    program is that of `OperationalSpaceController` without friction and position limits. TSID's error of an SE3 task
    is `(p_ref - p, log(R_ref Rᵀ))` in world axes too. Its joint bounds are `(limit - v) / time step`.
    """

    def __init__(
        self,
        arm: ArmModel,
        frame: str,
        posture: PostureTask,
        gains: MotionGains = DEFAULT_GAINS,
        rate: float = RATE,
        positions: bool = False,
    ) -> None:
        """Set up the formulation.

        Args:
            arm: Arm; its Pinocchio model holds the drives' reflected inertia.
            frame: Name of the controlled frame.
            posture: Posture task with a target.
            gains: Gains of the tool's motion [1/s²].
            rate: Control rate [Hz].
            positions: Whether to keep position limits too, by TSID's own bounds, which differ from the project's.
        """
        model = arm.pinocchio_model
        self._robot = tsid.RobotWrapper(model, tsid.FIXED_BASE_SYSTEM, False)
        self._formulation = tsid.InverseDynamicsFormulationAccForce("pilegrasp", self._robot, False)
        self._formulation.computeProblemData(0.0, pin.neutral(model), np.zeros(model.nv))
        self._tool = tsid.TaskSE3Equality("tool", self._robot, frame)
        self._tool.setKp(np.array(gains.stiffness))
        self._tool.setKd(np.array(gains.damping))
        self._tool.useLocalFrame(False)
        self._formulation.addMotionTask(self._tool, 1.0, 1, 0.0)
        joints = tsid.TaskJointPosture("posture", self._robot)
        joints.setKp(np.full(arm.nv, posture.stiffness))
        joints.setKd(np.full(arm.nv, posture.damping))
        preferred = tsid.TrajectorySample(arm.nv)
        preferred.value(np.array(posture.target))
        joints.setReference(preferred)
        self._formulation.addMotionTask(joints, posture.weight, 1, 0.0)
        torque = tsid.TaskActuationBounds("torque", self._robot)
        torque.setBounds(-arm.torque_limit, np.array(arm.torque_limit))
        self._formulation.addActuationTask(torque, 1.0, 0, 0.0)
        bounds = self._position_bounds(arm, rate) if positions else self._speed_bounds(arm, rate)
        self._formulation.addMotionTask(bounds, 1.0, 0, 0.0)
        # The formulation refers to its tasks without owning them.
        self._kept = (joints, torque, bounds)
        self._solver = tsid.SolverHQuadProgFast("solver")
        self._solver.resize(self._formulation.nVar, self._formulation.nEq, self._formulation.nIn)
        self._sample = tsid.TrajectorySample(12, 6)

    def _speed_bounds(self, arm: ArmModel, rate: float) -> tsid.TaskJointBounds:
        limit = VelocityLimit(arm, rate)
        bounds = tsid.TaskJointBounds("joints", self._robot, limit.horizon)
        bounds.setVelocityBounds(-limit.speed, limit.speed)
        bounds.setAccelerationBounds(np.full(arm.nv, -1e10), np.full(arm.nv, 1e10))
        return bounds

    def _position_bounds(self, arm: ArmModel, rate: float) -> tsid.TaskJointPosVelAccBounds:
        limit = VelocityLimit(arm, rate)
        bounds = tsid.TaskJointPosVelAccBounds("joints", self._robot, limit.horizon, False)
        bounds.setPositionBounds(np.array(arm.q_lower), np.array(arm.q_upper))
        bounds.setVelocityBounds(limit.speed)
        bounds.setAccelerationBounds(braking_acceleration(arm))
        # Positions, speeds and that the joint can stop in time; accelerations as such are free.
        bounds.setImposeBounds(True, True, True, False)
        return bounds

    def step(self, observation: Observation, reference: Reference) -> Array:
        """Return the torques (nv,) [N·m] for one control period."""
        pose = reference.pose
        self._sample.value(np.concatenate((pose.translation, pose.rotation.ravel(order="F"))))
        self._sample.derivative(reference.twist)
        self._sample.second_derivative(reference.acceleration)
        self._tool.setReference(self._sample)
        data = self._formulation.computeProblemData(observation.time, observation.q, observation.v)
        solution = self._solver.solve(data)
        return self._formulation.getActuatorForces(solution)


def tsid_tick(line: RecordedLine) -> Callable[[int], Array]:
    """Return TSID's tick: C++ from the state to the torques, called from Python.

    The tick keeps torque, speed and position limits. It has no friction feed-forward and no shared motors, and does
    not say which limits are active.
    """
    controller = TsidController(line.arm, line.source.frame, PostureTask(line.arm, line.source.posture), positions=True)
    observations, references, count = line.observations, line.references, len(line.observations)

    def tick(index: int) -> Array:
        return controller.step(observations[index % count], references[index % count])

    return tick
