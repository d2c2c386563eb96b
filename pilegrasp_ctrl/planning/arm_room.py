"""The room of an arm: where its base stands, and from where to where its fingertips reach in a push. Pure numbers."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cache
from typing import Any

from ..exceptions import ModelError, remedy_for
from ..robots import description

LARGEST = 10.0
"""Largest length in the room of an arm [m]; chosen."""


@dataclass(frozen=True, slots=True)
class ArmRoom:
    """Distances from the arm's axis, along the push, and the room of its base; `robot.toml` states them in [room].

    Attributes:
        base_below_table: Height of the table top above the arm's base [m].
        base_radius: Radius of the area that the base takes on the table [m].
        min_touch_distance: Least distance to the touch-down [m]. Nearer, the wrist runs into its limit.
        max_touch_distance: Greatest distance to the touch-down [m]. Farther, the end of the push is hardly in reach.
        push_end: Distance to the point that the push aims at, if the touch-down distances allow it [m].
        reach: Candidates for the farthest distance of the fingertips in a push, longest first [m].
        wall_distance: Distance to the wall, and to the far wall of a bin, along the push of alpha = 0 [m].
        corner_distance: Distance to a corner's apex [m].
    """

    base_below_table: float
    base_radius: float
    min_touch_distance: float
    max_touch_distance: float
    push_end: float
    reach: tuple[float, ...]
    wall_distance: float
    corner_distance: float


def stated_room(robot: str) -> ArmRoom | None:
    """Return the room that an arm's `robot.toml` states; None if it states none.

    Args:
        robot: Name of an arm that ships, or path of a folder.

    Raises:
        ModelError: There is no such arm, or its table [room] is not one.
    """
    table = description(robot).get("room")
    return None if table is None else _room(table, robot)


@cache
def default_room() -> ArmRoom:
    """Return the room of the WAM, the scenarios' default arm."""
    return _room(description("wam7").get("room"), "wam7")


def _room(table: Any, robot: str) -> ArmRoom:
    where = f"{robot}: [room] in its robot.toml"
    names = [field.name for field in fields(ArmRoom)]
    if not isinstance(table, dict):
        raise ModelError(f"{where} must be a table of {', '.join(names)}")
    for key in table:
        if key not in names:
            raise ModelError(f"{where} has an unknown key {key!r}; {remedy_for(key, names, ', '.join(names))}")
    values: dict[str, Any] = {}
    for name in names:
        value = table.get(name)
        if name == "reach":
            good = isinstance(value, list) and bool(value) and all(map(_is_length, value))
            good = good and sorted(value, reverse=True) == value  # type: ignore[arg-type]
            values[name] = tuple(map(float, value)) if good else None  # type: ignore[arg-type]
        else:
            values[name] = float(value) if _is_length(value) else None  # type: ignore[arg-type]
        if values[name] is None:
            kind = "a list of lengths, the longest first" if name == "reach" else "a length"
            raise ModelError(f"{where}: {name} = {value!r:.80} must be {kind} from 0 to {LARGEST:g} m")
    room = ArmRoom(**values)
    if not room.min_touch_distance <= room.max_touch_distance < room.reach[-1]:
        raise ModelError(f"{where}: min_touch_distance <= max_touch_distance < every reach must hold; correct them")
    return room


def _is_length(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and 0.0 <= value <= LARGEST
