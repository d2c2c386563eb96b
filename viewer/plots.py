"""Strips under the scene: a signal over time with the primitives as bands, as HTML and SVG that need no script."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.viewer.summary import Phase, plain

# The curve is drawn in a box of this many units, stretched to the page; strokes keep their width.
WIDTH, HEIGHT = 1000.0, 100.0
_BINS = 250
SMALLEST_FORCE = 2.0
"""The strip of forces reaches up to this at least, so that the sensor's noise looks like noise [N]."""


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """A signal over time; `style` names its CSS class."""

    label: str
    time: NDArray[np.float64]
    value: NDArray[np.float64]
    style: str


def scalar_signal(recording: Recording, name: str, reduce: bool = False) -> NDArray[np.float64] | None:
    """Return a signal (S,), or with `reduce` the largest magnitude of its columns; None where it is absent or empty."""
    signal = recording.signals.get(name)
    if signal is None or not signal.size:
        return None
    values = signal.astype(np.float64)
    if values.ndim == 2:
        return np.abs(values).max(axis=1) if reduce else None
    return values


def nice_ticks(low: float, high: float, count: int) -> list[float]:
    """Return about `count` round numbers inside [low, high]: steps of 1, 2 or 5 times a power of ten."""
    span = high - low
    if not span > 0.0 or not np.isfinite(span):
        return []
    power = 10.0 ** np.floor(np.log10(span / count))
    step = next((m * power for m in (1.0, 2.0, 5.0) if span / (m * power) <= count), 10.0 * power)
    first, last = int(np.ceil(low / step - 1e-9)), int(np.floor(high / step + 1e-9))
    return [float(k * step) for k in range(first, last + 1)]


