"""Compare MuJoCo's contact solvers CG and Newton by the size of the pile, in whole attempts and in settling piles.

Usage: python docs/studies/compare_contact_solvers.py [SEEDS]

docs/contact-solvers.csv holds the rows of both tables; docs/numerics.md shows some of them.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields
from functools import partial
from typing import Any, Literal

import mujoco
import numpy as np

from pilegrasp_ctrl.config import Scenario, load_scenario
from pilegrasp_ctrl.episode import run_attempt
from pilegrasp_ctrl.exceptions import PilegraspError
from pilegrasp_ctrl.planning.layout import make_layout
from pilegrasp_ctrl.programs.attempt import prepare
from pilegrasp_ctrl.sim.drop import drop_poses, pile_model
from pilegrasp_ctrl.sim.objects import objects_of
from pilegrasp_ctrl.sim.scene import SOLVER_ITERATIONS
from pilegrasp_ctrl.sim.stepper import Stepper
from pilegrasp_ctrl.statistics import markdown_row, markdown_table
from pilegrasp_ctrl.types import Array
from script import run_script


@dataclass(frozen=True, slots=True)
class ContactSolver:
    """A contact solver for a compiled model.

    Attributes:
        kind: Name in MuJoCo.
        iterations: Largest number of iterations.
        tolerance: Tolerance at which the solver stops, MuJoCo's `opt.tolerance` [-].
    """

    kind: Literal["CG", "Newton"] = "CG"
    iterations: int = SOLVER_ITERATIONS
    tolerance: float = 1e-8

    @property
    def label(self) -> str:
        """Name in a table."""
        return f"{self.kind}, {self.iterations}"

    def put_into(self, model: Any) -> None:
        """Set the solver of a model, from its next step on."""
        kind = mujoco.mjtSolver.mjSOL_CG if self.kind == "CG" else mujoco.mjtSolver.mjSOL_NEWTON
        model.opt.solver, model.opt.iterations, model.opt.tolerance = kind, self.iterations, self.tolerance


EXACT = ContactSolver("CG", 1000, 1e-14)
"""Reference for the errors of the others: CG does not stall, and improves no more after about 100 iterations."""


@dataclass(frozen=True, slots=True, eq=False)
class StepSamples:
    """One value for each of n steps.

    Attributes:
        time: (n,) Simulated time at the end of the step [s].
        seconds: (n,) Wall-clock time of the step [s].
        contacts: (n,) Number of contacts.
        iterations: (n,) Largest number of solver iterations among the first 20 islands; MuJoCo counts no others.
        finger_error: (n,) Largest error of a joint speed of the hand against the exact solution [rad/s].
        object_error: (n,) Largest error of an object's velocity [m/s].
    """

    time: Array
    seconds: Array
    contacts: Array
    iterations: Array
    finger_error: Array
    object_error: Array

    def after(self, begin: float, end: float = np.inf) -> StepSamples:
        """Return the steps that began at `begin` or later and ended by `end` [s]."""
        wanted = (self.time > begin + 1e-9) & (self.time <= end + 1e-9)
        return StepSamples(*(getattr(self, field.name)[wanted] for field in fields(self)))

    @classmethod
    def joined(cls, parts: list[StepSamples]) -> StepSamples:
        """Return the steps of several runs as one."""
        return cls(*(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(cls)))


FREE_DOFS = 6
"""Degrees of freedom of a free object [-]."""


class MeteredStepper(Stepper):
    """Steps as `Stepper` does, with a chosen solver; the exact step is not timed and changes nothing.

    Args:
        model: Model, whose solver is set.
        data: State of the model.
        solver: Solver that is measured.
        arm_dofs: Number of leading joints that belong neither to the hand nor to an object.
        objects: Number of objects; their free joints come last.
    """

    def __init__(
        self, model: mujoco.MjModel, data: mujoco.MjData, solver: ContactSolver, arm_dofs: int, objects: int
    ) -> None:
        super().__init__(model, data)
        self._solver = solver
        self._first_object = model.nv - FREE_DOFS * objects
        self._hand = slice(arm_dofs, self._first_object)
        self._exact = mujoco.MjData(model)
        self._rows: list[tuple[float, ...]] = []
        solver.put_into(model)

    def step(self) -> None:
        """Advance by one step."""
        data, depth = self.data, self.depth
        mujoco.mj_copyData(self._exact, self.model, data)
        start = time.perf_counter()
        super().step()
        seconds = time.perf_counter() - start
        iterations = data.solver_niter[: data.nisland].max(initial=0)
        self._rows.append((data.time, seconds, data.ncon, iterations, *self._errors(depth)))

    def samples(self) -> StepSamples:
        """Return the steps so far."""
        return StepSamples(*np.array(self._rows).T)

    def _errors(self, depth: float) -> tuple[float, float]:
        """Return the largest errors of a joint of the hand [rad/s] and of an object [m/s]."""
        own, own_depth = self.data, self.depth
        self.data, self.depth = self._exact, depth
        EXACT.put_into(self.model)
        super().step()
        self._solver.put_into(self.model)
        self.data, self.depth = own, own_depth
        error = own.qvel - self._exact.qvel
        objects = error[self._first_object :].reshape(-1, FREE_DOFS)[:, :3]
        finger = np.abs(error[self._hand]).max(initial=0.0)
        return float(finger), float(np.linalg.norm(objects, axis=1).max(initial=0.0))


SOLVERS = (ContactSolver(), ContactSolver("Newton"), ContactSolver("Newton", 100))
"""Solvers that are compared."""

FALL = (0.5, 1.0)
"""Time range in which dropped objects settle in the frame [s]; chosen. Objects in layers jam."""

WRONG = 1.0
"""Error of a joint of the hand beyond which a step counts as wrong [rad/s]; chosen. CG was never off by more than 0.52
in 42 attempts; the worst step of Newton in each pile that had one was off by 5.9 to 77."""

HEADER = (
    *("pile", "solver", "held", "contacts", "step [us]", "to CG", "iterations", "p99", "at the limit", "wrong"),
    *("finger [rad/s]", "object [mm/s]"),
)
"""Columns of both tables."""


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """A run with one solver.

    Attributes:
        push: Steps while the hand pushes, or while the objects settle in the frame; they show the cost of a step.
        handled: Steps from the start of the push to the end; they show the errors.
        held: Whether an object was held; None without a grasp.
    """

    push: StepSamples
    handled: StepSamples
    held: bool | None


def attempt(scenario: Scenario, seed: int, solver: ContactSolver) -> Measured:
    """Run one attempt; the pile settles with the shipped solver, so that all solvers get the same pile.

    Raises:
        PilegraspError: The attempt cannot be prepared, or its approach fails.
    """
    prepared = prepare(scenario, seed)
    simulation = prepared.simulation
    scene = simulation.scene
    stepper = MeteredStepper(scene.model, simulation.data, solver, scene.arm_dofs, len(scene.objects))
    simulation.stepper = stepper
    result = run_attempt(prepared)
    push = next((outcome for outcome in result.outcomes if outcome.name == "push"), None)
    if push is None:
        raise PilegraspError(f"seed {seed} of {scenario.name} has no push: {result.reason}")
    samples = stepper.samples()
    return Measured(samples.after(push.start, push.end), samples.after(push.start), result.success)


def fall(scenario: Scenario, seed: int, solver: ContactSolver) -> Measured:
    """Drop the scenario's objects into their frame and measure while they settle there."""
    dropped = objects_of(scenario.pile)
    count, numerics = scenario.pile.count, scenario.sim
    layout = make_layout(scenario.support, scenario.pile, dropped.diameter)
    model = pile_model(dropped, count, layout, numerics.contact_rule, numerics.timestep)
    data = mujoco.MjData(model)
    data.qpos[:] = drop_poses(dropped, count, layout, np.random.default_rng(seed)).ravel()
    stepper = MeteredStepper(model, data, solver, 0, count)
    for _ in range(round(FALL[1] / numerics.timestep)):
        stepper.step()
    samples = stepper.samples().after(*FALL)
    return Measured(samples, samples, None)


