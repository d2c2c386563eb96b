"""The programs by the names in a scenario: those that ship, and a user's plan."""

from __future__ import annotations

from ..program_traits import PROGRAM_TRAITS
from .order_program import OrderProgram
from .own_plan import OwnPlan
from .program import Program
from .shipped import LineProgram, PileProgram
from .swap_program import SwapProgram

PROGRAMS: dict[str, Program] = {
    "grasp": PileProgram(grasp=True),
    "push": PileProgram(grasp=False),
    "line": LineProgram(),
    "order": OrderProgram(),
    "swap": SwapProgram(),
}
"""Shipped programs; `PROGRAM_TRAITS` has the same names."""


def program_of(name: str) -> Program:
    """Return a shipped program, or the program of a user's plan.

    Raises:
        ConfigurationError: The plan cannot be found, or takes other arguments.
    """
    return PROGRAMS[name] if name in PROGRAM_TRAITS else OwnPlan.load(name)
