"""What a solver is, and the solvers by name."""

from __future__ import annotations

import inspect
from typing import TYPE_CHECKING, Protocol

from ..exceptions import ConfigurationError
from ..provenance import SOLVER_PACKAGES
from ..types import Array

if TYPE_CHECKING:
    from .program import QuadraticProgram

_LONGEST_TEXT = 200
"""Number of characters of a package's error text that are repeated [-]; chosen."""


class Solver(Protocol):
    """A solver that proposes a solution; `pilegrasp_ctrl.qp.program.solve` checks it.

    Two attributes are optional. Error messages show `name` instead of the class's name. `reads_only = True` says that
    the solver neither overwrites the program's arrays nor keeps the array that it returns. It then gets the
    controller's own arrays instead of copies.
    """

    def solve(self, program: QuadraticProgram) -> Array | None:
        """Return x (n,), or None if the solver found none."""


def solver_name(solver: Solver) -> str:
    """Return the solver's `name`, or the name of its class."""
    name = getattr(solver, "name", None)
    return name if isinstance(name, str) else type(solver).__name__


def described(error: Exception) -> str:
    """Return the type of a package's error and the first line of its text."""
    text = next(iter(str(error).splitlines()), "")
    return f"{type(error).__name__}: {text[:_LONGEST_TEXT]}" if text else type(error).__name__


def make_solver(solver: str | Solver) -> Solver:
    """Return the solver of a name, or the given solver.

    Args:
        solver: "daqp", "osqp", another name of `qpsolvers.available_solvers`, or an object with `solve(program)`.

    Raises:
        ConfigurationError: The name is unknown, the solver's package is not installed, or the object is not a solver.
    """
    if not isinstance(solver, str):
        return _checked(solver)
    # Each package takes 0.1 to 0.5 s to load.
    if solver == "daqp":
        from .daqp_solver import DaqpSolver

        return DaqpSolver()
    if solver == "osqp":
        from .osqp_solver import OsqpSolver

        return OsqpSolver()
    from .qpsolvers_solver import QpsolversSolver

    return QpsolversSolver(solver)


def refused_name(name: str, available: list[str]) -> ConfigurationError:
    """Return the error for a name that is not in `available`: its package is absent, or nobody knows the name."""
    if name not in SOLVER_PACKAGES:
        return ConfigurationError(f"no solver {name!r:.80}; the solvers installed here are {', '.join(available)}")
    packages, extra = SOLVER_PACKAGES[name]
    remedy = f"pip install 'qpsolvers[{extra}]'" if extra else "see https://github.com/qpsolvers/qpsolvers#solvers"
    return ConfigurationError(
        f"the solver {name!r} needs the package {' and '.join(packages)}: {remedy}; "
        f"the solvers installed here are {', '.join(available)}"
    )


def _checked(solver: Solver) -> Solver:
    """Return the object if it has a method `solve` that takes a program."""
    method, expected = getattr(solver, "solve", None), "give a name such as 'daqp' or an object with solve(program)"
    if not callable(method):
        raise ConfigurationError(f"solver = {solver!r:.80} is not a solver; {expected}")
    try:
        inspect.signature(method).bind(None)
    except TypeError:
        hint = f"; {solver.__name__} is a class: give an instance of it" if isinstance(solver, type) else ""
        raise ConfigurationError(f"solver = {solver!r:.80}: its solve must take one program{hint}") from None
    except ValueError:  # compiled code need not tell its arguments
        pass
    return solver
