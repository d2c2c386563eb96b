"""Push goals in a bin, by one rule for every bin, hand and arm. Pure geometry; what the arm can do is asked for.

A line to a wall or corner is a goal if the hand fits between the walls along it. The arm must also be able to put the
hand down far enough back. The hand is the balls of its outline, which keep `HAND_CLEARANCE` off every wall.

- The far wall: all lines at right angles to it on which both sides of the hand clear the side walls.
- A corner: the direction nearest to its bisector in which a push is at least `LEAST_SHARE` as long as to the far wall.
  The first line is the one on which the hand meets both walls at once; the others pass up to `CORNER_RANGE` farther
  from the side wall.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..exceptions import ConfigurationError
from ..types import Array
from ..vectors import components, inner
from .crate import Crate
from .push_goal import PushGoal
from .strategy import PRE_GRASP_HEIGHT, START_BACK
from .walls import Wall

HAND_CLEARANCE = 0.02
"""Clearance of the hand to the walls beside and behind it [m]; the soft hand and the arm deflect by less."""

LEAST_PUSH = 0.10
"""Shortest push to the far wall for which a bin can be used [m]; chosen: some two objects and the clearance."""

LEAST_SHARE = 0.8
"""Length of a push, over the longest to the far wall, from which a line or a corner is a goal [-]; chosen."""

CORNER_RANGE = 0.03
"""Distance between the first and the last line to a corner [m]; chosen: half a hand."""

CORNER_DIRECTIONS = (45.0, 40.0, 35.0, 30.0, 25.0, 20.0, 15.0, 10.0)
"""Directions to a corner that are tried, off the length of the bin [deg], the bisector first."""

LINE_SPACING = 0.03
"""Largest distance between two lines whose push is measured [m]; chosen."""

STEP = 0.01
"""Step in which the length of a push is measured [m]; chosen."""

FARTHER = 1e-6
"""Component of a wall's inward normal along the push [-], above which a wall is not ahead; rounding."""

ROUNDING = 1e-9
"""Distance by which a clearance may be missed [m]; rounding."""

Outline = Callable[[float], Array]
"""Function from the yaw of a push of alpha = 0 [rad] to the hand's outline (n, 4) as it pushes. A row is a ball: its
centre relative to the fingertips in world axes, and its radius [m]."""

ArmClears = Callable[[float, Array, Array], bool]
"""Function of the yaw of a push [rad], its touch-down (2,) and its end (2,) [m]. It returns whether the arm reaches
both, and keeps its links off all walls as it comes down."""


@dataclass(frozen=True, slots=True, eq=False)
class _Line:
    """A line of a push: its offset to the left of the goal, and how far back from the anchor it may begin [m]."""

    offset: float
    longest: float


def find_bin_goals(
    crate: Crate,
    walls: Sequence[Wall],
    outline: Outline,
    arm_clears: ArmClears,
    start_height: float,
    alpha: float = 0.0,
) -> tuple[PushGoal, ...]:
    """Return the goals "wall", "corner_left" and "corner_right" of a bin, without corners that cannot be pushed to.

    Args:
        crate: Bin.
        walls: Walls of all crates.
        outline: The hand's outline by the yaw of the push.
        arm_clears: What the arm can do.
        start_height: Height of the fingertips before the approach [m].
        alpha: Direction of a push off its goal's direction [rad].

    Raises:
        ConfigurationError: The hand is wider than the bin, the bin is too short for it, or out of the arm's reach.
    """
    finder = _Finder(crate, walls, outline, arm_clears, start_height, alpha)
    wall = finder.wall()
    corners = (finder.corner(side, LEAST_SHARE * wall.longest) for side in ("left", "right"))
    return (wall, *(corner for corner in corners if corner is not None))


