"""One trial of a search over gains: its attempts, its measurements, and whether the loop rings."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from time import perf_counter
from typing import NoReturn

from ..arm.model import ArmModel
from ..config import Scenario
from ..episode import run
from ..exceptions import PilegraspError, SimulationError, environment_fault
from ..programs.attempt import prepare
from ..study.dispatch import InlinePool, Pool, dispatch
from ..study.worker_pool import WorkerPool
from ..tasks.gains import load_gains
from ..types import Array
from .objectives import Measured, combined, measure
from .stability_margin import stiffness_probe

REQUIRED_MARGIN = 2.0
"""Factor by which the stiffness can grow before the loop rings; 2 to 5 is usual for a gain margin (K. J.
Åström and R. M. Murray, Feedback Systems, 2nd ed., 2021, section 10.3)."""


@dataclass(frozen=True, slots=True)
class TrialWork:
    """One trial, as a worker gets it.

    Attributes:
        number: Number of the trial.
        scenario: Scenario with its controller and its file of gains.
        seeds: Seeds of the attempts.
        late: Control periods by which the torque is late when the ringing is measured.
    """

    number: int
    scenario: Scenario
    seeds: tuple[int, ...]
    late: int = 0


@dataclass(frozen=True, slots=True)
class TrialReport:
    """The result of one trial, as a worker reports it.

    Attributes:
        number: Number of the trial.
        measured: Measurements over all seeds; None if an attempt was not completed.
        ringing: Ringing at factor 1 and at `REQUIRED_MARGIN` on the stiffness, 1 and more rings; () if not measured.
        success: Share of the attempts with success, such as an object held.
        reason: Reason why nothing was measured, or "".
        wall_time: Time of the trial on the wall clock [s].
    """

    number: int
    measured: Measured | None
    ringing: tuple[float, ...]
    success: float
    reason: str
    wall_time: float

    @property
    def feasible(self) -> bool:
        """Whether all attempts were completed and the loop keeps its margin."""
        return self.measured is not None and bool(self.ringing) and max(self.ringing) < 1.0


@lru_cache(maxsize=4)
def resting_arm(scenario: Scenario, seed: int) -> tuple[ArmModel, Array]:
    """Return the scenario's arm with the mass of its hand, and the posture in which its attempt begins (nv,) [rad].

    Raises:
        PilegraspError: The scenario cannot be prepared.
    """
    attempt = prepare(scenario, seed)
    return attempt.arm, attempt.posture


def run_trial(work: TrialWork) -> TrialReport:
    """Run a trial; an error in it becomes the reason in its report.

    Raises:
        SimulationError: The environment has refused something, such as space on a disk. That is no result.
    """
    start = perf_counter()
    scenario = work.scenario
    measured: Measured | None = None
    ringing: tuple[float, ...] = ()
    success, reason = 0, ""
    try:
        parts = []
        for seed in work.seeds:
            result = run(scenario, seed=seed, record=True)
            parts.append(measure(result, scenario))
            success += result.success
        ringing = _ringing(work)
        measured = combined(parts)
    except (PilegraspError, OSError, ImportError) as error:
        if fault := environment_fault(error):
            raise SimulationError(
                f"trial {work.number} could not run: {fault}; that is no result, so the search stops; finished trials "
                "are kept, and the same command runs the rest"
            ) from error
        if isinstance(error, SimulationError):
            error.forget_states()
        reason = error.reason if isinstance(error, SimulationError) else " ".join(str(error).split())
    return TrialReport(work.number, measured, ringing, success / len(work.seeds), reason, perf_counter() - start)


def trial_pool(jobs: int) -> AbstractContextManager[Pool]:
    """Return this process as a pool for one job, and worker processes for more."""
    return InlinePool() if jobs == 1 else WorkerPool(jobs)


def run_trials(
    pool: Pool, work_items: Sequence[TrialWork], function: Callable[[TrialWork], TrialReport] = run_trial
) -> Iterator[TrialReport]:
    """Yield a report of every trial as it finishes; a trial whose worker died is repeated.

    Args:
        pool: Pool of `trial_pool`.
        work_items: Trials, in the order in which they are begun.
        function: Function that runs a trial.

    Raises:
        SimulationError: The worker processes of one trial died again and again.
    """
    for batch in dispatch(pool, function, work_items, _raise_worker_died):
        for _, report in batch:
            yield report


def _raise_worker_died(work: TrialWork, deaths: int) -> NoReturn:
    raise SimulationError(
        f"{deaths} worker processes died with trial {work.number}, perhaps because memory was too small; finished "
        "trials are kept; run the same command again with fewer --jobs"
    )


def _ringing(work: TrialWork) -> tuple[float, ...]:
    controller = work.scenario.controller
    # The posture does not depend on the gains; with them, the cache would miss at every trial.
    without_gains = controller.model_copy(update={"gains": None})
    arm, q = resting_arm(work.scenario.model_copy(update={"controller": without_gains}), work.seeds[0])
    gains = load_gains(Path(str(controller.gains)))
    probe = stiffness_probe(arm, gains, q, rate=controller.rate, solver=controller.solver, late=work.late)
    return probe(1.0), probe(REQUIRED_MARGIN)