def rows(
    label: str,
    run: Callable[[int, ContactSolver], Measured],
    seeds: Sequence[int],
    solvers: Iterable[ContactSolver] = SOLVERS,
) -> list[str]:
    """Run every seed with each solver in turn, and return a line of the table for each solver."""
    runs: dict[ContactSolver, list[Measured]] = {solver: [] for solver in solvers}
    for seed in seeds:
        for solver, done in runs.items():
            done.append(run(seed, solver))
    base = _cost(next(iter(runs.values())))
    return [_row(label, solver, done, base) for solver, done in runs.items()]


def _cost(runs: list[Measured]) -> float:
    """Return the median cost of a step [s]."""
    return float(np.median(StepSamples.joined([run.push for run in runs]).seconds))


def _row(label: str, solver: ContactSolver, runs: list[Measured], base: float) -> str:
    push = StepSamples.joined([run.push for run in runs])
    handled = StepSamples.joined([run.handled for run in runs])
    wrong = int(np.count_nonzero(handled.finger_error > WRONG))
    held = "" if runs[0].held is None else f"{sum(bool(run.held) for run in runs)} of {len(runs)}"
    cells = [
        label,
        solver.label,
        held,
        f"{np.median(push.contacts):.0f}",
        f"{1e6 * _cost(runs):.0f}",
        f"{_cost(runs) / base:.2f}",
        f"{np.median(push.iterations):.0f}",
        f"{np.percentile(push.iterations, 99):.0f}",
        f"{np.mean(push.iterations >= solver.iterations):.1%}",
        f"{wrong} of {handled.time.size}",
        f"{handled.finger_error.max():.2f}",
        f"{1e3 * handled.object_error.max():.1f}",
    ]
    return markdown_row(cells)


PILES = (
    *(("spheres_wall", count) for count in (5, 18, 30, 60, 90)),
    ("cylinders_wall", 14),
    ("cubes_wall", 14),
)
"""Scenario and count of each pile."""


def main(seeds: int = 3) -> None:
    """Print both tables: of attempts, and of the same objects settling in their frame."""
    for run, solvers in ((attempt, SOLVERS), (fall, SOLVERS[:2])):
        print(markdown_table(HEADER))
        for name, count in PILES:
            scenario = load_scenario(name, {"pile.count": count})
            label = f"{count} {name.partition('_')[0]}"
            print("\n".join(rows(label, partial(run, scenario), range(seeds), solvers)), flush=True)
        print()


if __name__ == "__main__":
    run_script(main)
