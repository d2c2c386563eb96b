"""All checks of the physics, in the order in which they are printed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

from ..hand.hand_table import measurements
from .energy import energy_checks
from .friction import friction_checks
from .hung_weight import hung_weight_checks
from .penetration import penetration_checks
from .physics_check import PhysicsCheck
from .plant import plant_checks
from .restitution import restitution_checks, step_halving_checks

KNOWN = {
    "energy: gained by 14 cylinders that are pushed": "contacts that jump by less than `Stepper` looks at again",
    "slip: cube on shovel floor": "the leading edge carries most, and one friction limit holds for sliding and rolling",
    "restitution: light sphere on finger of rbo hand2": "the rubber springs back; 0.1 is that of hard parts",
}
"""Checks that are known to be missed, each with the reason."""

Progress = Callable[[float, str], None]
"""Callback that gets the finished share and the name of the last check."""


def hand_checks() -> Iterator[PhysicsCheck]:
    """Check the hands on their bench and in one attempt each."""
    yield from (replace(check, name=f"hand: {check.name}") for check in measurements())


SUITES: tuple[tuple[float, Callable[[], Iterable[PhysicsCheck]]], ...] = (
    (30.0, restitution_checks),
    (4.0, step_halving_checks),
    (20.0, friction_checks),
    (12.0, energy_checks),
    (6.0, hung_weight_checks),
    (3.0, plant_checks),
    (40.0, penetration_checks),
    (40.0, hand_checks),
)
"""Rough share of each suite in the whole time, and the function that yields its checks one by one."""


def physics_checks(progress: Progress = lambda share, name: None) -> list[PhysicsCheck]:
    """Run every check.

    Raises:
        PilegraspError: A model cannot be built, or a pile does not settle.
    """
    checks: list[PhysicsCheck] = []
    total, begun = sum(weight for weight, _ in SUITES), 0.0
    for weight, suite in SUITES:
        for check in suite():
            checks.append(replace(check, known=KNOWN.get(check.name, "")))
            progress(begun / total, check.name)
        begun += weight
    return checks
