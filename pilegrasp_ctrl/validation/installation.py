"""Checks of an installation: the packages, the solvers, the agreement of the two engines, one short attempt."""

from __future__ import annotations

import platform
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

from ..exceptions import ModelError, PilegraspError
from ..provenance import ABSENT, VERSION, dependencies, version_of

SOLVERS = ("daqp", "osqp")
"""Solvers that every installation has; they solve a test problem."""

AGREEMENT = 1e-9
"""Largest relative difference between the engines [-]; chosen. The rounding of both together is below 1e-13."""

ACCURACY = 1e-9
"""Largest error of a solver's answer to the test problem [-]; chosen, far above rounding."""


@dataclass(frozen=True, slots=True)
class Check:
    """One line of the report.

    Attributes:
        name: Name of the checked part.
        ok: Whether the check passed.
        detail: Version, measurement or reason of the failure.
        required: Whether the library needs the checked part.
    """

    name: str
    ok: bool
    detail: str
    required: bool = True

    def as_dict(self) -> dict[str, Any]:
        """Return the fields as plain JSON values."""
        return asdict(self)


def examine() -> list[Check]:
    """Run every check; a check that raises has failed, and the others still run."""
    return [
        Check("pilegrasp", True, f"{VERSION} on Python {platform.python_version()}, {platform.platform()}"),
        *(_check(name, partial(_version, name)) for name in dependencies()),
        *(_check(f"solver {name}", partial(_solver, name)) for name in SOLVERS),
        _check("engines agree", _engines),
        _browser(),
        _check("short run", _short_run),
    ]


def _check(name: str, measure: Callable[[], str]) -> Check:
    try:
        return Check(name, True, measure())
    except Exception as error:
        return Check(
            name, False, str(error) if isinstance(error, PilegraspError) else f"{type(error).__name__}: {error}"
        )


def _version(name: str) -> str:
    if (found := version_of(name)) == ABSENT:
        raise PilegraspError(f"is not installed; pip install {name}")
    return found


def _solver(name: str) -> str:
    """Minimise (x - 2)² subject to x <= 1 and compare with the answer, 1."""
    import numpy as np

    from ..qp.program import QuadraticProgram, make_solver

    one = np.ones((1, 1))
    program = QuadraticProgram(2.0 * one, np.array([-4.0]), one, np.full(2, -np.inf), np.ones(2))
    x = make_solver(name).solve(program)
    if x is None or abs(x[0] - 1.0) > ACCURACY:
        raise PilegraspError(f"the answer is {x} and must be 1; install the solver again")
    return "solves a test problem"


def _engines() -> str:
    """Compare inertia, bias force and flange position of the WAM at random states in Pinocchio and in MuJoCo."""
    import mujoco
    import numpy as np
    import pinocchio as pin

    from ..robots import path

    model = pin.buildModelFromUrdf(str(path("wam7", "wam7.urdf")))
    twin = mujoco.MjModel.from_xml_path(str(path("wam7", "wam7.xml")))
    data, twin_data = model.createData(), mujoco.MjData(twin)
    inertia = np.zeros((twin.nv, twin.nv))
    rng = np.random.default_rng(0)
    worst = 0.0
    for _ in range(10):
        twin_data.qpos[:] = q = rng.uniform(model.lowerPositionLimit, model.upperPositionLimit)
        twin_data.qvel[:] = v = rng.uniform(-1.0, 1.0, model.nv)
        pin.computeAllTerms(model, data, q, v)
        pin.updateFramePlacements(model, data)
        mujoco.mj_forward(twin, twin_data)
        mujoco.mj_fullM(twin, twin_data, inertia)
        pairs = (
            (data.M - np.diag(model.armature), inertia - np.diag(twin.dof_armature)),
            (data.nle, twin_data.qfrc_bias),
            (data.oMf[model.getFrameId("flange")].translation, twin_data.site("flange").xpos),
        )
        worst = max(worst, *(float(np.abs(a - b).max() / np.abs(a).max()) for a, b in pairs))
    if not worst < AGREEMENT:
        raise ModelError(f"Pinocchio and MuJoCo differ by {worst:.1e} on the WAM; {AGREEMENT:.0e} is allowed")
    return f"Pinocchio and MuJoCo differ by at most {worst:.0e} on the WAM"


def _browser() -> Check:
    from ..viewer.pictures.chromium import find_chromium

    found = find_chromium()
    detail = found or "no Chromium; pictures and the tests of the pages need it, pages open in any browser"
    return Check("browser", found is not None, detail, required=False)


def _short_run() -> str:
    from ..episode import run

    result = run("free_space_line", overrides={"line.displacement": [0.0, 0.03, 0.0]}).as_dict()
    if not result["success"]:
        raise PilegraspError(f"free_space_line did not succeed: {result['reason']}")
    return f"{result['sim_time']:.1f} s simulated at {result['realtime_factor']:.1f}x real time"