@dataclass(frozen=True, slots=True, eq=False)
class _Finder:
    """The arguments of `find_bin_goals`."""

    crate: Crate
    walls: Sequence[Wall]
    outline: Outline
    arm_clears: ArmClears
    start_height: float
    alpha: float

    def wall(self) -> PushGoal:
        """Return the goal at the far wall."""
        anchor = np.array([self.crate.far, self.crate.center[1]])
        balls, direction, left = self._axes(0.0)
        half = 0.5 * self.crate.inner[1]
        offsets = [0.005 * step for step in range(-math.floor(half / 0.005), math.floor(half / 0.005) + 1)]
        free = [s for s in offsets if self._beside(balls, anchor + s * left, direction) >= HAND_CLEARANCE - ROUNDING]
        if not free:
            wide = float((balls[:, 1] + balls[:, 3]).max() - (balls[:, 1] - balls[:, 3]).min())
            raise ConfigurationError(
                f"support.bin_size[1] = {self.crate.inner[1]:g} m is too narrow: the hand is {1000 * wide:.0f} mm wide "
                f"and needs {1000 * (wide + 2.0 * HAND_CLEARANCE):.0f} mm between the walls; take a wider bin or "
                "another hand"
            )
        count = 1 + math.ceil((free[-1] - free[0]) / LINE_SPACING)
        lines = [self._line(0.0, anchor, s, LEAST_PUSH) for s in np.linspace(free[0], free[-1], count).tolist()]
        found = [line for line in lines if line is not None]
        if not found:
            self._refuse(anchor + 0.5 * (free[0] + free[-1]) * left)
        best = max(line.longest for line in found)
        kept = [line for line in found if line.longest >= LEAST_SHARE * best]
        return _goal("wall", anchor, 0.0, kept)

    def corner(self, side: str, least: float) -> PushGoal | None:
        """Return the goal at a corner with pushes of at least `least` [m], or None."""
        sign = 1.0 if side == "left" else -1.0
        apex = np.array([self.crate.far, self.crate.center[1] + sign * 0.5 * self.crate.inner[1]])
        for degrees in CORNER_DIRECTIONS:
            yaw = sign * math.radians(degrees)
            first = self._contact_offset(yaw, apex)
            offsets = (first, first - sign * 0.5 * CORNER_RANGE, first - sign * CORNER_RANGE)
            lines = [self._line(yaw, apex, offset, least) for offset in offsets]
            if kept := [line for line in lines if line is not None]:
                return _goal(f"corner_{side}", apex, yaw, kept)
        return None

    def _axes(self, yaw: float) -> tuple[Array, Array, Array]:
        """Return the outline, the direction (2,) of the push, and the direction (2,) to the left of the goal."""
        along = yaw + self.alpha
        direction = np.array([math.cos(along), math.sin(along)])
        return self.outline(yaw), direction, np.array([-math.sin(yaw), math.cos(yaw)])

    def _line(self, yaw: float, anchor: Array, offset: float, least: float) -> _Line | None:
        """Return a line with the longest push on it, or None if that is shorter than `least` [m]."""
        balls, direction, left = self._axes(yaw)
        point = anchor + offset * left
        end = point + self._advance(balls, point, direction) * direction
        beyond = inner(point - end, direction)
        turned = yaw + self.alpha

        def clears(steps: int) -> bool:
            touch = end - steps * STEP * direction
            return self._hand_clears(balls, touch, direction) and self.arm_clears(turned, touch, end)

        fewest, most = math.ceil(least / STEP - 1e-9), round((math.hypot(*self.crate.inner[:2])) / STEP)
        if not clears(fewest):
            return None
        while most - fewest > 1:
            middle = (fewest + most) // 2
            fewest, most = (middle, most) if clears(middle) else (fewest, middle)
        return _Line(offset, beyond + fewest * STEP)

    def _contact_offset(self, yaw: float, apex: Array) -> float:
        """Return the offset of the line to a corner on which the hand meets both walls at once [m]."""
        balls, direction, left = self._axes(yaw)
        gaps, slopes = [], []
        for wall in self._bin_walls():
            normal, distance = self._gap(balls, wall, apex)
            if inner(normal, direction) < -FARTHER:
                gaps.append(distance)
                slopes.append((inner(normal, direction), inner(normal, left)))
        (a, b), (c, d) = slopes[:2]
        return (c * gaps[0] - a * gaps[1]) / (a * d - b * c)

    def _bin_walls(self) -> list[Wall]:
        """Return the walls of the bin."""
        return [wall for wall in self.walls if wall.crate == self.crate.name]

    def _gap(self, balls: Array, wall: Wall, tip: Array) -> tuple[Array, float]:
        """Return a wall's inward normal (2,), and its distance to the hand with its fingertips at `tip` (2,) [m]."""
        normal = np.array([math.cos(wall.yaw), math.sin(wall.yaw)])
        face = wall.center[:2] + wall.half_size[0] * normal
        low = balls[balls[:, 2] - balls[:, 3] < wall.center[2] + wall.half_size[2]]
        reach = float((components(low[:, :2], normal) - low[:, 3]).min(initial=0.0))
        return normal, inner(tip - face, normal) + reach

    def _advance(self, balls: Array, tip: Array, direction: Array) -> float:
        """Return how far the hand moves from `tip` until it meets a wall ahead [m]; negative if it is in it."""
        ahead = [self._gap(balls, wall, tip) for wall in self._bin_walls()]
        return min(gap / -inner(normal, direction) for normal, gap in ahead if inner(normal, direction) < -FARTHER)

    def _beside(self, balls: Array, tip: Array, direction: Array) -> float:
        """Return the distance of the hand to the walls beside it at the end of a push through `tip` [m]."""
        end = tip + self._advance_to_far(balls, tip, direction) * direction
        return min(self._gap(balls, wall, end)[1] for wall in self._bin_walls()[2:])

    def _advance_to_far(self, balls: Array, tip: Array, direction: Array) -> float:
        """Return how far the hand moves from `tip` until it meets the far wall [m]."""
        normal, gap = self._gap(balls, self._bin_walls()[0], tip)
        return gap / -inner(normal, direction)

    def _hand_clears(self, balls: Array, touch: Array, direction: Array) -> bool:
        """Return whether the hand keeps its clearance to all walls from its start down to `touch`."""
        high, low = self.start_height, PRE_GRASP_HEIGHT
        for share in (0.0, 0.25, 0.5, 0.75, 1.0):
            height = (1.0 - share) * high + share * low
            if not self._clear_of_walls(balls, touch - (1.0 - share) * START_BACK * direction, height):
                return False
        return self._clear_of_walls(balls, touch, 0.0)

    def _clear_of_walls(self, balls: Array, tip: Array, height: float) -> bool:
        """Return whether the hand keeps its clearance to all walls with its fingertips at `tip` and `height`."""
        for wall in self.walls:
            low = balls[height + balls[:, 2] - balls[:, 3] < wall.center[2] + wall.half_size[2]]
            normal = np.array([math.cos(wall.yaw), math.sin(wall.yaw)])
            offsets = low[:, :2] + (tip - wall.center[:2])
            along = np.abs(components(offsets, normal)) - wall.half_size[0]
            aside = np.abs(components(offsets, np.array([-normal[1], normal[0]]))) - wall.half_size[1]
            distance = np.hypot(np.maximum(along, 0.0), np.maximum(aside, 0.0)) - low[:, 3]
            if len(low) and float(distance.min()) < HAND_CLEARANCE - ROUNDING:
                return False
        return True

    def _refuse(self, point: Array) -> None:
        """Raise the reason why no push to the far wall is possible.

        Raises:
            ConfigurationError: The bin is too short for the hand, or the arm does not reach into it.
        """
        balls, direction, _ = self._axes(0.0)
        end = point + self._advance(balls, point, direction) * direction
        size = list(self.crate.inner)
        if not self._hand_clears(balls, end - LEAST_PUSH * direction, direction):
            raise ConfigurationError(
                f"support.bin_size = {size} is too short for the hand: between near and far wall it cannot push for "
                f"{1000 * LEAST_PUSH:.0f} mm; take a longer or lower bin, or a smaller hand"
            )
        x, y = self.crate.center
        raise ConfigurationError(
            f"the arm cannot push in the bin of support.bin_size = {size} whose middle is at ({x:.2f}, {y:.2f}) m: the "
            "far wall is out of reach, or the arm's links would come down on a wall; change support.bin_position, "
            "bin_size or bin_wall_heights"
        )


def _goal(name: str, anchor: Array, yaw: float, lines: Sequence[_Line]) -> PushGoal:
    """Return the goal with these lines; its push is as long as the shortest of them."""
    offsets = [line.offset for line in lines]
    return PushGoal(name, anchor, yaw, (min(offsets), max(offsets)), min(line.longest for line in lines))
