"""The checks, by what they look at: whoever adds one writes a function in a module that `MODULES` names."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Literal, NamedTuple

from ...exceptions import PilegraspError

Kind = Literal["model", "arm", "hand", "part", "scenario"]
"""What a check looks at: a bare URDF or MJCF, the folder of an arm or of a hand, an object, or a scenario."""

Level = Literal["problem", "note", "fact"]
"""A problem prevents a run, a note should be read before one, a fact answers a question."""

MODULES = ("arm_checks", "scenario_checks", "hand_checks", "part_checks")
"""Modules of this folder that hold checks, in the order in which these are made."""


class Finding(NamedTuple):
    """A sentence about what was checked.

    Attributes:
        level: Whether it prevents a run.
        about: What it is about, such as "reach".
        text: The sentence.
    """

    level: Level
    about: str
    text: str


@dataclass(frozen=True)
class Subject:
    """What is checked.

    Attributes:
        kind: What it is.
        name: Name of an arm, hand or scenario that ships, or a path.
        hands: Hands with which an arm is checked.
        seed: Seed of the pile of a scenario.
        picture: File for a picture of the planned poses of a scenario; None for no picture.
        overrides: Keys of a scenario, as key=value.
        tool_frame: Frame of a bare model that carries the hand; None if it is not given.
        joints: Number of joints of a bare model; None for all.
    """

    kind: Kind
    name: str
    hands: tuple[str, ...] = ("rbo_hand2", "shovel")
    seed: int = 0
    picture: Path | None = None
    overrides: tuple[str, ...] = ()
    tool_frame: str | None = None
    joints: int | None = None


Check = Callable[[Subject], Iterable[Finding]]
"""A function that looks at a subject; an error of the library that it raises becomes a problem."""

_checks: dict[str, list[Check]] = {}


def checks(kind: Kind) -> Callable[[Check], Check]:
    """Return a decorator that adds a check of things of this kind."""

    def add(check: Check) -> Check:
        _checks.setdefault(kind, []).append(check)
        return check

    return add


def findings(subject: Subject) -> Iterator[Finding]:
    """Make every check of a subject; after the first problem of a kind of check the others still run."""
    for module in MODULES:
        import_module(f".{module}", __package__)
    said: set[str] = set()
    for check in _checks.get(subject.kind, []):
        try:
            for finding in check(subject):
                if finding.text not in said:
                    yield finding
                said.add(finding.text)
        except PilegraspError as error:
            # The same fault usually stops several checks.
            if str(error) not in said:
                yield Finding("problem", check.__name__.replace("_", " "), str(error))
            said.add(str(error))
