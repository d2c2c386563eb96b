"""Print how well the operational-space controller tracks a straight line on arms of published packages, as a table.

Usage: python docs/studies/arm_table.py [NAME...]

Every arm of example-robot-data with 3 to 13 joints and three MuJoCo models follow a line of 0.2 m in `ArmSimulation`,
from a posture that a rule chooses. An arm whose limits or reach do not allow the line says so. No physics engine runs.
All arms take about half a minute on one core.
"""

from __future__ import annotations

import warnings
from itertools import product
from typing import NamedTuple

import numpy as np
from rich.console import Console
from rich.progress import track

from pilegrasp_ctrl.arm.controllability import spread_postures
from pilegrasp_ctrl.arm.model import ArmModel
from pilegrasp_ctrl.control.operational_space import OperationalSpaceController
from pilegrasp_ctrl.exceptions import ConfigurationError, ModelWarning, PilegraspError, remedy_for
from pilegrasp_ctrl.plant.arm_simulation import ArmSimulation
from pilegrasp_ctrl.plant.tracking import simulate_tracking
from pilegrasp_ctrl.statistics import markdown_table
from pilegrasp_ctrl.tasks.gains import MotionGains
from pilegrasp_ctrl.trajectories.straight_line import StraightLine
from pilegrasp_ctrl.types import Array
from published_arms import PublishedArm, example_arms, mujoco_arms
from script import run_script

LENGTH = 0.2
"""Length of the line [m]."""

MOST_ERROR = 2e-4
"""Largest error of the tool's position that counts as tracking [m]."""

SPEED = 0.1
"""Speed along the line [m/s], where the joints allow it; chosen as the speed of a push."""

SPEED_SHARE = 0.5
"""Share of the joints' speed limits that the line may use [-]; chosen."""

TORQUE_SHARE = 0.8
"""Share of the joints' torque limits, less friction, that gravity may use at the start and on the line; chosen."""

MARGIN = 0.1
"""Distance from the position limits on the line, over the range of the joint [-]; chosen."""

MOST_MARGIN = 0.15
"""Largest such distance [rad or m]; chosen."""

LEAST_DEXTERITY = 0.01
"""Smallest singular value that a line may have [m]; chosen, a tenth of `RADIUS`."""

GAINS = MotionGains(stiffness=2500.0)
"""Gains of the tool's motion [1/s²]; chosen above the default, because a light arm with friction gives way more."""

HOLD = 0.5
"""Time that the reference rests at the end of the line [s]; chosen."""

STEPS = 40
"""Number of steps in which a line is tried before it is simulated; chosen."""

POSTURES = 400
"""Number of postures among which the start is chosen; chosen."""

TRIED = 40
"""Number of the best postures from which lines are tried; chosen."""

SIX_AXES = 6
"""Number of joints from which on the tool's orientation is held too."""

RADIUS = 0.1
"""Length that makes a rotation comparable with a translation [m]; chosen, the size of a hand."""

HEADER = ("arm", "joints", "tool frame", "axes", "defaults for", "speed [m/s]", "peak error [mm]", "result")


class Line(NamedTuple):
    """A line that an arm can follow.

    Attributes:
        q: (nv,) Joint positions at the start.
        displacement: (3,) Displacement [m].
        speed: Speed [m/s].
        dexterity: Smallest singular value of the controlled rows of the Jacobian on the line [m].
    """

    q: Array
    displacement: Array
    speed: float
    dexterity: float


def margin_of(arm: ArmModel, q: Array) -> float:
    """Return the distance from the nearest position limit, over the one that is kept; infinite without limits."""
    kept = np.minimum(MARGIN * (arm.q_upper - arm.q_lower), MOST_MARGIN)
    return float((np.minimum(q - arm.q_lower, arm.q_upper - q) / kept).min())


def effort_of(arm: ArmModel, gravity: Array) -> float:
    """Return the share of the torque limits, less friction, that gravity takes."""
    return float((np.abs(gravity) / (arm.torque_limit - arm.friction_coulomb)).max())


def scaled(J: Array, axes: int) -> Array:
    """Return the rows of a Jacobian that are controlled, rotations as lengths at `RADIUS` [m]."""
    return np.vstack((J[:3], RADIUS * J[3:]))[:axes]


