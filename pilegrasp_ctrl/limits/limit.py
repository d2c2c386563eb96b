"""What a limit is: bounds on linear functions of the joint accelerations, for one control period."""

from __future__ import annotations

from typing import NamedTuple, Protocol, runtime_checkable

from ..arm.state import ArmState
from ..types import Array


class Bounds(NamedTuple):
    """The bounds `lower <= G a <= upper` on the joint accelerations a [rad/s²] of one control period.

    Attributes:
        G: (m, nv) Rows; None for the identity, that is, for bounds on the joint accelerations themselves.
        lower: (m,) Lower bounds; -inf where there is none.
        upper: (m,) Upper bounds; inf where there is none.
        names: (m,) Names of the rows in `active_limits`, such as "torque[2]"; the side is added to them. Rows may share
            one.
    """

    G: Array | None
    lower: Array
    upper: Array
    names: tuple[str, ...]


@runtime_checkable
class Limit(Protocol):
    """A limit of the arm's motion or torque. Any object with these two members may stand in a controller's list.

    A limit may have four more attributes. `rate` is the control rate it was made for [Hz]; a controller of another rate
    refuses it. `on_torque` is True if its rows bound the commanded torque rather than the motion. Joint friction and
    contact then do not change them. `cut(torque, state)` returns the torque (nv,) within the limit that is nearest to
    `torque` (nv,) [N·m], for periods without a solution. `check(arm)` is called when the arm gets another payload, and
    raises `ConfigurationError` where the limit cannot be kept with it.

    Attributes:
        hard: Whether the limit holds always. A soft one gives way where the hard ones leave no room.
    """

    hard: bool

    def rows(self, state: ArmState) -> Bounds:
        """Return the bounds at a state, whose `h` holds the feed-forward torques too: torque = M a + h."""
