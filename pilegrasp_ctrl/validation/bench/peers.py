"""The ticks of other libraries on the same states: names, work of one tick, and how to install each library."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import partial
from importlib.util import find_spec
from typing import NamedTuple

import numpy as np
import pinocchio as pin
import qpsolvers

from ...control.operational_space import DEFAULT_GAINS
from ...types import Array
from .kinematic_peers import mink_tick, pink_tick
from .motion import RATE, RecordedLine

POSTURE_WEIGHT, POSTURE_STIFFNESS, POSTURE_DAMPING = 1e-4, 100.0, 20.0
"""Weight [-], stiffness [1/s²] and damping [1/s] of the naive tick's posture; the defaults of `PostureTask`."""

HORIZON = 2.0 / RATE
"""Time within which the naive tick keeps speed and position limits [s]: two periods, as the project's limits do."""


class Peer(NamedTuple):
    """The tick of another library.

    Attributes:
        key: Name in the result.
        does: Work of one tick, and the parts that it leaves out.
        requires: Module that the tick imports.
        install: Command that installs it.
        make: Function from the recorded line to the tick; it imports the module.
    """

    key: str
    does: str
    requires: str
    install: str
    make: Callable[[RecordedLine], Callable[[int], object]]

    def tick(self, line: RecordedLine) -> Callable[[int], object] | str:
        """Return its tick on the recorded line after a first call, or the reason why there is none."""
        if find_spec(self.requires) is None:
            return f"not installed; {self.install}"
        try:
            tick = self.make(line)
            tick(0)
        except Exception as error:
            # A broken peer, or another package of the same name, must not stop the benchmark.
            return f"does not work here: {type(error).__name__}: {error}"
        return tick


def naive_tick(line: RecordedLine, solver: str) -> Callable[[int], Array]:
    """Return a tick that solves the project's program without the project's code.

    It is a first implementation: Pinocchio's terms, dense numpy, and a solver behind qpsolvers. Gains, weights, horizon
    and speed and torque limits are the same. Position limits hold a constant acceleration over the horizon. The tick
    has no friction feed-forward, checks nothing, and allocates in every call.

    Args:
        line: States and references.
        solver: Name of the solver in qpsolvers, "osqp" or "daqp".
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
        margin = np.concatenate((arm.torque_limit - h, arm.torque_limit + h))
        with warnings.catch_warnings():
            # qpsolvers warns in every call that it converts dense matrices for OSQP.
            warnings.simplefilter("ignore")
            a = qpsolvers.solve_qp(H, f, G, margin, lb=lower, ub=upper, solver=solver)
        return M @ a + h

    return tick


def _tsid_tick(line: RecordedLine) -> Callable[[int], object]:
    # The module imports tsid, which few machines have.
    from .tsid import tsid_tick

    return tsid_tick(line)


PEERS = (
    Peer(
        "mink",
        "solve_ik with daqp: frame and posture task, position and speed limits; joint velocities, no dynamics",
        "mink",
        "pip install mink",
        mink_tick,
    ),
    Peer(
        "pink",
        "solve_ik with daqp: frame and posture task, position and speed limits; joint velocities, no dynamics",
        "pink",
        "pip install pin-pink",
        pink_tick,
    ),
    Peer(
        "tsid",
        "AccForce formulation in C++ with HQuadProgFast: SE3 and posture task, every limit; torques, no friction",
        "tsid",
        "docs/benchmark.md says how it is built",
        _tsid_tick,
    ),
    *(
        Peer(
            f"naive {solver}",
            f"the project's program in plain numpy, by qpsolvers.solve_qp with {solver}; torques, no friction",
            "qpsolvers",
            f"pip install qpsolvers {solver}",
            partial(naive_tick, solver=solver),
        )
        for solver in ("daqp", "osqp")
    ),
)
"""All peers, in the order of the table."""
