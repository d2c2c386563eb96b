"""Print how well the operational-space controller tracks lines, arcs and steps on two arms, as Markdown tables.

Usage: python docs/studies/tracking_table.py [--arms NAME...] [--speeds V...] [--steps D...] [--csv FOLDER]

No physics engine is involved: the plant is the arm's equations of motion with joint friction. Each condition
changes one thing between the plant and the controller's model. All of them take one or two minutes on one core.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Sequence
from math import degrees, inf, pi
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import track

from example_arm import CONDITIONS, HOME, Condition, example_arm
from pilegrasp_ctrl.exceptions import ConfigurationError, PilegraspError
from pilegrasp_ctrl.plant.step_response import step_response
from pilegrasp_ctrl.plant.tracking import simulate_tracking
from pilegrasp_ctrl.statistics import markdown_table
from pilegrasp_ctrl.trajectories.arc import Arc
from pilegrasp_ctrl.trajectories.straight_line import StraightLine
from pilegrasp_ctrl.types import Array

ARMS = tuple(HOME)
"""Names of the arms."""

PATHS = ("line", "arc")
"""Paths that are tracked at every speed."""

SPEEDS = (0.05, 0.1, 0.25)
"""Speeds of lines and arcs [m/s]; chosen around the speed of a push."""

STEPS = (0.005, 0.010, 0.025)
"""Sizes of the steps [m]; chosen."""

LINE = (0.0, 0.3, 0.0)
"""Displacement of the line [m]; chosen."""

ARC_CENTER = (0.0, 0.1, 0.0)
"""Centre of the arc from the tool [m]; chosen. The arc is half a circle over it, normal to the world's x axis."""

RATE = 500.0
"""Control rate of the shipped scenarios [Hz]."""

HOLD = 1.0
"""Time that the reference rests at the end of a path, and time that a step is watched [s]; chosen."""

SETTLED = 1e-3
"""Position error within which a path counts as settled [m]; chosen."""

AT_REST = 0.1
"""Time at the end of a path over which the error at rest is averaged [s]; chosen."""

PATH_HEADER = (
    *("arm", "path", "speed", "condition", "rms [mm]", "peak [mm]", "at rest [mm]", "settled [s]"),
    *("turn rms [°]", "limits"),
)
"""Columns of paths. "rms" and "turn rms" are taken while the reference moves, "peak" includes the rest, and "settled"
counts from the reference's rest."""

STEP_HEADER = (
    *("arm", "step", "condition", "rise [s]", "settled [s]", "overshoot [%]", "at rest [mm]"),
    *("turn rms [°]", "torque [%]", "limits"),
)
"""Columns of steps; their numbers are those of `StepResponse`."""


def path_row(arm: str, path: str, speed: float, condition: Condition) -> tuple[str, ...]:
    """Return the line of the table for a line or an arc."""
    example = example_arm(arm)
    plant, controller = condition.plant(example), condition.controller(example, RATE)
    start = example.arm.update(example.home, np.zeros(example.arm.nv)).pose
    if path == "line":
        reference: StraightLine | Arc = StraightLine(start, LINE, speed)
    else:
        reference = Arc(start, start.translation + ARC_CENTER, (1.0, 0.0, 0.0), -pi, speed)
    motion = simulate_tracking(plant, controller, reference.at, example.home, reference.duration + HOLD, RATE)
    error = np.linalg.norm(motion.error.reshape(-1, 2, 3), axis=2)
    moving, resting = motion.time <= reference.duration, motion.time > reference.duration
    outside = motion.time[resting & (error[:, 0] >= SETTLED)]
    if not outside.size:
        settling = 0.0
    elif outside[-1] == motion.time[-1]:
        settling = inf
    else:
        settling = float(outside[-1]) + 1.0 / RATE - reference.duration
    at_rest = float(np.linalg.norm(motion.error[-round(AT_REST * RATE) :, :3].mean(axis=0)))
    return (
        *(arm, path, f"{speed:g} m/s", condition.name),
        *(_millimetres(value) for value in (_rms(error[moving, 0]), float(error[:, 0].max()), at_rest)),
        *(_seconds(settling), f"{degrees(_rms(error[moving, 1])):.2f}", _limits(motion.active_limits())),
    )


