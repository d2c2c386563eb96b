"""Figures of the pages on the hand and on sensitivity."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hand_sensitivity import ENCLOSED_AIR, Row
from pilegrasp_ctrl.sections import HandModelConfig
from pilegrasp_ctrl.sim.hand import Hand
from pilegrasp_ctrl.validation.hand import finger_measurements as finger
from pilegrasp_ctrl.validation.hand.hand_bench import HandBench
from pilegrasp_ctrl.validation.hand.hand_table import attempt, tip_stiffness
from pilegrasp_ctrl.validation.hand.sliding import hand_course

PLAUSIBLE = (5.0, 50.0)
"""Stiffness at a vented finger's tip that its rubber makes plausible [N/m]."""
LOADS = np.array([0.1, 0.25, 0.5, 1.0, 1.5, 2.0])
CLOSURES = np.array([0.0, 0.3, 0.6, 1.0])
MODEL, REFERENCE, SECOND = "#1f5f99", "#999999", "#c2571a"


def hand_figure(file: str | PathLike[str]) -> None:
    """Draw deflection against load, stiffness against closure, and an attempt's push."""
    figure = Figure(figsize=(10.0, 3.2), layout="constrained")
    deflection, stiffness, push = figure.subplots(1, 3)
    hand = Hand.load("rbo_hand2")
    _draw_deflection(deflection, hand)
    for share, color in ((0.0, MODEL), (ENCLOSED_AIR, SECOND)):
        bench = HandBench.build(Hand.load("rbo_hand2", HandModelConfig(inflation_stiffness=share)))
        values = [finger.stiffness(bench, closure) for closure in CLOSURES]
        stiffness.plot(CLOSURES, values, "o-", color=color, label=f"inflation_stiffness = {share:g}")
    stiffness.set(xlabel="closure", ylabel="stiffness at the tip [N/m]", ylim=(0.0, None), title="Stiffness, inflated")
    stiffness.legend(frameon=False, fontsize=8)
    _draw_push(push, hand)
    figure.savefig(file, dpi=110)


def sensitivity_figure(rows: Sequence[Row], file: str | PathLike[str]) -> None:
    """Draw the success of every condition with its interval."""
    figure = Figure(figsize=(8.0, 0.32 * len(rows) + 1.0), layout="constrained")
    axes = figure.subplots()
    for place, row in enumerate(rows):
        rate, (low, high) = 100.0 * row.successes / row.attempts, row.interval
        color = REFERENCE if not row.condition.key else MODEL if rate >= 85.0 else SECOND
        axes.plot([100.0 * low, 100.0 * high], [place, place], color=color, linewidth=2.0)
        axes.plot([rate], [place], "o", color=color)
    axes.axvline(85.0, color=REFERENCE, linestyle=":", linewidth=1.0)
    axes.set_yticks(range(len(rows)), [row.condition.label.replace("`", "") for row in rows])
    axes.invert_yaxis()
    axes.set(xlabel="success [%], 95 % Wilson interval", xlim=(0.0, 101.0))
    figure.savefig(file, dpi=110)


def _draw_deflection(axes: Axes, hand: Hand) -> None:
    bench = HandBench.build(hand)
    soft, stiff = (1e3 * LOADS / value for value in PLAUSIBLE)
    axes.fill_between(LOADS, stiff, soft, color=REFERENCE, alpha=0.25, linewidth=0.0, label="5 to 50 N/m")
    axes.plot(LOADS, 1e3 * LOADS / tip_stiffness(hand), color=REFERENCE, label="small loads, formula")
    axes.plot(LOADS, [1e3 * finger.deflection(bench, load) for load in LOADS], "o", color=MODEL, label="measured")
    axes.set(xlabel="load at the tip [N]", ylabel="deflection [mm]", ylim=(0.0, 60.0), title="Vented finger")
    axes.legend(frameon=False, fontsize=8)


def _draw_push(axes: Axes, hand: Hand) -> None:
    course = hand_course(attempt("rbo_hand2"), hand)
    axes.plot(course.time, 1e3 * course.palm_height, color=MODEL, label="palm above the table [mm]")
    axes.plot(course.time, np.degrees(course.bend), color=SECOND, label="bend of the fingers [°]")
    axes.axhline(0.0, color=REFERENCE, linewidth=1.0)
    axes.set(xlabel="time in the push [s]", ylim=(0.0, 70.0), title="An attempt's push")
    axes.legend(frameon=False, fontsize=8)
