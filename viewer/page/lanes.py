"""The lanes of the timeline: one entry for each quantity, and one for each signal that the table does not know."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilegrasp_ctrl.analysis.reading import lookup, text
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.viewer.page.lane import Curve, Lane

MIN_FORCE_SPAN = 2.0
"""Least upper end of the lane of forces [N], so that the sensor's noise looks small; chosen."""

MIN_ERROR_SPAN = 1.0
"""Least upper end of the lanes of tracking error [mm] and orientation error [°]; chosen."""

MAX_CURVES = 12
"""Largest number of curves in a lane; chosen, as many as a reader can tell apart at best."""


@dataclass(frozen=True, slots=True)
class Quantity:
    """A lane of recorded signals.

    Attributes:
        key: Name of the lane in the page's list of signals.
        title: Name of the quantity.
        unit: Unit after scaling.
        signals: Names of the signals; of a signal with columns, `[first:last]` may follow.
        labels: Name of each curve; joint 1, joint 2 and so on without names.
        scale: Factor from the recorded unit.
        height: Height on the page [px].
        shown: Whether the page shows the lane before a reader chooses.
        fixed: Lowest and highest value, if they do not follow from the curves.
        min_top: Smallest upper end.
        columns: First column and end, of a signal with columns.
    """

    key: str
    title: str
    unit: str
    signals: tuple[str, ...]
    labels: tuple[str, ...] = ()
    scale: float = 1.0
    height: int = 40
    shown: bool = False
    fixed: tuple[float, float] | None = None
    min_top: float = 0.0
    columns: tuple[int, int] = (0, MAX_CURVES)


_XYZ = ("x", "y", "z")

QUANTITIES = (
    Quantity(
        "force", "force", "N", ("push_force", "normal_force"), ("push force", "normal force"), 1.0, 92, True, None, 2.0
    ),
    Quantity("tracking", "tracking error", "mm", ("tracking_error",), (), 1e3, 34, True, None, MIN_ERROR_SPAN),
    Quantity("torques", "torques", "% of limit", ("torque_ratio",), (), 100.0, 58, True, (0.0, 100.0)),
    Quantity("closure", "closure", "%", ("closure",), (), 100.0, 26, True, (0.0, 100.0)),
    Quantity(
        "turning", "orientation error", "°", ("orientation_error",), (), 180.0 / np.pi, 34, min_top=MIN_ERROR_SPAN
    ),
    Quantity("wrench_force", "wrist force", "N", ("wrench",), _XYZ, height=56, columns=(0, 3)),
    Quantity("wrench_moment", "wrist moment", "N·m", ("wrench",), _XYZ, height=56, columns=(3, 6)),
    Quantity("q", "joint positions", "rad", ("q",), height=58),
    Quantity("v", "joint velocities", "rad/s", ("v",), height=58),
    Quantity("tool", "tool position", "m", ("tool_position",), _XYZ, height=56),
    Quantity("reference", "reference position", "m", ("reference_position",), _XYZ, height=56),
    Quantity("saturated", "wrist sensor at its range", "1", ("sensor_saturated",), height=20, fixed=(0.0, 1.0)),
)
"""The lanes from top to bottom."""


def _columns(recording: Recording, quantity: Quantity) -> list[tuple[str, NDArray[np.float64]]]:
    """Return label and values of each curve."""
    found = []
    for index, name in enumerate(quantity.signals):
        signal = recording.signals.get(name)
        if signal is None or not signal.size:
            continue
        values = quantity.scale * signal.astype(np.float64)
        if quantity.key == "torques":
            values = np.abs(values)
        if values.ndim == 1:
            label = quantity.labels[index] if index < len(quantity.labels) else quantity.title
            found.append((label, values))
            continue
        first, end = quantity.columns
        for column, content in enumerate(values.T[first:end]):
            label = quantity.labels[column] if column < len(quantity.labels) else f"joint {column + 1}"
            found.append((label, content))
    return found


def _unknown(recording: Recording) -> list[Quantity]:
    """Return a lane for each recorded signal that no quantity names."""
    known = {name for quantity in QUANTITIES for name in quantity.signals}
    units = recording.meta.get("signal_units")
    return [
        Quantity(
            key=f"signal {index}",
            title=text(name, 40),
            unit=text(lookup(units, name), 12) if isinstance(units, Mapping) and name in units else "-",
            signals=(name,),
            labels=tuple(f"column {column + 1}" for column in range(MAX_CURVES)),
        )
        for index, name in enumerate(sorted(set(recording.signals) - known))
    ]


def lanes(recording: Recording, grasp_force: float | None) -> list[Lane]:
    """Return the lanes of an attempt from top to bottom, without those whose signals were not recorded."""
    found = []
    for quantity in (*QUANTITIES, *_unknown(recording)):
        columns = _columns(recording, quantity)
        forces = quantity.key == "force"
        # The lane of forces is always drawn, because the bands need a lane.
        if not columns and not forces:
            continue
        style = "c" if len(columns) <= 3 else "j"
        curves = [
            Curve(label, recording.signal_time, values, f"{style}{index % (3 if style == 'c' else 7)}")
            for index, (label, values) in enumerate(columns)
        ]
        threshold = (f"F_grasp {grasp_force:g} N", grasp_force) if forces and grasp_force is not None else None
        found.append(
            Lane(
                key=quantity.key,
                title=quantity.title,
                unit=quantity.unit,
                curves=curves,
                height=quantity.height,
                threshold=threshold,
                min_top=quantity.min_top,
                fixed=quantity.fixed,
                shown=quantity.shown,
            )
        )
    return found


def common_ranges(sides: Sequence[Sequence[Lane]]) -> dict[str, tuple[float, float]]:
    """Return one range for each key, so that two recordings are drawn to the same scale."""
    found: dict[str, tuple[float, float]] = {}
    for lane in (lane for side in sides for lane in side):
        low, high = lane.range()
        before = found.get(lane.key, (low, high))
        found[lane.key] = (min(low, before[0]), max(high, before[1]))
    return found
