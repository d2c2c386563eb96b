"""Print the checks of the physics as the table of docs/physics.md, and draw its figure.

Usage: python docs/studies/physics_report.py FIGURE.png
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pilegrasp_ctrl.files import check_output
from pilegrasp_ctrl.sim.hand import Hand
from pilegrasp_ctrl.sim.objects import OBJECT_MODELS
from pilegrasp_ctrl.validation.physics.contact_rig import ContactRig
from pilegrasp_ctrl.validation.physics.friction import ROLLING, roll, slip
from pilegrasp_ctrl.validation.physics.physics_check import markdown
from pilegrasp_ctrl.validation.physics.restitution import SWEEP, TOLERANCE, sweep
from pilegrasp_ctrl.validation.physics.suite import physics_checks
from script import run_script


def figure() -> Figure:
    """Draw measured restitution, slip and rolling beside the requested values."""
    drawing = Figure(figsize=(11.0, 3.6), layout="constrained")
    restitution, slipping, rolling = drawing.subplots(1, 3)
    _draw_restitution(restitution)
    _draw_slip(slipping)
    _draw_rolling(rolling)
    for axes in (restitution, slipping, rolling):
        axes.grid(color="0.9")
        axes.legend(frameon=False, fontsize=8)
    return drawing


def _draw_restitution(axes: Axes) -> None:
    results = sweep("shovel", "table")
    means = np.array([result.values.mean() for result in results])
    least, most = (np.array([function(result.values) for result in results]) for function in (np.min, np.max))
    axes.fill_between(SWEEP, least, most, alpha=0.25, label="single impacts")
    axes.plot(SWEEP, means, "o-", markersize=4, label="mean over phases and heights")
    axes.plot(SWEEP, np.array(SWEEP) + TOLERANCE, "k:", linewidth=1, label=f"requested ± {TOLERANCE}")
    axes.plot(SWEEP, np.array(SWEEP) - TOLERANCE, "k:", linewidth=1)
    axes.set(title="Light sphere dropped on the table", xlabel="requested restitution", ylabel="measured")


def _draw_slip(axes: Axes) -> None:
    shovel = Hand.load("shovel")
    for name in ("cube", "cylinder"):
        rig = ContactRig.build(OBJECT_MODELS[name], shovel)
        friction = rig.object_model.surface.lateral
        result = slip(rig, rig.spots["table"], friction)
        axes.plot(np.degrees(result.slopes), 1e3 * result.speeds, label=name)
    axes.axvline(np.degrees(np.arctan(friction)), color="k", linestyle=":", linewidth=1, label="atan(mu)")
    axes.set(title="Table tilted slowly", xlabel="slope [deg]", ylabel="speed [mm/s]", ylim=(-20.0, 300.0))


def _draw_rolling(axes: Axes) -> None:
    shovel = Hand.load("shovel")
    for name, axis, words in ROLLING:
        result = roll(ContactRig.build(OBJECT_MODELS[name], shovel), axis)
        (line,) = axes.plot(result.times, result.speeds, label=words)
        formula = result.speeds[0] - result.formula * (result.times - result.times[0])
        axes.plot(result.times, formula, ":", color=line.get_color(), linewidth=2.5)
    axes.set(title="Rolling (dotted: formula)", xlabel="time [s]", ylabel="speed [m/s]")


def main(file: Path) -> None:
    """Run the checks, print the table and draw the figure into FILE, a PNG."""
    check_output(file, ".png")
    print(markdown(physics_checks(lambda share, name: print(f"{share:4.0%} {name}", file=sys.stderr))))
    figure().savefig(file, dpi=90)


if __name__ == "__main__":
    run_script(main)
