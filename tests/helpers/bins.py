"""Layouts with a bin and its push goals."""

from functools import cache

from pilegrasp_ctrl.config import build_scenario
from pilegrasp_ctrl.planning.layout import make_layout
from pilegrasp_ctrl.programs.bin_reach import bin_goals
from pilegrasp_ctrl.sim.hand import Hand
from pilegrasp_ctrl.sim.objects import objects_of


@cache
def layout_of(kind="wall", hand="rbo_hand2", order=False, **support):
    """Return the layout of a bin with its goals, for the WAM; `support` holds keys of [support]."""
    keys = {f"support.{key}": value for key, value in support.items()}
    program = "order" if order else "grasp"
    overrides = {"support.kind": kind, "support.bin": True, "hand": hand, "program": program, **keys}
    scenario = build_scenario({}, overrides)
    diameter = objects_of(scenario.pile).diameter
    layout = make_layout(scenario.support, scenario.pile, diameter, scenario.order if order else None)
    return layout.with_goals(bin_goals(scenario, Hand.load(scenario.hand), layout))
