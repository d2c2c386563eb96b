"""The control tick as one writes it at first: Pinocchio's terms, dense numpy, and a solver behind qpsolvers."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
import pinocchio as pin
import qpsolvers

from ...control.operational_space import DEFAULT_GAINS
from ...types import Array
from .motion import RATE, RecordedLine

POSTURE_WEIGHT, POSTURE_STIFFNESS, POSTURE_DAMPING = 1e-4, 100.0, 20.0
HORIZON = 2.0 / RATE


def naive_tick(line: RecordedLine, solver: str) -> Callable[[int], Array]:
    """Return a tick that solves the project's program without the project's code.

    The same gains, weights, horizon and speed and torque limits; position limits by a constant acceleration over the
    horizon. It has no friction feed-forward, checks nothing, and allocates as it goes.

    Args:
        line: states and references.
        solver: as qpsolvers calls it, "osqp" or "daqp".
    """
    arm = line.arm
    model = arm.pinocchio_model
    data, frame = model.createData(), model.getFrameId(line.source.frame)
    stiffness, damping = DEFAULT_GAINS.stiffness, DEFAULT_GAINS.damping
    observations, references, count = line.observations, line.references, len(line.observations)

    def tick(index: int) -> Array:
        observation, reference = observations[index % count], references[index % count]
        q, v = observation.q, observation.v
        pin.computeAllTerms(model, data, q, v)
        pin.updateFramePlacements(model, data)
        pin.forwardKinematics(model, data, q, v, np.zeros(model.nv))
        M, h, placement = data.M.copy(), data.nle.copy(), data.oMf[frame]
        J = pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)
        drift = pin.getFrameClassicalAcceleration(model, data, frame, pin.LOCAL_WORLD_ALIGNED).vector
        error = np.concatenate(
            (
                reference.pose.translation - placement.translation,
                pin.log3(reference.pose.rotation @ placement.rotation.T),
            )
        )
        wanted = reference.acceleration + damping * (reference.twist - J @ v) + stiffness * error
        posture = POSTURE_STIFFNESS * (line.source.posture - q) - POSTURE_DAMPING * v
        H = J.T @ J + POSTURE_WEIGHT * np.eye(model.nv)
        f = J.T @ (drift - wanted) - POSTURE_WEIGHT * posture
        lower = np.maximum((-arm.velocity_limit - v) / HORIZON, 2.0 * (arm.q_lower - q - HORIZON * v) / HORIZON**2)
        upper = np.minimum((arm.velocity_limit - v) / HORIZON, 2.0 * (arm.q_upper - q - HORIZON * v) / HORIZON**2)
        G = np.vstack((M, -M))
        room = np.concatenate((arm.torque_limit - h, arm.torque_limit + h))
        with warnings.catch_warnings():
            # qpsolvers says in every call that it converts dense matrices for OSQP.
            warnings.simplefilter("ignore")
            a = qpsolvers.solve_qp(H, f, G, room, lb=lower, ub=upper, solver=solver)
        return M @ a + h

    return tick