def step_row(arm: str, size: float, condition: Condition) -> tuple[str, ...]:
    """Return the line of the table for a step upward."""
    example = example_arm(arm)
    response = step_response(
        example.arm,
        condition.controller(example, RATE),
        example.home,
        displacement=(0.0, 0.0, size),
        duration=HOLD,
        rate=RATE,
        simulation=condition.plant(example),
    )
    turn = _rms(np.linalg.norm(response.error[:, 3:], axis=1))
    return (
        *(arm, f"{1e3 * size:g} mm", condition.name),
        *(_seconds(response.rise_time), _seconds(response.settling_time), f"{100.0 * response.overshoot:.1f}"),
        *(_millimetres(response.steady_state_error[0]), f"{degrees(turn):.2f}"),
        *(f"{100.0 * response.torque_share:.0f}", _limits(response.active_limits)),
    )


Row = tuple[str, ...]


def measure_tracking(
    arms: Sequence[str], speeds: Sequence[float], steps: Sequence[float]
) -> tuple[list[Row], list[Row]]:
    """Return the rows of paths and of steps: each on every arm, under every condition that applies to the arm.

    A terminal shows progress on standard error.

    Args:
        arms: Names of the arms.
        speeds: Speeds of lines and arcs [m/s].
        steps: Sizes of the steps [m].

    Raises:
        ConfigurationError: An arm is unknown, or a number is not positive.
    """
    for value in (*speeds, *steps):
        if not 0.0 < value < inf:
            raise ConfigurationError(f"speeds and steps must be positive and finite; {value} is not")
    motions = [(path, speed) for path in PATHS for speed in speeds] + [("step", size) for size in steps]
    cases = [
        (arm, *motion, condition)
        for arm in arms
        for motion in motions
        for condition in CONDITIONS
        if condition.applies_to(example_arm(arm).arm)
    ]
    console = Console(stderr=True)
    paths, rises = [], []
    for arm, motion, value, condition in track(cases, "tracking", console=console, disable=not console.is_terminal):
        if motion == "step":
            rises.append(step_row(arm, value, condition))
        else:
            paths.append(path_row(arm, motion, value, condition))
    return paths, rises


def write_csv(folder: Path, paths: Sequence[Row], rises: Sequence[Row]) -> None:
    """Write `tracking-paths.csv` and `tracking-steps.csv` into the folder."""
    for name, header, rows in (("paths", PATH_HEADER, paths), ("steps", STEP_HEADER, rises)):
        with (folder / f"tracking-{name}.csv").open("w", newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerows([header, *rows])


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _millimetres(value: float) -> str:
    return f"{1e3 * value:.2f}"


def _seconds(value: float) -> str:
    """Return a time; "never" is longer than was simulated."""
    return "never" if value == inf else f"{value:.2f}"


def _limits(names: tuple[str, ...]) -> str:
    """Return the types of limits, without joints and sides."""
    return ", ".join(sorted({name.partition("[")[0] for name in names})) or "-"


def main() -> None:
    """Measure the arms, speeds and steps of the arguments, by default all of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--arms", nargs="+", choices=ARMS, default=ARMS)
    parser.add_argument("--speeds", nargs="*", type=float, default=SPEEDS, help="speeds of lines and arcs [m/s]")
    parser.add_argument("--steps", nargs="*", type=float, default=STEPS, help="sizes of the steps [m]")
    parser.add_argument("--csv", type=Path, metavar="FOLDER", help="write two CSV files there, print nothing")
    options = parser.parse_args()
    try:
        paths, rises = measure_tracking(options.arms, options.speeds, options.steps)
        if options.csv:
            write_csv(options.csv, paths, rises)
        else:
            print(markdown_table(PATH_HEADER, paths), markdown_table(STEP_HEADER, rises), sep="\n\n")
    except PilegraspError as error:
        sys.exit(f"error: {error}")


if __name__ == "__main__":
    main()
