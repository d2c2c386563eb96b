"""CG against Newton by size, on this project's own scenes: whole attempts, and a pile that settles in its frame."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from contact_solver import ContactSolver
from metered_stepper import MeteredStepper
from pilegrasp_ctrl.config import Scenario
from pilegrasp_ctrl.episode import run_attempt
from pilegrasp_ctrl.exceptions import PilegraspError
from pilegrasp_ctrl.planning.layout import make_layout
from pilegrasp_ctrl.programs.attempt import prepare
from pilegrasp_ctrl.sim.drop import drop_poses, pile_model
from pilegrasp_ctrl.sim.objects import objects_of
from pilegrasp_ctrl.statistics import markdown_row
from step_samples import StepSamples

SOLVERS = (ContactSolver(), ContactSolver("Newton"), ContactSolver("Newton", 100))
FALL = (0.5, 1.0)
"""When the objects have come down and settle in the frame, jammed where it is filled in layers [s]."""
WRONG = 1.0
"""A step that leaves a joint of the hand farther than this from the exact solution is wrong [rad/s]. CG was never off
by more than 0.52 in 42 attempts; the worst step of Newton in each pile that had one, by 5.9 to 77."""
HEADER = (
    *("pile", "solver", "held", "contacts", "step [us]", "to CG", "iterations", "p99", "at the limit", "wrong"),
    *("finger [rad/s]", "object [mm/s]"),
)


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """A run with one solver.

    Attributes:
        push: its steps while the hand pushes, or while the objects settle in the frame; they say what a step costs.
        handled: its steps from the start of the push to the end; they say what went wrong.
        held: whether an object was held, or None where nothing was grasped for.
    """

    push: StepSamples
    handled: StepSamples
    held: bool | None


def attempt(scenario: Scenario, seed: int, solver: ContactSolver) -> Measured:
    """Carry out one attempt; the pile has settled with the shipped solver, so that all solvers get the same one.

    Raises:
        PilegraspError: where the attempt cannot be prepared, or the approach fails.
    """
    prepared = prepare(scenario, seed)
    simulation = prepared.simulation
    scene = simulation.scene
    stepper = MeteredStepper(scene.model, simulation.data, solver, scene.arm_dofs, len(scene.objects))
    simulation.stepper = stepper
    result = run_attempt(prepared)
    push = next((outcome for outcome in result.outcomes if outcome.name == "push"), None)
    if push is None:
        raise PilegraspError(f"seed {seed} of {scenario.name} never came to push: {result.reason}")
    samples = stepper.samples()
    return Measured(samples.after(push.start, push.end), samples.after(push.start), result.success)


def fall(scenario: Scenario, seed: int, solver: ContactSolver) -> Measured:
    """Drop the scenario's objects into their frame, as every pile begins, and measure while they settle there."""
    kind = objects_of(scenario.pile)
    count, numerics = scenario.pile.count, scenario.sim
    layout = make_layout(scenario.support, scenario.pile, kind.diameter)
    model = pile_model(kind, count, layout, numerics.contact_rule, numerics.timestep)
    data = mujoco.MjData(model)
    data.qpos[:] = drop_poses(kind, count, layout, np.random.default_rng(seed)).ravel()
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


def wrong(samples: StepSamples) -> int:
    """Return how many steps were farther than `WRONG` from the exact solution."""
    return int(np.count_nonzero(samples.finger_error > WRONG))


def _row(label: str, solver: ContactSolver, runs: list[Measured], base: float) -> str:
    push = StepSamples.joined([run.push for run in runs])
    handled = StepSamples.joined([run.handled for run in runs])
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
        f"{wrong(handled)} of {handled.time.size}",
        f"{handled.finger_error.max():.2f}",
        f"{1e3 * handled.object_error.max():.1f}",
    ]
    return markdown_row(cells)
