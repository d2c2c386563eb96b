"""What others take for a tick on the same states: who they are, what their tick does, and how to install them."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from typing import NamedTuple

from .motion import RecordedLine


class Peer(NamedTuple):
    """Somebody else's tick.

    Attributes:
        key: its name in the result.
        does: what one tick does, and what it does not.
        requires: the module that it needs.
        install: how to install it.
        make: from the recorded line to the tick.
    """

    key: str
    does: str
    requires: str
    install: str
    make: Callable[[RecordedLine], Callable[[int], object]]

    def tick(self, line: RecordedLine) -> Callable[[int], object] | str:
        """Return its tick on the recorded line after a first call, or why there is none."""
        if find_spec(self.requires) is None:
            return f"not installed; {self.install}"
        try:
            tick = self.make(line)
            tick(0)
        except Exception as error:
            # A peer that is broken, or another package of its name, is no reason to measure nothing.
            return f"does not work here: {type(error).__name__}: {error}"
        return tick


def _made_by(module: str, function: str, *arguments: str) -> Callable[[RecordedLine], Callable[[int], object]]:
    """Return a maker that imports its module on first use, so that a peer which is absent costs nothing."""

    def make(line: RecordedLine) -> Callable[[int], object]:
        tick: Callable[[int], object] = getattr(import_module(f".{module}", __package__), function)(line, *arguments)
        return tick

    return make


PEERS = (
    Peer(
        "mink",
        "solve_ik with daqp: frame and posture task, position and speed limits; joint velocities, no dynamics",
        "mink",
        "pip install mink",
        _made_by("mink", "mink_tick"),
    ),
    Peer(
        "pink",
        "solve_ik with daqp: frame and posture task, position and speed limits; joint velocities, no dynamics",
        "pink",
        "pip install pin-pink",
        _made_by("pink", "pink_tick"),
    ),
    Peer(
        "tsid",
        "AccForce formulation in C++ with HQuadProgFast: SE3 and posture task, every limit; torques, no friction",
        "tsid",
        "docs/benchmark.md says how it is built",
        _made_by("tsid", "tsid_tick"),
    ),
    Peer(
        "naive daqp",
        "the project's program in plain numpy, by qpsolvers.solve_qp with daqp; torques, no friction",
        "qpsolvers",
        "pip install qpsolvers daqp",
        _made_by("naive", "naive_tick", "daqp"),
    ),
    Peer(
        "naive osqp",
        "the project's program in plain numpy, by qpsolvers.solve_qp with osqp; torques, no friction",
        "qpsolvers",
        "pip install qpsolvers osqp",
        _made_by("naive", "naive_tick", "osqp"),
    ),
)
