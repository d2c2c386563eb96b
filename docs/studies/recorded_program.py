"""Recorded quadratic programs of control periods, with their exact optima."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.qp.program import QuadraticProgram
from pilegrasp_ctrl.types import Array

JOINTS = 7
"""Number of joints of both recorded arms."""

_UPPER = np.triu_indices(JOINTS)
_LAYOUT = np.dtype(
    [
        ("arm", "S8"),
        ("kind", "S12"),
        ("feasible", "?"),
        # The upper triangle, row by row.
        ("H", "<f8", (len(_UPPER[0]),)),
        ("f", "<f8", (JOINTS,)),
        ("G", "<f8", (JOINTS, JOINTS)),
        ("lower", "<f8", (2 * JOINTS,)),
        ("upper", "<f8", (2 * JOINTS,)),
        ("x", "<f8", (JOINTS,)),
        ("excess", "<f8", (JOINTS,)),
        ("multipliers", "<f8", (2 * JOINTS,)),
        ("certificate", "<f8", (JOINTS,)),
    ]
)


class RecordedProgram(NamedTuple):
    """A program of an arm with seven joints, and its proven answer.

    Attributes:
        arm: Name of the arm.
        kind: State of the loop, such as "nominal" or "infeasible".
        feasible: Whether some x is within all bounds.
        problem: Program.
        x: (n,) Optimum of the program or, if it is infeasible, of `problem.softened()` [rad/s²].
        excess: (n,) Excess of x over its bounds [rad/s²]; zero for a feasible program.
        multipliers: (2 n,) Multipliers m_x of the bounds on x, then m_G of those on G x, with `H x + f = m_x + Gᵀ m_G`.
            They are positive for an active lower bound, and negative for an active upper bound.
        certificate: (n,) Vector y that proves a program infeasible: `yᵀ z` for every z within the bounds on G x is
            larger than `yᵀ G x` for every x within the bounds on x. Zero for a feasible program.
    """

    arm: str
    kind: str
    feasible: bool
    problem: QuadraticProgram
    x: Array
    excess: Array
    multipliers: Array
    certificate: Array


def load_programs(path: Path) -> tuple[RecordedProgram, ...]:
    """Read a file that `save_programs` wrote.

    Raises:
        ConfigurationError: The file cannot be read or holds something else.
    """
    try:
        rows = np.load(path, allow_pickle=False)
    except OSError as error:
        raise ConfigurationError(
            f"{path}: cannot be read: {error.strerror}; recorded programs come with the source, not with the package"
        ) from None
    except ValueError:
        rows = None
    if not isinstance(rows, np.ndarray) or rows.dtype != _LAYOUT:
        raise ConfigurationError(
            f"{path}: holds no recorded programs; `python tests/helpers/qp_programs.py record` writes them"
        )
    return tuple(_program(row) for row in rows)


def save_programs(path: Path, programs: Iterable[RecordedProgram]) -> None:
    """Write programs to one `.npy` file of records, without rounding."""
    np.save(path, np.array([_row(program) for program in programs], dtype=_LAYOUT), allow_pickle=False)


def _row(program: RecordedProgram) -> tuple[object, ...]:
    H, *others = program.problem
    head = (program.arm.encode(), program.kind.encode(), program.feasible)
    return (*head, H[_UPPER], *others, program.x, program.excess, program.multipliers, program.certificate)


def _program(row: np.void) -> RecordedProgram:
    H = np.zeros((JOINTS, JOINTS))
    H[_UPPER] = row["H"]
    H.T[_UPPER] = row["H"]
    f, G, lower, upper, *known = (row[name].copy() for name in _LAYOUT.names[4:])  # type: ignore[index]
    problem = QuadraticProgram(H, f, G, lower, upper)
    return RecordedProgram(row["arm"].decode(), row["kind"].decode(), bool(row["feasible"]), problem, *known)
