"""Print the measurements of the hands, on the bench and in one attempt each; with a file name, draw the figure.

Usage: python docs/studies/hand_table.py [FIGURE.png]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pilegrasp_ctrl.sections import HandModelConfig
from pilegrasp_ctrl.sim.hand import Hand
from pilegrasp_ctrl.validation.hand import hand_bench
from pilegrasp_ctrl.validation.hand.hand_bench import HandBench
from pilegrasp_ctrl.validation.hand.hand_table import markdown, measurements, recorded_attempt, tip_stiffness
from pilegrasp_ctrl.validation.hand.sliding import hand_course
from script import run_script

PLAUSIBLE = (5.0, 50.0)
"""Range of the stiffness at a vented finger's tip that is plausible for its rubber [N/m]."""

ENCLOSED_AIR = 1.1
"""Stiffness from the air enclosed in a finger, over the bending stiffness [-]; derived in the hand's README."""

LOADS = np.array([0.1, 0.25, 0.5, 1.0, 1.5, 2.0])
"""Loads of the fingertip [N]; chosen."""

CLOSURES = np.array([0.0, 0.3, 0.6, 1.0])
"""Closures of the drawn stiffness [-]; chosen."""

MODEL, REFERENCE, SECOND = "#1f5f99", "#999999", "#c2571a"
"""Colours of the model, of its reference, and of a second curve."""


def hand_figure(file: Path) -> None:
    """Draw deflection against load, stiffness against closure, and an attempt's push."""
    figure = Figure(figsize=(10.0, 3.2), layout="constrained")
    deflection, stiffness, push = figure.subplots(1, 3)
    hand = Hand.load("rbo_hand2")
    _draw_deflection(deflection, hand)
    for share, color in ((0.0, MODEL), (ENCLOSED_AIR, SECOND)):
        bench = HandBench.build(Hand.load("rbo_hand2", HandModelConfig(inflation_stiffness=share)))
        values = [hand_bench.stiffness(bench, closure) for closure in CLOSURES]
        stiffness.plot(CLOSURES, values, "o-", color=color, label=f"inflation_stiffness = {share:g}")
    stiffness.set(xlabel="closure", ylabel="stiffness at the tip [N/m]", ylim=(0.0, None), title="Stiffness, inflated")
    stiffness.legend(frameon=False, fontsize=8)
    _draw_push(push, hand)
    figure.savefig(file, dpi=110)


def _draw_deflection(axes: Axes, hand: Hand) -> None:
    bench = HandBench.build(hand)
    soft, stiff = (1e3 * LOADS / value for value in PLAUSIBLE)
    axes.fill_between(LOADS, stiff, soft, color=REFERENCE, alpha=0.25, linewidth=0.0, label="5 to 50 N/m")
    axes.plot(LOADS, 1e3 * LOADS / tip_stiffness(hand), color=REFERENCE, label="small loads, formula")
    measured = [1e3 * hand_bench.deflection(bench, load) for load in LOADS]
    axes.plot(LOADS, measured, "o", color=MODEL, label="measured")
    axes.set(xlabel="load at the tip [N]", ylabel="deflection [mm]", ylim=(0.0, 60.0), title="Vented finger")
    axes.legend(frameon=False, fontsize=8)


def _draw_push(axes: Axes, hand: Hand) -> None:
    course = hand_course(recorded_attempt("rbo_hand2"), hand)
    axes.plot(course.time, 1e3 * course.palm_height, color=MODEL, label="palm above the table [mm]")
    axes.plot(course.time, np.degrees(course.bend), color=SECOND, label="bend of the fingers [°]")
    axes.axhline(0.0, color=REFERENCE, linewidth=1.0)
    axes.set(xlabel="time in the push [s]", ylim=(0.0, 70.0), title="An attempt's push")
    axes.legend(frameon=False, fontsize=8)


def main(*figures: Path) -> None:
    """Measure the hands, print the table and draw the figures; this takes a minute on one core."""
    print(markdown(measurements()))
    for file in figures:
        hand_figure(file)


if __name__ == "__main__":
    run_script(main)
