"""Curves of a recording as a figure of Matplotlib."""

from __future__ import annotations

from typing import Any

from pilegrasp_ctrl.exceptions import ArgumentError
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.viewer.page.lanes import lanes
from pilegrasp_ctrl.viewer.page.summary import summarize

WIDTH, HEIGHT = 8.0, 1.7
"""Width of the figure, and height of a lane [in]; chosen."""


def plot(recording: Recording, *names: str) -> Any:
    """Return a `matplotlib.figure.Figure`: a lane for each quantity, the primitives as bands, F_grasp as a line.

    Args:
        recording: Recording.
        names: Keys of the lanes, as "force", "closure" or "q"; by default those that a page shows at first.

    Raises:
        ArgumentError: The recording has no lane of a name.
    """
    from matplotlib.figure import Figure

    summary = summarize(recording.meta)
    found = {lane.key: lane for lane in lanes(recording, summary.grasp_force)}
    unknown = [name for name in names if name not in found]
    if unknown:
        raise ArgumentError(f"the recording has no curves {unknown[0]!r:.80}; it has {', '.join(found)}")
    shown = [found[name] for name in names] or [lane for lane in found.values() if lane.shown]
    figure = Figure(figsize=(WIDTH, 0.6 + HEIGHT * max(1, len(shown))), layout="constrained")
    axes = figure.subplots(max(1, len(shown)), 1, sharex=True, squeeze=False)[:, 0]
    for axis, lane in zip(axes, shown, strict=False):
        for curve in lane.curves:
            axis.plot(curve.time, curve.value, label=curve.label, linewidth=1.0)
        if lane.threshold is not None:
            words, level = lane.threshold
            axis.axhline(level, color="tab:red", linestyle="--", linewidth=1.0, label=words)
        axis.set_ylabel(f"{lane.title} [{lane.unit}]")
        axis.legend(fontsize="x-small", loc="upper left", ncols=4)
    for index, row in enumerate(summary.primitives):
        for axis in axes:
            axis.axvspan(row.start, row.end, color="0.5" if index % 2 else "0.75", alpha=0.15, linewidth=0)
        axes[0].text(row.start, 1.02, row.name, transform=axes[0].get_xaxis_transform(), fontsize="x-small")
    axes[-1].set_xlabel("time [s]")
    return figure
