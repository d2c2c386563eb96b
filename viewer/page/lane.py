"""One lane of the timeline: curves of one unit over the attempt's time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.viewer.scene.animation import thin

WIDTH, HEIGHT = 1000.0, 100.0
"""Size of the box in which curves are drawn; chosen. The page stretches the box; strokes keep their width."""

BINS = 250
"""Number of bins of a thinned curve, each with its smallest and its largest sample; chosen."""

FLAT_SHARE = 0.004
"""Share of the lane's height by which a thinned curve may miss a sample; chosen: a pixel is about a hundredth."""

BELOW, ABOVE = 4.0, 8.0
"""Room below and above what a lane shows [px]; chosen. It has no ticks, so the numbers of two lanes stay apart."""

LOW = 30
"""Height up to which a lane has the numbers of its ends alone [px]; chosen: a third one would stand on them."""


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """A signal over time; `style` names its CSS class."""

    label: str
    time: NDArray[np.float64]
    value: NDArray[np.float64]
    style: str


def scalar_signal(recording: Recording, name: str) -> NDArray[np.float64] | None:
    """Return a signal (S,); None if it is absent, empty or has columns."""
    signal = recording.signals.get(name)
    return signal.astype(np.float64) if signal is not None and signal.size and signal.ndim == 1 else None


def nice_ticks(low: float, high: float, count: int) -> list[float]:
    """Return about `count` round numbers inside [low, high]: steps of 1, 2 or 5 times a power of ten."""
    span = high - low
    if not span > 0.0 or not np.isfinite(span):
        return []
    power = 10.0 ** np.floor(np.log10(span / count))
    step = next((m * power for m in (1.0, 2.0, 5.0) if span / (m * power) <= count), 10.0 * power)
    first, last = int(np.ceil(low / step - 1e-9)), int(np.floor(high / step + 1e-9))
    return [float(k * step) for k in range(first, last + 1)]


def thinned(
    time: NDArray[np.float64], value: NDArray[np.float64], tolerance: float = 0.0
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return at most 2 x `BINS` samples: the smallest and the largest of each bin, so that no peak is lost.

    Samples within `tolerance` of the line between the others are left out.
    """
    if len(time) > 2 * BINS:
        edges = np.linspace(0, len(time), BINS + 1).astype(int)
        kept = sorted(
            {first + int(pick(value[first:last])) for first, last in pairwise(edges) for pick in (np.argmin, np.argmax)}
            | {0, len(time) - 1}
        )
        time, value = time[kept], value[kept]
    if tolerance > 0.0:

        def error(first: int, last: int) -> NDArray[np.float64]:
            fraction = (time[first + 1 : last] - time[first]) / (time[last] - time[first])
            return np.abs(value[first] + fraction * (value[last] - value[first]) - value[first + 1 : last])

        rest = thin(len(time), error, tolerance)
        time, value = time[rest], value[rest]
    return time, value


@dataclass(frozen=True, slots=True)
class Axes:
    """A window: `start` to `end` [s] across, `low` to `high` up."""

    start: float
    end: float
    low: float
    high: float

    def across(self, time: float) -> float:
        """Return 0..1 from left to right."""
        return float(np.clip((time - self.start) / (self.end - self.start), 0.0, 1.0))

    def up(self, value: float) -> float:
        """Return 0..1 from bottom to top."""
        return float(np.clip((value - self.low) / (self.high - self.low), 0.0, 1.0))

    def points(self, curve: Curve) -> str:
        """Return the points of the curve's SVG element."""
        time, value = thinned(curve.time, curve.value, FLAT_SHARE * (self.high - self.low))
        x = np.clip((time - self.start) / (self.end - self.start), 0.0, 1.0) * WIDTH
        y = (1.0 - np.clip((value - self.low) / (self.high - self.low), 0.0, 1.0)) * HEIGHT
        return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x.tolist(), y.tolist(), strict=True))


@dataclass(frozen=True, slots=True, eq=False)
class Lane:
    """Curves of one unit.

    Attributes:
        key: Name of the lane in the page's list of signals.
        title: Name of the quantity.
        unit: Unit of the values.
        curves: Curves from front to back.
        height: Height on the page [px].
        threshold: Text and value of a line across the lane.
        min_top: Smallest upper end of the lane.
        fixed: Lowest and highest value, if they do not follow from the curves.
        shown: Whether the page shows the lane before a reader chooses.
    """

    key: str
    title: str
    unit: str
    curves: Sequence[Curve]
    height: int
    threshold: tuple[str, float] | None = None
    min_top: float = 0.0
    fixed: tuple[float, float] | None = None
    shown: bool = True

    def range(self) -> tuple[float, float]:
        """Return the smallest and the largest value of all curves, zero and the threshold included."""
        if self.fixed:
            return self.fixed
        lines = [0.0, self.min_top, *([self.threshold[1]] if self.threshold else [])]
        values = lines + [float(x) for curve in self.curves for x in (curve.value.min(), curve.value.max())]
        low, high = min(values), max(values)
        return low, high if high > low else low + 1.0

    def axes(self, start: float, end: float, common: tuple[float, float] | None = None) -> Axes:
        """Return axes between two times [s] over the lane's range, or over a `common` one."""
        low, high = common or self.range()
        pixel = (high - low) / max(self.height - BELOW - ABOVE, 1.0)
        return Axes(start, end, low - BELOW * pixel, high + ABOVE * pixel)

    def drawing(self, axes: Axes) -> dict[str, Any]:
        """Return what the template draws: heights in the box of curves, and texts. A hidden lane has no points yet."""
        pixel = (axes.high - axes.low) / self.height
        ends = axes.low + BELOW * pixel, axes.high - ABOVE * pixel
        count = max(2 if self.height > LOW else 1, self.height // 22)
        ticks = nice_ticks(*ends, count) if self.curves else []
        return {
            "key": self.key,
            "title": self.title,
            "unit": self.unit,
            "height": self.height,
            "hidden": not self.shown,
            "low": f"{axes.low:.6g}",
            "high": f"{axes.high:.6g}",
            "grid": [f"{(1.0 - axes.up(tick)) * HEIGHT:.1f}" for tick in ticks],
            "ticks": [(f"{100 * axes.up(tick):.2f}", f"{tick:g}".replace("-", "\N{MINUS SIGN}")) for tick in ticks],
            "threshold": self._threshold(axes),
            # The first curve is drawn last and lies in front.
            "curves": [(c.style, axes.points(c) if self.shown else "") for c in reversed(self.curves)],
            "keys": [(c.style, c.label) for c in self.curves],
            "named": len(self.curves) > 1,
        }

    def _threshold(self, axes: Axes) -> tuple[str, str] | None:
        return self.threshold and (f"{(1.0 - axes.up(self.threshold[1])) * HEIGHT:.1f}", self.threshold[0])
