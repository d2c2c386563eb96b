"""One lane of the timeline: curves of one unit over the attempt's time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.viewer.animation import thin

WIDTH, HEIGHT = 1000.0, 100.0
"""Size of the box in which curves are drawn; chosen. The page stretches the box; strokes keep their width."""

BINS = 250
"""Number of bins of a thinned curve, each with its smallest and its largest sample; chosen."""

FLAT_SHARE = 0.004
"""Share of the lane's height by which a thinned curve may miss a sample; chosen: a pixel is about a hundredth."""


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

    def polyline(self, curve: Curve) -> str:
        """Return the curve as an SVG element."""
        time, value = thinned(curve.time, curve.value, FLAT_SHARE * (self.high - self.low))
        x = np.clip((time - self.start) / (self.end - self.start), 0.0, 1.0) * WIDTH
        y = (1.0 - np.clip((value - self.low) / (self.high - self.low), 0.0, 1.0)) * HEIGHT
        points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x.tolist(), y.tolist(), strict=True))
        return f'<polyline class="{curve.style}" points="{points}"/>'


@dataclass(frozen=True, slots=True, eq=False)
class Lane:
    """Curves of one unit.

    Attributes:
        title: Name of the quantity.
        unit: Unit of the values.
        curves: Curves from front to back.
        height: Height on the page [px].
        threshold: Text and value of a line across the lane.
        min_top: Smallest upper end of the lane.
        fixed: Lowest and highest value, if they do not follow from the curves.
    """

    title: str
    unit: str
    curves: Sequence[Curve]
    height: int
    threshold: tuple[str, float] | None = None
    min_top: float = 0.0
    fixed: tuple[float, float] | None = None

    def axes(self, start: float, end: float) -> Axes:
        """Return axes over all curves, zero and the threshold included."""
        if self.fixed:
            return Axes(start, end, *self._with_margins(*self.fixed))
        lines = [0.0, self.min_top, *([self.threshold[1]] if self.threshold else [])]
        values = lines + [float(x) for curve in self.curves for x in (curve.value.min(), curve.value.max())]
        low, high = min(values), max(values)
        return Axes(start, end, *self._with_margins(low, high if high > low else low + 1.0))

    def _with_margins(self, low: float, high: float) -> tuple[float, float]:
        """Return bounds with four pixels below and eight above, so that the numbers of two lanes keep apart."""
        pixel = (high - low) / (self.height - 12)
        return low - 4.0 * pixel, high + 8.0 * pixel

    def html(self, start: float, end: float) -> str:
        """Return the lane between two times [s]."""
        axes = self.axes(start, end)
        svg = labels = ""
        for tick in nice_ticks(axes.low, axes.high, max(3, self.height // 24)) if self.curves else []:
            y = (1.0 - axes.up(tick)) * HEIGHT
            svg += f'<line class="grid" x1="0" x2="{WIDTH:g}" y1="{y:.1f}" y2="{y:.1f}"/>'
            labels += f'<span class="ty" style="bottom:{100 * axes.up(tick):.2f}%">{tick:g}</span>'
        if self.threshold:
            up = axes.up(self.threshold[1])
            svg += (
                f'<line class="threshold" x1="0" x2="{WIDTH:g}" y1="{(1.0 - up) * HEIGHT:.1f}"'
                f' y2="{(1.0 - up) * HEIGHT:.1f}"/>'
            )
            labels += f'<span class="limit" style="bottom:{100 * up:.2f}%">{escape(self.threshold[0])}</span>'
        # The first curve is drawn last and lies in front.
        svg += "".join(axes.polyline(curve) for curve in reversed(self.curves))
        return (
            f'<div class="lane" style="height:{self.height}px"><svg viewBox="0 0 {WIDTH:g} {HEIGHT:g}"'
            f' preserveAspectRatio="none" aria-hidden="true">{svg}</svg>{labels}{self._legend()}</div>'
        )

    def _legend(self) -> str:
        if len(self.curves) == 1:
            keys = ""
        elif len(self.curves) > 3:
            keys = "".join(
                f'<span class="key {c.style}" title="{escape(c.label)}">{k + 1}</span>'
                for k, c in enumerate(self.curves)
            )
        else:
            keys = "".join(f'<span class="key {c.style}">{escape(c.label)}</span>' for c in self.curves)
        return f'<p class="legend"><b>{escape(self.title)} [{escape(self.unit)}]</b>{keys}</p>'
