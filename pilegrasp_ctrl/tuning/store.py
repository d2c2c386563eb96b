"""The store of a search: one SQLite file with its definition, the trials and their reports."""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import optuna
from optuna.distributions import FloatDistribution
from optuna.trial import FrozenTrial, TrialState

from ..exceptions import ConfigurationError, ExportError
from ..study.origins import difference
from .objectives import Measured
from .trial import TrialReport

SAMPLER_SEED = 20200312
"""Seed of the sampler for trial 0; trial n has this plus n (chosen)."""
BATCH = 4
"""Number of trials that are proposed together, before any of them runs (chosen). The proposals therefore depend neither
on the number of workers nor on their speed."""
SPREAD = 12
"""Number of trials that cover the space evenly before the sampler proposes, including the start (chosen)."""
FAILED = 100.0
"""Violation of the constraint that the sampler gets for a trial that was not completed (chosen)."""

_SEARCH, _NOTES = "search", "sensitivity"


@dataclass(frozen=True, slots=True)
class TrialRecord:
    """A finished trial.

    Attributes:
        number: Number of the trial; 0 is the start.
        values: Numbers that were proposed, unrounded.
        report: Report of the worker.
    """

    number: int
    values: Mapping[str, float]
    report: TrialReport


class TuningStore:
    """The store of a search over gains, which survives the process.

    Every trial is proposed from its own seed and from the trials of earlier batches. A search that was killed therefore
    goes on with the same proposals.
    """

    def __init__(
        self,
        path: Path,
        configuration: Mapping[str, Any],
        bounds: Mapping[str, tuple[float, float]],
        start: Mapping[str, float],
        scores: Callable[[Measured], tuple[float, ...]],
        objectives: int,
    ) -> None:
        """Open a store, or make one.

        Args:
            path: SQLite file in a folder that exists.
            configuration: JSON values on which every result depends.
            bounds: Lowest and highest value of each number.
            start: Numbers of the first trial.
            scores: Function from measurements to the scores that the sampler minimises.
            objectives: Number of scores.

        Raises:
            ConfigurationError: The store holds another search.
            ExportError: The file is not a store, or cannot be written.
        """
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        self.path, self._start, self._scores = path, dict(start), scores
        self._distributions = {name: FloatDistribution(low, high, log=True) for name, (low, high) in bounds.items()}
        try:
            self._storage = optuna.storages.RDBStorage(f"sqlite:///{path.resolve()}")
            self._search = optuna.create_study(
                study_name=_SEARCH,
                storage=self._storage,
                directions=["minimize"] * objectives,
                load_if_exists=True,
            )
            self._notes = optuna.create_study(study_name=_NOTES, storage=self._storage, load_if_exists=True)
            self._check(json.loads(json.dumps(configuration)))
        except ConfigurationError:
            raise
        except Exception as error:
            reason = str(error).partition("\n")[0]
            raise ExportError(f"{path}: is not the store of a search, or cannot be written: {reason}") from error

    @property
    def study(self) -> optuna.Study:
        """Search as a study of optuna."""
        return self._search

    def _check(self, configuration: dict[str, Any]) -> None:
        known = self._search.user_attrs.get("configuration")
        if known is None:
            self._search.set_user_attr("configuration", configuration)
        elif known != configuration:
            raise ConfigurationError(
                f"{self.path} holds another search: {difference(known, configuration)}; choose another --out, or "
                "repeat the command that began it"
            )

    def records(self) -> list[TrialRecord]:
        """Return the finished trials, sorted by number."""
        states = (TrialState.COMPLETE, TrialState.PRUNED)
        return [_record(trial) for trial in self._search.get_trials(deepcopy=False, states=states)]

    def propose(self, total: int) -> list[tuple[int, dict[str, float]]]:
        """Return number and values of the trials that run next; none if `total` are finished."""
        begun = self._search.get_trials(deepcopy=False)
        count = len(begun)
        # A batch may be incomplete, after an interrupt or because of a smaller `total` in an earlier run.
        whole = count % BATCH == 0 and all(trial.state.is_finished() for trial in begun)
        end = min(total, count + BATCH if whole else -(-count // BATCH) * BATCH)
        if any(trial.state == TrialState.WAITING for trial in begun):
            self._ask(count - 1)
        for number in range(count, end):
            self._ask(number)
        running = self._search.get_trials(deepcopy=False, states=(TrialState.RUNNING,))
        return [(trial.number, dict(trial.params)) for trial in running]

    def _ask(self, number: int) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
            self._search.sampler = optuna.samplers.TPESampler(
                seed=SAMPLER_SEED + number, n_startup_trials=SPREAD, multivariate=True, constant_liar=True
            )
        fixed = self._start if number == 0 else self._spread(number) if number < SPREAD else None
        waiting = self._search.get_trials(deepcopy=False, states=(TrialState.WAITING,))
        if fixed is not None and not waiting:
            self._search.enqueue_trial(fixed)
        self._search.ask(self._distributions)

    def _spread(self, number: int) -> dict[str, float]:
        """Return a point of an additive recurrence, on the logarithmic scale of the search.

        The shares are multiples of powers of 1 / g modulo 1, with g^(d + 1) = g + 1. They leave no large gaps in d
        dimensions (Kronecker sequences; H. Niederreiter, Random Number Generation and Quasi-Monte Carlo Methods, 1992).
        """
        bounds = self._distributions.values()
        g = 2.0
        for _ in range(50):
            g = (1.0 + g) ** (1.0 / (len(bounds) + 1))
        shares = [(0.5 + number * g ** -(axis + 1)) % 1.0 for axis in range(len(bounds))]
        return {
            name: float(bound.low * (bound.high / bound.low) ** share)
            for name, bound, share in zip(self._distributions, bounds, shares, strict=True)
        }

    def tell(self, report: TrialReport) -> None:
        """Write the report of a trial; when this returns, it is kept."""
        trial = optuna.trial.Trial(self._search, self._search.get_trials(deepcopy=False)[report.number]._trial_id)
        with warnings.catch_warnings():
            # If the process was killed while it wrote, the trial has its constraint already, with the same value.
            warnings.simplefilter("ignore")
            worst = max(report.ringing) - 1.0 if report.measured is not None else FAILED
            trial.set_constraint("ringing", min(worst, FAILED))
        trial.set_user_attr("report", asdict(report))
        if report.measured is None:
            self._search.tell(trial, state=TrialState.PRUNED)
        else:
            self._search.tell(trial, self._scores(report.measured))

    def noted(self, key: str) -> Any:
        """Return the value that was noted under a key, or None."""
        return self._notes.user_attrs.get(key)

    def note(self, key: str, value: Any) -> None:
        """Note a JSON value that takes long to compute."""
        self._notes.set_user_attr(key, value)


def _record(trial: FrozenTrial) -> TrialRecord:
    table = dict(trial.user_attrs["report"])
    measured = table.pop("measured")
    ringing = tuple(table.pop("ringing"))
    report = TrialReport(measured=Measured(**measured) if measured else None, ringing=ringing, **table)
    return TrialRecord(trial.number, trial.params, report)
