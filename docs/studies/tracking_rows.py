"""Rows of the tracking table, and the table as Markdown."""

from __future__ import annotations

from math import degrees, inf
from typing import NamedTuple

from pilegrasp_ctrl.statistics import markdown_table


class PathRow(NamedTuple):
    """How a line or an arc was followed.

    Attributes:
        arm: its name.
        path: "line" or "arc".
        speed: along it [m/s].
        condition: name of what differs from the model.
        rms: of the position error while the reference moves [m].
        peak: largest position error, at rest included [m].
        at_rest: mean position error over the last 0.1 s [m].
        settling_time: from the reference's rest until the position error stays below 1 mm [s]; inf where it does not.
        orientation_rms: of the orientation error while the reference moves [rad].
        active_limits: names of the limits that bound at any time.
    """

    arm: str
    path: str
    speed: float
    condition: str
    rms: float
    peak: float
    at_rest: float
    settling_time: float
    orientation_rms: float
    active_limits: tuple[str, ...]

    def cells(self) -> tuple[str, ...]:
        """Return the row as it is printed."""
        return (
            *(self.arm, self.path, f"{self.speed:g} m/s", self.condition),
            *(_millimetres(value) for value in (self.rms, self.peak, self.at_rest)),
            *(_seconds(self.settling_time), f"{degrees(self.orientation_rms):.2f}", _limits(self.active_limits)),
        )


class StepRow(NamedTuple):
    """How a step upward was answered; the metrics are those of `StepResponse`.

    A step has no speed but a size, and the rms and the peak of its position error only repeat that size.

    Attributes:
        arm: its name.
        size: of the step [m].
        condition: name of what differs from the model.
        rise_time: from 10 to 90 % [s]; inf where 90 % is not reached.
        settling_time: to 2 % of the step [s]; inf where it does not settle.
        overshoot: as a fraction of the step.
        at_rest: length of the mean position error over the last 0.1 s [m].
        orientation_rms: [rad].
        torque_share: largest torque over its limit.
        active_limits: names of the limits that bound at any time.
    """

    arm: str
    size: float
    condition: str
    rise_time: float
    settling_time: float
    overshoot: float
    at_rest: float
    orientation_rms: float
    torque_share: float
    active_limits: tuple[str, ...]

    def cells(self) -> tuple[str, ...]:
        """Return the row as it is printed."""
        return (
            *(self.arm, f"{1e3 * self.size:g} mm", self.condition),
            *(_seconds(self.rise_time), _seconds(self.settling_time), f"{100.0 * self.overshoot:.1f}"),
            *(_millimetres(self.at_rest), f"{degrees(self.orientation_rms):.2f}"),
            *(f"{100.0 * self.torque_share:.0f}", _limits(self.active_limits)),
        )


class TrackingTable(NamedTuple):
    """All rows, in the order in which they are printed."""

    paths: tuple[PathRow, ...]
    steps: tuple[StepRow, ...]

    def markdown(self) -> str:
        """Return two tables; "never" is longer than was simulated."""
        paths = ("arm", "path", "speed", "condition", "rms [mm]", "peak [mm]", "at rest [mm]", "settled [s]")
        steps = ("arm", "step", "condition", "rise [s]", "settled [s]", "overshoot [%]", "at rest [mm]")
        lines = markdown_table((*paths, "turn rms [°]", "limits"), (row.cells() for row in self.paths))
        rises = markdown_table((*steps, "turn rms [°]", "torque [%]", "limits"), (row.cells() for row in self.steps))
        return f"{lines}\n\n{rises}"


def _millimetres(value: float) -> str:
    return f"{1e3 * value:.2f}"


def _seconds(value: float) -> str:
    return "never" if value == inf else f"{value:.2f}"


def _limits(names: tuple[str, ...]) -> str:
    """The kinds of limits, without joints and sides."""
    return ", ".join(sorted({name.partition("[")[0] for name in names})) or "-"
