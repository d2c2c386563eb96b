"""The quadratic program of one period, with what is needed to turn its solution into torques."""

from __future__ import annotations

from typing import NamedTuple

from ..arm.state import ArmState
from ..qp.program import QuadraticProgram
from ..types import Array
from .limit_rows import LimitRows


class Assembly(NamedTuple):
    """The program of one period.

    Attributes:
        time: Time of the observation [s].
        state: State whose `h` holds the feed-forward torques too.
        bias: (nv,) The state's `h` without them [N·m].
        program: Cost and bounds.
        limits: Bounds of the limits, with their names.
        friction: (nv,) Torque against the expected friction [N·m]; None without one.
        optimum: (nv,) Accelerations without limits [rad/s²].
    """

    time: float
    state: ArmState
    bias: Array
    program: QuadraticProgram
    limits: LimitRows
    friction: Array | None
    optimum: Array
