"""Print and draw how a pile moves before the hand: without a support, beside a wall, in a corner (the paper's Fig. 2).

Usage: python docs/studies/motion_pattern.py [FIRST LAST [FOLDER]]

FIRST and LAST are the range of seeds; FOLDER takes motion_pattern.png and motion_pattern.json.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

import pilegrasp_ctrl as pg
from motion_table import MotionPattern, markdown
from pilegrasp_ctrl.analysis.motion_field import X_EDGES, Y_EDGES, Funnel, MotionField
from pilegrasp_ctrl.analysis.push_motion import PushMotion
from pilegrasp_ctrl.recording import Recording, Shape
from pilegrasp_ctrl.scenarios.paper.motion_verdict import motion_verdict
from pilegrasp_ctrl.types import rotation_matrices
from script import run_script, seed_range

RED, BLUE, GREY, SKIN = "#c0392b", "#2f6db5", "#9aa3ad", "#e6c79c"
"""Colours of relative motion, absolute motion, objects and supports, and the hand."""

ARROW = 0.25
"""Length of an arrow for a speed of 1 m/s [m]; chosen: the hand's 0.1 m/s is 25 mm, little more than a cell."""

LIMITS = ((-0.14, 0.31), (-0.21, 0.21))
"""Limits of the figure along and across the push, in the hand's frame [m]; chosen."""

_STYLE: Any = {"font.size": 9.0, "axes.titlesize": 10.0, "legend.frameon": False, "svg.fonttype": "none"}


def pattern_figure(patterns: Sequence[MotionPattern]) -> Figure:
    """Return a panel for each condition: mean relative motion before the hand (red), absolute motion beside it (blue).

    Pile, hand and walls of one attempt are drawn behind the arrows, at the first motion of the pile.
    """
    with mpl.rc_context({**mpl.rcParamsDefault, **_STYLE}):
        figure = Figure(figsize=(3.6 * len(patterns), 4.0), layout="constrained")
        panels = figure.subplots(1, len(patterns), sharey=True, squeeze=False)[0]
        panels[0].set_ylabel("across [mm]")
        for axes, pattern in zip(panels, patterns, strict=True):
            _panel(axes, pattern)
        handles = [
            mpl.lines.Line2D([], [], color=RED, lw=1.5, label="relative to the hand, before it"),
            mpl.lines.Line2D([], [], color=BLUE, lw=1.5, label="in the scene, beside it"),
            mpl.lines.Line2D([], [], color=RED, lw=1.2, ls="--", label="funnel"),
        ]
        figure.legend(handles=handles, loc="outside lower center", ncols=3)
    return figure


def _panel(axes: Axes, pattern: MotionPattern) -> None:
    axes.set(xlim=LIMITS[0], ylim=LIMITS[1], aspect="equal", title=f"{pattern.name}, {len(pattern.measures)} attempts")
    axes.set_xticks([-0.1, 0.0, 0.1, 0.2, 0.3], labels=["-100", "0", "100", "200", "300"])
    axes.set_yticks([-0.2, -0.1, 0.0, 0.1, 0.2], labels=["-200", "-100", "0", "100", "200"])
    axes.set_xlabel("along the push [mm]")
    axes.spines[["top", "right"]].set_visible(False)
    if pattern.example is not None:
        _scene(axes, pattern.example)
    if pattern.field is not None:
        _arrows(axes, pattern.field)


def _arrows(axes: Axes, field: MotionField) -> None:
    x, y = np.meshgrid(*(0.5 * (edges[1:] + edges[:-1]) for edges in (X_EDGES, Y_EDGES)), indexing="ij")
    # The mean of a cell that few objects have crossed is chance.
    seen = field.count >= 2 * field.attempts
    before = seen & (np.abs(y) <= field.half_width) & (x > 0.0)
    beside = seen & (np.abs(y) > field.half_width)
    for velocity, where, color in ((field.mean_relative(), before, RED), (field.mean_absolute(), beside, BLUE)):
        u, v = (ARROW * velocity[where][:, axis] for axis in range(2))
        axes.quiver(
            x[where], y[where], u, v, color=color, angles="xy", scale_units="xy", scale=1.0, width=0.006, zorder=4
        )
    funnel = Funnel.of(field)
    for side in (funnel.right, funnel.left):
        axes.plot(funnel.x, side, color=RED, lw=1.2, ls="--", zorder=5)


def _scene(axes: Axes, recording: Recording) -> None:
    """Draw an attempt from above at the first motion of the pile; the walls come nearer to the hand later."""
    push = PushMotion.of(recording)
    if push is None:
        return
    frame = int(np.searchsorted(recording.frame_time, push.time[0]))
    looks = {"object": (GREY, 0.18, 1), "hand": (SKIN, 0.9, 2), "support": (GREY, 0.6, 1)}
    for index, body in enumerate(recording.bodies):
        if body.role not in looks:
            continue
        color, opacity, order = looks[body.role]
        place = recording.body_position[frame, index].astype(float)
        turn = rotation_matrices(recording.body_quaternion[frame, index])
        for shape in body.shapes:
            outline = _outline(shape, place, turn, push.axes) - push.hand[0]
            if body.role == "support" and (shape.kind == "plane" or min(np.ptp(outline, axis=0)) > 0.6):
                continue
            look: dict[str, Any] = {"facecolor": color, "edgecolor": "none", "alpha": opacity, "zorder": order}
            if shape.kind == "sphere":
                axes.add_patch(Circle(tuple(outline.mean(axis=0)), shape.size[0], **look))
            else:
                axes.add_patch(Polygon(outline, **look))


def _outline(shape: Shape, place: NDArray[np.float64], turn: NDArray[np.float64], axes: Any) -> NDArray[np.float64]:
    """Return the convex outline (k, 2) of the box around a shape, seen from above along the axes [m]."""
    signs = np.array(np.meshgrid(*[(-1.0, 1.0)] * 3)).reshape(3, -1).T
    corners = signs * shape.half_extents() @ rotation_matrices(shape.quaternion).T + np.array(shape.position)
    seen = (place + corners @ turn.T) @ axes.T
    return seen[ConvexHull(seen).vertices]


def recordings(support: str, seeds: range) -> Iterator[Recording]:
    """Run the attempts with 18 light spheres, and yield their recordings."""
    keys = {"support.kind": support}
    attempts = (pg.run("spheres_wall", seed=seed, record=True, overrides=keys) for seed in seeds)
    yield from (attempt.recording for attempt in attempts if attempt.recording is not None)


def main(first: int = 0, last: int = 2, folder: Path = Path(".")) -> None:
    """Run the attempts, print the table and its verdict, and draw the figure."""
    folder.mkdir(parents=True, exist_ok=True)
    seeds = seed_range(first, last)
    patterns = [MotionPattern.of(support, recordings(support, seeds)) for support in ("none", "wall", "corner")]
    answers = motion_verdict({pattern.name: pattern.measures for pattern in patterns})
    print(markdown(patterns), *(f"{name}: {answer}" for name, answer in answers.items()), sep="\n")
    pattern_figure(patterns).savefig(folder / "motion_pattern.png", dpi=130)
    rows = {"conditions": [pattern.summary() for pattern in patterns], "verdict": answers}
    (folder / "motion_pattern.json").write_text(json.dumps(rows, indent=2), encoding="utf-8")


if __name__ == "__main__":
    run_script(main)
