"""The bounds of all limits of a controller, gathered for one period."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arm.model import ArmModel
from ..arm.state import ArmState
from ..exceptions import ConfigurationError
from ..kernels.program import narrow, nearest_bound
from ..limits.limit import Bounds, Limit
from ..types import Array


class _Layout(NamedTuple):
    """What the bounds are, as long as each limit has as many rows as before.

    Attributes:
        sizes: Index of each limit with rows in G, and their number.
        soft: As in `LimitRows`.
        on_torque: As in `LimitRows`.
        all_on_torque: Whether every row of G is on the commanded torque.
        fixed: (nv + m,) `on_torque` as numbers, for kernels.
    """

    sizes: tuple[tuple[int, int], ...]
    soft: NDArray[np.bool_]
    on_torque: NDArray[np.bool_]
    all_on_torque: bool
    fixed: Array


class LimitRows(NamedTuple):
    """The bounds `lower <= [a; G a] <= upper` on the joint accelerations a, from the limits of a controller.

    The first nv bounds are the common part of the soft limits on the joint accelerations themselves. Where two of them
    contradict each other, as for a joint far outside its range, the first limit in the list wins. G holds the rows of
    all other limits.

    Attributes:
        G: (m, nv) Rows.
        lower: (nv + m,) Lower bounds.
        upper: (nv + m,) Upper bounds.
        layout: What each bound is.
        boxes: Bounds of the soft limits on the joint accelerations themselves, for their names.
        others: Bounds of all other limits, for their names.
    """

    G: Array
    lower: Array
    upper: Array
    layout: _Layout
    boxes: Sequence[Bounds]
    others: Sequence[Bounds]

    @property
    def soft(self) -> NDArray[np.bool_]:
        """(nv + m,) Whether a bound gives way where the hard ones leave no room."""
        return self.layout.soft

    @property
    def on_torque(self) -> NDArray[np.bool_]:
        """(nv + m,) Whether a bound is on the commanded torque, not on what the joints do."""
        return self.layout.on_torque

    def nearest(self) -> float:
        """Return the nearest bound on what the joints do [rad/s²]: a positive one demands, a negative one leaves room.

        A row of G counts by the joint acceleration that would reach its bound, spread over its entries.
        """
        n = self.G.shape[1]
        nearest = nearest_bound(self.lower[:n], self.upper[:n])
        if self.layout.all_on_torque:
            return nearest
        rows = ~self.on_torque[n:]
        size = np.abs(self.G[rows]).sum(axis=1)
        size[size == 0.0] = np.inf
        return max(nearest, nearest_bound(self.lower[n:][rows] / size, self.upper[n:][rows] / size))

    def names(self, lower: Iterable[int], upper: Iterable[int]) -> tuple[str, ...]:
        """Return the names of the lower bounds, then of the upper ones, with these indices."""
        n, found = self.G.shape[1], []
        rows = [name for bounds in self.others for name in bounds.names]
        lows, highs = [box.lower.tolist() for box in self.boxes], [box.upper.tolist() for box in self.boxes]
        for index in lower:
            nearest = 0
            for box in range(1, len(lows) if index < n else 1):
                nearest = box if lows[box][index] > lows[nearest][index] else nearest
            found.append(f"{self.boxes[nearest].names[index] if index < n else rows[index - n]} lower")
        for index in upper:
            nearest = 0
            for box in range(1, len(highs) if index < n else 1):
                nearest = box if highs[box][index] < highs[nearest][index] else nearest
            found.append(f"{self.boxes[nearest].names[index] if index < n else rows[index - n]} upper")
        return tuple(found)


class CheckedLimits:
    """The limits of a controller. It keeps the layout of their rows from period to period.

    Attributes:
        limits: Limits; where two contradict each other, the first one wins.
    """

    def __init__(self, limits: Sequence[Limit], nv: int) -> None:
        """Take the limits of an arm with `nv` joints."""
        self.limits = tuple(limits)
        self._nv = nv
        self._no_rows = np.zeros((0, nv))
        self._layout = self._lay_out(())

    def check(self, arm: ArmModel) -> None:
        """Ask the limits that can say it whether they can be kept by the arm with its payload.

        Raises:
            ConfigurationError: A limit cannot be kept.
        """
        for limit in self.limits:
            if hasattr(limit, "check"):
                limit.check(arm)

    def rows(self, state: ArmState) -> LimitRows:
        """Return the bounds at a state.

        Raises:
            ConfigurationError: The rows of a limit have a wrong shape.
        """
        n = self._nv
        boxes: list[Bounds] = []
        others: list[Bounds] = []
        sizes: list[tuple[int, int]] = []
        for index, limit in enumerate(self.limits):
            bounds = checked(limit.rows(state), limit, n)
            if _is_box(limit, bounds):
                boxes.append(bounds)
            else:
                others.append(bounds)
                sizes.append((index, len(bounds.names)))
        layout = self._layout if tuple(sizes) == self._layout.sizes else self._lay_out(tuple(sizes))
        G: Array | None = others[0].G if len(others) == 1 else None
        if G is None or not G.flags.c_contiguous:
            G = np.concatenate([self._no_rows, *(np.eye(n) if rows.G is None else rows.G for rows in others)])
        lower, upper = np.empty(n + len(G)), np.empty(n + len(G))
        below, above = lower[:n], upper[:n]
        below.fill(-np.inf)
        above.fill(np.inf)
        for bounds in boxes:
            narrow(bounds.lower, bounds.upper, below, above)
        first = n
        for bounds, (_, size) in zip(others, sizes, strict=True):
            lower[first : first + size], upper[first : first + size] = bounds.lower, bounds.upper
            first += size
        return LimitRows(G, lower, upper, layout, boxes, others)

    def of(self, G: Array, lower: Array, upper: Array, boxes: Sequence[tuple[Array, Array]]) -> LimitRows:
        """Return bounds that a kernel has filled: those on the accelerations, then those of `TorqueLimit`.

        `boxes` are the lower and upper bounds of the other limits, which come after the torque limit.
        """
        sizes = ((0, self._nv),)
        layout = self._layout if sizes == self._layout.sizes else self._lay_out(sizes)
        torque, *others = (limit.row_names for limit in self.limits)  # type: ignore[attr-defined]
        named = [Bounds(None, *box, names) for box, names in zip(boxes, others, strict=True)]
        return LimitRows(G, lower, upper, layout, named, (Bounds(G, lower, upper, torque),))

    def _lay_out(self, sizes: tuple[tuple[int, int], ...]) -> _Layout:
        soft, on_torque = [True] * self._nv, [False] * self._nv
        for index, size in sizes:
            limit = self.limits[index]
            soft += [not limit.hard] * size
            on_torque += [bool(getattr(limit, "on_torque", False))] * size
        fixed = np.array(on_torque, dtype=float)
        self._layout = _Layout(sizes, np.array(soft), np.array(on_torque), all(on_torque[self._nv :]), fixed)
        return self._layout


def _is_box(limit: Limit, bounds: Bounds) -> bool:
    """Return whether the bounds are on the joint accelerations themselves, and may give way."""
    return bounds.G is None and not limit.hard and not getattr(limit, "on_torque", False)


def checked(bounds: Bounds, limit: Limit, n: int) -> Bounds:
    """Return the bounds of a limit as arrays of floats.

    Raises:
        ConfigurationError: A shape is wrong.
    """
    try:
        G, lower, upper, names = bounds
        lower, upper = np.asarray(lower, dtype=np.float64), np.asarray(upper, dtype=np.float64)
        m = len(names)
        good = lower.shape == upper.shape == (m,)
        if G is None:
            good = good and m == n
        else:
            G = np.asarray(G, dtype=np.float64)
            good = good and G.shape == (m, n)
    except (TypeError, ValueError):
        good = False
    if not good:
        raise ConfigurationError(
            f"{type(limit).__name__}.rows must return Bounds(G (m, {n}), lower (m,), upper (m,), names (m,)); G may be "
            f"None for the identity, with m = {n}"
        )
    return Bounds(G, lower, upper, names)
