"""Sequences that react to a failure: run a primitive, and after its failure others, such as back off and push again."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from ..types import Outcome
from .free_motions import Move
from .primitive import Primitive

BACK_SPEED = 0.1
"""Speed of backing off [m/s]; chosen, that of a push."""

RunOne = Callable[[Primitive], Outcome]
"""Function that runs one primitive in the loop and returns its outcome."""


class Composite(Protocol):
    """Several primitives in the place of one, which are chosen while they run."""

    def run(self, run_one: RunOne) -> list[Outcome]:
        """Run primitives one after another, and return their outcomes; the last one decides whether all failed."""


@dataclass(frozen=True, slots=True, eq=False)
class Retry:
    """A primitive that is tried again after a failure.

    A fault is no failure: a collision, a saturated sensor or the time limit end the attempt.

    Attributes:
        primitive: First try.
        again: Primitives of each further try.
        tries: Largest number of tries.
    """

    primitive: Primitive
    again: tuple[Primitive, ...]
    tries: int = 2

    def run(self, run_one: RunOne) -> list[Outcome]:
        """Try until one try does not fail."""
        outcomes = [run_one(self.primitive)]
        for _ in range(self.tries - 1):
            if outcomes[-1].status != "failed" or outcomes[-1].fault:
                break
            outcomes += run_in_order(self.again, run_one)
        return outcomes


def push_again(push: Any, back: float, tries: int = 2, make: Callable[[Any], Primitive] = lambda push: push) -> Retry:
    """Return a push that, after a failure, backs off by `back` [m] and is repeated over this distance.

    Args:
        push: A `Push`, or another dataclass with its `direction`, `closure` and `travel`.
        back: Distance to back off [m].
        tries: Largest number of pushes.
        make: Function that makes your own primitive from each of the pushes.
    """
    off = Move(-back * np.asarray(push.direction), BACK_SPEED, push.closure, "back_off")
    return Retry(make(push), (off, make(replace(push, travel=back))), tries)


def run_in_order(steps: Sequence[Primitive | Composite], run_one: RunOne) -> list[Outcome]:
    """Run primitives and composites until one fails, and return all outcomes."""
    outcomes: list[Outcome] = []
    for step in steps:
        composite: Any = step
        outcomes += composite.run(run_one) if hasattr(step, "run") else [run_one(composite)]
        if outcomes[-1].status == "failed":
            break
    return outcomes
