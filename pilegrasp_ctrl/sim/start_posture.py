"""Joint angles for a tool pose, by differential inverse kinematics with limits (mink)."""

from __future__ import annotations

import mink
import mujoco
import numpy as np

from ..exceptions import ModelError, UnreachablePoseError
from ..planning.simulated_arm import simulated_arm
from ..types import Array, Pose
from ..vectors import norm, product, rotated
from .arm_body import file_of, mount_arm

POSITION_TOLERANCE = 1e-4
"""Largest distance of the tool from its pose [m], chosen."""

ORIENTATION_TOLERANCE = 1e-3
"""Largest rotation of the tool from its pose [rad], chosen."""

MARGIN = 0.05
"""Distance of the start posture from the joint limits [rad], chosen."""

TIME_STEP = 0.1
"""Time step of a search iteration [s], chosen."""

MAX_ITERATIONS = 300
"""Largest number of iterations from one initial posture [-], chosen."""

DECIMALS = 6
"""Decimals of a start posture [-], chosen: 1e-6 rad moves the tool by a hundredth of `POSITION_TOLERANCE`. The search
uses BLAS, which makes its angles differ by 1e-12 rad between processors; rounding takes that away."""

SETTLED_MOTION = 1e-6
"""Largest joint motion in an iteration at which the posture task is dropped and only the tool task is left [rad],
chosen."""


class StartPosture:
    """Search for the joint angles of a tool pose, with a model of the bare arm and a site at the tool frame."""

    def __init__(self, robot: str, transform_tool_to_flange: Pose, transform_base_to_world: Pose) -> None:
        described = simulated_arm(robot)
        file = file_of(described)
        spec = mujoco.MjSpec.from_file(file) if file else mujoco.MjSpec()
        if file is None:
            spec.compiler.degree = False
        flange = mount_arm(spec, described).flange
        rotation = np.zeros(9)
        mujoco.mju_quat2Mat(rotation, flange.quat)
        flange_rotation = rotation.reshape(3, 3)
        quaternion = np.zeros(4)
        mujoco.mju_mat2Quat(quaternion, product(flange_rotation, transform_tool_to_flange.rotation).ravel())
        flange.parent.add_site(
            name="tool",
            pos=flange.pos + rotated(flange_rotation, transform_tool_to_flange.translation),
            quat=quaternion,
        )
        try:
            self._model = spec.compile()
        except (ValueError, RuntimeError) as error:
            raise ModelError(f"{robot}: MuJoCo cannot simulate it: {' '.join(str(error).split())}") from None
        self._base = transform_base_to_world
        self._postures = list(described.postures)

    def solve(self, pose: Pose, start: Array | None = None) -> Array:
        """Return joint angles (nv,) [rad] for the tool frame at `pose` in the world.

        The search starts from `start`, if given, and then from each of the robot's search postures.

        Raises:
            UnreachablePoseError: No search reaches the pose within the joint limits.
        """
        return self._solve(pose, ([start] if start is not None else []) + self._postures)

    def solve_near(self, pose: Pose, start: Array) -> Array:
        """Return joint angles (nv,) [rad] for `pose` near `start`, for example at the end of a straight motion.

        Raises:
            UnreachablePoseError: The search from `start` does not reach the pose within the joint limits.
        """
        return self._solve(pose, [start])

    def _solve(self, pose: Pose, guesses: list[Array]) -> Array:
        target = self._base.inverse() @ pose
        nearest = np.inf
        for guess in guesses:
            q, position_error, orientation_error = self._descend(target, guess)
            if position_error < POSITION_TOLERANCE and orientation_error < ORIENTATION_TOLERANCE:
                return q
            nearest = min(nearest, position_error)
        x, y, z = pose.translation
        raise UnreachablePoseError(
            f"the hand cannot reach ({x:.2f}, {y:.2f}, {z:.2f}) m with this orientation within the joint limits "
            f"(it stays {1000 * nearest:.0f} mm short); change strategy.alpha_deg, beta_deg, theta_deg or clearance, "
            "pile.count or frame_size, or for a line line.start or line.displacement"
        )

    def _descend(self, target: Pose, guess: Array) -> tuple[Array, float, float]:
        configuration = mink.Configuration(self._model, q=np.asarray(guess, dtype=float))
        tool = mink.FrameTask("tool", "site", position_cost=1.0, orientation_cost=0.3, lm_damping=1e-3)
        tool.set_target(
            mink.SE3.from_rotation_and_translation(mink.SO3.from_matrix(target.rotation), target.translation)
        )
        posture = mink.PostureTask(self._model, cost=1e-3)
        posture.set_target(np.asarray(guess, dtype=float))
        limits = [mink.ConfigurationLimit(self._model, min_distance_from_limits=MARGIN)]
        tasks = [tool, posture]
        for iteration in range(MAX_ITERATIONS):
            velocity = mink.solve_ik(configuration, tasks, TIME_STEP, "daqp", damping=1e-6, limits=limits)
            configuration.integrate_inplace(velocity, TIME_STEP)
            error = tool.compute_error(configuration)
            if len(tasks) == 1 and norm(error) < 0.5 * POSITION_TOLERANCE:
                break
            if iteration + 1 >= MAX_ITERATIONS // 2 or np.abs(velocity).max() * TIME_STEP < SETTLED_MOTION:
                tasks = [tool]
        return np.round(configuration.q, DECIMALS), norm(error[:3]), norm(error[3:])
