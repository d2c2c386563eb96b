"""What the programs of an attempt are, as far as a scenario must know: their names, and the keys that they read."""

from __future__ import annotations

from dataclasses import dataclass

from .plugins import is_plugin


@dataclass(frozen=True, slots=True)
class ProgramTraits:
    """Traits of a program.

    Attributes:
        sections: Those of the tables `strategy`, `line` and `order` that the program reads.
        touches: Whether the hand touches floor and objects. The arm's base then stands behind the push.
        delivers: Whether objects are taken from a bin and released over a crate beside it.
        swaps: Whether another hand, `strategy.pushing_hand`, pushes in place of the hand.
    """

    sections: frozenset[str]
    touches: bool = True
    delivers: bool = False
    swaps: bool = False


PROGRAM_TRAITS = {
    "grasp": ProgramTraits(frozenset({"strategy"})),
    "push": ProgramTraits(frozenset({"strategy"})),
    "line": ProgramTraits(frozenset({"line"}), touches=False),
    "order": ProgramTraits(frozenset({"strategy", "order"}), delivers=True),
    "swap": ProgramTraits(frozenset({"strategy"}), swaps=True),
}
"""Traits of the shipped programs; `pilegrasp_ctrl.programs.registry` holds the programs under the same names."""

OWN_PLAN = ProgramTraits(frozenset({"strategy", "line"}))
"""Traits of a user's plan."""

PLAN_PARAMETERS = ("parts",)
"""Parameters of a user's plan. They must have these names, so that a file cannot run any function it likes."""


OPERATORS = ("sees", "alternates", "bandit")
"""Shipped operators of an order; `pilegrasp_ctrl.programs.line_rules` holds the rules of those that do not see."""

RULE_PARAMETERS = ("lines", "told", "random")
"""Parameters of a user's rule for the lines of an order; they must have these names."""


def traits_of(program: str) -> ProgramTraits:
    """Return the traits of a shipped program, or those of a user's plan."""
    return PROGRAM_TRAITS.get(program, OWN_PLAN)


def is_program(name: str) -> bool:
    """Return whether a name is that of a shipped program, or may be that of a user's plan."""
    return name in PROGRAM_TRAITS or is_plugin(name)


def is_operator(name: str) -> bool:
    """Return whether a name is that of a shipped operator, or may be that of a user's rule."""
    return name in OPERATORS or is_plugin(name)