def thinned(time: NDArray[np.float64], value: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return at most 2 x 250 samples, the smallest and the largest of each bin, so that no peak is lost."""
    if len(time) <= 2 * _BINS:
        return time, value
    edges = np.linspace(0, len(time), _BINS + 1).astype(int)
    kept = sorted(
        {first + int(pick(value[first:last])) for first, last in pairwise(edges) for pick in (np.argmin, np.argmax)}
        | {0, len(time) - 1}
    )
    return time[kept], value[kept]


@dataclass(frozen=True, slots=True)
class Axes:
    """The window of a strip: `start` to `end` [s] across, `low` to `high` up."""

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
        time, value = thinned(curve.time, curve.value)
        points = " ".join(
            f"{self.across(t) * WIDTH:.1f},{(1.0 - self.up(v)) * HEIGHT:.1f}" for t, v in zip(time, value, strict=True)
        )
        return f'<polyline class="{curve.style}" points="{points}"/>'


def window(recording: Recording, curves: Sequence[Curve], lines: Sequence[float]) -> Axes:
    """Return axes over all frames and curves, zero included."""
    start, end = float(recording.frame_time[0]), float(recording.frame_time[-1])
    values = [0.0, *lines, *(float(x) for c in curves for x in (c.value.min(), c.value.max()))]
    low, high = min(values), max(values)
    high = high if high > low else low + 1.0
    return Axes(start, end if end > start else start + 1.0, low, high + 0.08 * (high - low))


def styles(phases: Sequence[Phase]) -> list[str]:
    """Return a CSS class for each phase; equal names share a colour."""
    names = list(dict.fromkeys(phase.name for phase in phases))
    return [f"p{names.index(phase.name) % 6}" for phase in phases]


def _band(axes: Axes, phase: Phase, style: str, labelled: bool) -> str:
    left, right = axes.across(phase.start), axes.across(phase.end)
    failed = " failed" if phase.failed else ""
    hint = f"{phase.name}: {phase.start:.2f} to {phase.end:.2f} s, {phase.trigger or 'no trigger named'}"
    cause = f"<small>→ {escape(plain(phase.trigger))}</small>" if phase.trigger else ""
    label = f"<span><b>{escape(phase.name)}</b>{cause}</span>" if labelled else ""
    return (
        f'<div class="band {style}{failed}" style="left:{100 * left:.2f}%;width:{100 * (right - left):.2f}%"'
        f' title="{escape(hint)}">{label}</div>'
    )


def strip(
    recording: Recording,
    phases: Sequence[Phase],
    curves: Sequence[Curve],
    unit: str,
    threshold: tuple[str, float] | None = None,
    labelled: bool = True,
    least: float = 0.0,
) -> str:
    """Return one strip as HTML: bands, curves, a threshold line, ticks, and a cursor that the page's script moves.

    Without curves the bands stand alone. The strip carries its time window in `data-start` and `data-end`, and reaches
    up to `least` at least.
    """
    axes = window(recording, curves, [least, *([threshold[1]] if threshold else [])])
    bands = "".join(_band(axes, phase, style, labelled) for phase, style in zip(phases, styles(phases), strict=True))
    ticks_y = nice_ticks(axes.low, axes.high, 4) if curves else []
    ticks_x = nice_ticks(axes.start, axes.end, 10)
    decimals = max(0, -int(np.floor(np.log10(ticks_x[1] - ticks_x[0])))) if len(ticks_x) > 1 else 1
    svg = "".join(
        f'<line class="grid" x1="0" x2="{WIDTH:g}" y1="{y:.1f}" y2="{y:.1f}"/>'
        for y in ((1.0 - axes.up(v)) * HEIGHT for v in ticks_y)
    )
    labels = "".join(f'<span class="ty" style="bottom:{100 * axes.up(v):.2f}%">{v:g}</span>' for v in ticks_y)
    labels += "".join(
        f'<span class="tx{" odd" if k % 2 else ""}" style="left:{100 * axes.across(t):.2f}%">{t:.{decimals}f}</span>'
        for k, t in enumerate(ticks_x)
    )
    if threshold:
        y = (1.0 - axes.up(threshold[1])) * HEIGHT
        svg += f'<line class="threshold" x1="0" x2="{WIDTH:g}" y1="{y:.1f}" y2="{y:.1f}"/>'
        labels += f'<span class="limit" style="bottom:{100 * axes.up(threshold[1]):.2f}%">{escape(threshold[0])}</span>'
    svg += "".join(axes.polyline(curve) for curve in curves)
    legend = "".join(f'<span class="key {c.style}">{escape(c.label)}</span>' for c in curves)
    lane = " lane" if labelled else ""
    return (
        f'<figure class="strip"><figcaption>{legend}<span class="unit">{escape(unit)}</span></figcaption>'
        f'<div class="plot{lane}" data-start="{axes.start:.4f}" data-end="{axes.end:.4f}">{bands}<div class="field">'
        f'<svg viewBox="0 0 {WIDTH:g} {HEIGHT:g}" preserveAspectRatio="none" aria-hidden="true">{svg}</svg>'
        f'{labels}</div><div class="cursor"></div></div></figure>'
    )


def force_strip(recording: Recording, phases: Sequence[Phase], grasp_force: float | None) -> str:
    """Return the strip of the push force and the normal force [N] with the line of F_grasp."""
    named = (("push_force", "push force", "c0"), ("normal_force", "normal force", "c1"))
    threshold = (f"F_grasp {grasp_force:g} N", grasp_force) if grasp_force is not None else None
    curves = _curves(recording, named)
    return strip(recording, phases, curves, "force [N] over time [s]", threshold, least=SMALLEST_FORCE)


def controller_strips(recording: Recording, phases: Sequence[Phase]) -> str:
    """Return strips of the tracking error [mm], the orientation error [°] and the largest torque ratio [%]."""
    rows = (
        ("tracking_error", "tracking error", 1e3, "mm", False),
        ("orientation_error", "orientation error", 180.0 / np.pi, "°", False),
        ("torque_ratio", "largest joint torque, of its limit", 100.0, "%", True),
    )
    strips = []
    for name, label, scale, unit, reduce in rows:
        values = scalar_signal(recording, name, reduce)
        if values is not None:
            curve = Curve(label, recording.signal_time, scale * values, "c0")
            strips.append(strip(recording, phases, [curve], f"[{unit}]", labelled=False))
    return "".join(strips)


def _curves(recording: Recording, named: Sequence[tuple[str, str, str]]) -> list[Curve]:
    values = [(label, scalar_signal(recording, name), style) for name, label, style in named]
    return [Curve(label, recording.signal_time, v, style) for label, v, style in values if v is not None]