def starts(arm: ArmModel, axes: int) -> list[Array]:
    """Return the postures that are farthest from singular ones, away from limits, and can be held; the best first."""
    found = []
    for q in spread_postures(arm.q_lower, arm.q_upper, POSTURES):
        state = arm.update(q, np.zeros(arm.nv))
        least = np.linalg.svd(scaled(state.J, axes), compute_uv=False)[-1]
        if margin_of(arm, q) > 2.0 and effort_of(arm, state.h) < TORQUE_SHARE:
            found.append((least, q))
    return [q for _, q in sorted(found, key=lambda pair: -pair[0])]


def line_from(arm: ArmModel, start: Array, displacement: Array, axes: int) -> Line | None:
    """Return the line from a posture; None where a position limit, or torque for gravity, is missing on it."""
    q, step = start, displacement / STEPS
    speed, dexterity = SPEED, np.inf
    for _ in range(STEPS):
        state = arm.update(q, np.zeros(arm.nv))
        if margin_of(arm, q) < 1.0 or effort_of(arm, state.h) > TORQUE_SHARE:
            return None
        J = scaled(state.J, axes)
        dexterity = min(dexterity, np.linalg.svd(J, compute_uv=False)[-1])
        change = np.linalg.pinv(J) @ np.concatenate((step, np.zeros(axes - 3)))
        used = np.abs(change) / (SPEED_SHARE * arm.velocity_limit)
        speed = min(speed, LENGTH / STEPS / used.max())
        q = q + change
    return Line(start, displacement, speed, dexterity)


def best_line(arm: ArmModel, axes: int) -> Line | None:
    """Return the line that stays farthest from singular postures; None if there is none.

    Lines along the world's axes from the best postures are tried first. If none is possible, lines along edges and
    diagonals of a cube are tried too, from every posture.
    """
    grid = np.array([way for way in product((-1.0, 0.0, 1.0), repeat=3) if any(way)])
    directions = sorted((grid / np.linalg.norm(grid, axis=1, keepdims=True)).tolist(), key=np.count_nonzero)
    postures = starts(arm, axes)
    for some, ways in ((postures[:TRIED], directions[:6]), (postures, directions)):
        lines = (line_from(arm, q, LENGTH * np.array(way), axes) for q in some for way in ways)
        possible = [line for line in lines if line is not None and line.dexterity > LEAST_DEXTERITY]
        if possible:
            return max(possible, key=lambda line: line.dexterity)
    return None


def row_of(published: PublishedArm) -> tuple[str, ...]:
    """Return an arm's row of the table."""
    axes = 6 if published.joints >= SIX_AXES else 3
    head = [published.name, str(published.joints), published.tool_frame, str(axes)]
    try:
        arm, defaults = published.completed()
    except PilegraspError as error:
        return (*head, "-", "-", "-", f"refused: {error}")
    chosen = best_line(arm, axes)
    if chosen is None:
        return (*head, defaults or "-", "-", "-", f"no line of {LENGTH} m away from limits and singular postures")
    line = StraightLine(arm.update(chosen.q, np.zeros(arm.nv)).pose, chosen.displacement, chosen.speed)
    mask = [True] * axes + [False] * (6 - axes)
    controller = OperationalSpaceController(arm, GAINS, chosen.q, mask=mask)
    try:
        motion = simulate_tracking(ArmSimulation(arm), controller, line.at, chosen.q, line.duration + HOLD)
    except PilegraspError as error:
        return (*head, defaults or "-", f"{chosen.speed:.3f}", "-", str(error))
    peak = float(np.linalg.norm(motion.error[:, :3], axis=1).max())
    limits = ", ".join(motion.active_limits())
    result = "tracks" if peak < MOST_ERROR else f"limits: {limits}" if limits else "does not track"
    return (*head, defaults or "-", f"{chosen.speed:.3f}", f"{1e3 * peak:.3f}", result)


def main(*names: str) -> None:
    """Print how well arms of published packages track a line; all of them, or those that are named."""
    arms, others = example_arms()
    arms += mujoco_arms()
    known = [arm.name for arm in arms]
    for name in names:
        if name not in known:
            raise ConfigurationError(f"no arm {name!r}; {remedy_for(name, known, f'the arms are {known}')}")
    console = Console(stderr=True)
    chosen = track([arm for arm in arms if not names or arm.name in names], "Arms", console=console, transient=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ModelWarning)
        print(markdown_table(HEADER, [row_of(published) for published in chosen]))
    print(f"\nNo arms by the rule: {', '.join(others)}.")


if __name__ == "__main__":
    run_script(main)
