"""The keyword arguments that every way of making an arm takes, and their names."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, TypedDict, TypeVar, cast

from numpy.typing import ArrayLike

from ..exceptions import ArgumentError, ModelError, remedy_for
from ..types import MassProperties, Pose

T = TypeVar("T")

MOST_NAMES = 24
"""Longest list of names in an error message; chosen."""


class ArmOptions(TypedDict, total=False):
    """Keyword arguments of `ArmModel`, which its other constructors take too; `ArmModel.__init__` describes them."""

    transform_tool_to_frame: Pose | None
    tool: MassProperties | None
    base: Pose | None
    gravity: ArrayLike | None
    name: str | None
    q_lower: ArrayLike | None
    q_upper: ArrayLike | None
    velocity_limit: ArrayLike | None
    torque_limit: ArrayLike | None
    armature: ArrayLike | None
    friction_coulomb: ArrayLike | None
    friction_viscous: ArrayLike | None
    joint_to_motor: ArrayLike | None
    motor_torque_limit: ArrayLike | None


NUMBERS = (
    "q_lower",
    "q_upper",
    "velocity_limit",
    "torque_limit",
    "armature",
    "friction_coulomb",
    "friction_viscous",
    "joint_to_motor",
    "motor_torque_limit",
)
"""The options that are numbers of the joints; `ArmModel` has an attribute for each but the armature."""


def merged(*options: ArmOptions) -> ArmOptions:
    """Return options of which later ones replace earlier ones; None stands for an option that is not given.

    Raises:
        ArgumentError: A name is unknown.
    """
    for name in (name for some in options for name in some if name not in ArmOptions.__annotations__):
        remedy = remedy_for(name, ArmOptions.__annotations__, f"there are {', '.join(ArmOptions.__annotations__)}")
        raise ArgumentError(f"an arm has no argument {name!r}; {remedy}")
    given = {name: value for some in options for name, value in some.items() if value is not None}
    return cast(ArmOptions, given)


def checked(what: str, value: Any, kind: type[T]) -> T:
    """Return an argument of a function for users.

    Raises:
        ModelError: The argument is not of the type `kind`.
    """
    if not isinstance(value, kind):
        raise ModelError(f"{what} must be a {kind.__name__}; it is a {type(value).__name__}")
    return value


def listed(names: Iterable[str]) -> str:
    """Return names for an error message, separated by commas; of many names, the first ones."""
    names = list(names)
    more = len(names) - MOST_NAMES
    return ", ".join(names) if more <= 0 else f"{', '.join(names[:MOST_NAMES])} and {more} more"
