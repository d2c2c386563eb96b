"""How well the operational-space controller tracks lines, arcs and steps on plants that differ from its model."""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from math import inf, pi
from typing import NamedTuple

import numpy as np
from rich.console import Console
from rich.progress import track

from example_arm import HOME, example_arm
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.plant.step_response import step_response
from pilegrasp_ctrl.plant.tracking import simulate_tracking
from pilegrasp_ctrl.trajectories.arc import Arc
from pilegrasp_ctrl.trajectories.straight_line import StraightLine
from pilegrasp_ctrl.types import Array, Pose
from tracking_condition import CONDITIONS, Condition
from tracking_rows import PathRow, StepRow, TrackingTable

ARMS = ("wam7", "panda")
PATHS = ("line", "arc")
SPEEDS = (0.05, 0.1, 0.25)
"""[m/s]"""
STEPS = (0.005, 0.010, 0.025)
"""A step has no speed; it has a size [m]."""

LINE = (0.0, 0.3, 0.0)
"""Displacement of the line [m]."""
ARC_CENTER = (0.0, 0.1, 0.0)
"""Centre of the arc from the tool [m]: half a circle over it, at right angles to the world's x axis."""

RATE = 500.0
"""[Hz]"""
HOLD = 1.0
"""How long the reference rests at the end of a path, and how long a step is watched [s]."""
SETTLED = 1e-3
"""Position error within which a path counts as settled [m]."""

_AT_REST = 0.1


class _Case(NamedTuple):
    """One row to measure; `value` is a speed or the size of a step."""

    arm: str
    motion: str
    value: float
    condition: Condition


def tracking_table(
    arms: Sequence[str] = ARMS,
    speeds: Sequence[float] = SPEEDS,
    steps: Sequence[float] = STEPS,
    *,
    jobs: int = 1,
) -> TrackingTable:
    """Measure every path at every speed and every step, on every arm, under every condition that concerns it.

    Rows depend neither on each other nor on the number of jobs. A terminal shows progress on standard error.

    Args:
        arms: "wam7", "panda".
        speeds: of lines and arcs [m/s].
        steps: sizes of the steps [m].
        jobs: number of processes.

    Raises:
        ConfigurationError: where an arm is unknown, or a number is not positive.
    """
    if unknown := [name for name in arms if name not in HOME]:
        raise ConfigurationError(f"no arm {unknown[0]!r} to measure; the arms are {', '.join(ARMS)}")
    for value in (*speeds, *steps, jobs):
        if not 0.0 < value < inf:
            raise ConfigurationError(f"speeds, steps and jobs must be positive and finite; {value} is not")
    motions = [(path, speed) for path in PATHS for speed in speeds] + [("step", size) for size in steps]
    cases = [
        _Case(arm, *motion, condition)
        for arm in arms
        for motion in motions
        for condition in CONDITIONS
        if condition.concerns(example_arm(arm).arm)
    ]
    console = Console(stderr=True)
    rows = list(track(_measured(cases, jobs), "tracking", len(cases), console=console, disable=not console.is_terminal))
    return TrackingTable(
        tuple(row for row in rows if isinstance(row, PathRow)), tuple(row for row in rows if isinstance(row, StepRow))
    )


def _measured(cases: list[_Case], jobs: int) -> Iterator[PathRow | StepRow]:
    if jobs == 1:
        yield from map(_measure, cases)
        return
    # Pinocchio does not promise to survive a fork.
    with ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn")) as pool:
        yield from pool.map(_measure, cases)


def _measure(case: _Case) -> PathRow | StepRow:
    return _step_row(case) if case.motion == "step" else _path_row(case)


def _path(name: str, start: Pose, speed: float) -> StraightLine | Arc:
    if name == "line":
        return StraightLine(start, LINE, speed)
    return Arc(start, start.translation + ARC_CENTER, (1.0, 0.0, 0.0), -pi, speed)


def _path_row(case: _Case) -> PathRow:
    example = example_arm(case.arm)
    plant, controller = case.condition.plant(example), case.condition.controller(example, RATE)
    path = _path(case.motion, example.arm.update(example.home, np.zeros(example.arm.nv)).pose, case.value)
    motion = simulate_tracking(plant, controller, path.at, example.home, path.duration + HOLD, RATE)
    error = np.linalg.norm(motion.error.reshape(-1, 2, 3), axis=2)
    moving, resting = motion.time <= path.duration, motion.time > path.duration
    outside = motion.time[resting & (error[:, 0] >= SETTLED)]
    if not outside.size:
        settling = 0.0
    elif outside[-1] == motion.time[-1]:
        settling = inf
    else:
        settling = float(outside[-1]) + 1.0 / RATE - path.duration
    return PathRow(
        arm=case.arm,
        path=case.motion,
        speed=case.value,
        condition=case.condition.name,
        rms=_rms(error[moving, 0]),
        peak=float(error[:, 0].max()),
        at_rest=float(np.linalg.norm(motion.error[-round(_AT_REST * RATE) :, :3].mean(axis=0))),
        settling_time=settling,
        orientation_rms=_rms(error[moving, 1]),
        active_limits=motion.active_limits(),
    )


def _step_row(case: _Case) -> StepRow:
    example = example_arm(case.arm)
    response = step_response(
        example.arm,
        case.condition.controller(example, RATE),
        example.home,
        displacement=(0.0, 0.0, case.value),
        duration=HOLD,
        rate=RATE,
        simulation=case.condition.plant(example),
    )
    return StepRow(
        arm=case.arm,
        size=case.value,
        condition=case.condition.name,
        rise_time=response.rise_time,
        settling_time=response.settling_time,
        overshoot=response.overshoot,
        at_rest=response.steady_state_error[0],
        orientation_rms=_rms(np.linalg.norm(response.error[:, 3:], axis=1)),
        torque_share=response.torque_share,
        active_limits=response.active_limits,
    )


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
