"""The search for controller gains: propose, simulate, store, choose."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from ..config import Scenario
from ..exceptions import ConfigurationError
from ..files import locked, make_folder, write_output
from ..provenance import code_digest, version_of
from ..robots import gains_file
from ..sim.hand import Hand
from ..study import FIRST_JUDGING_SEED, MAX_JOBS
from ..study.origins import origins_of
from ..tasks.gains import MotionGains, load_gains
from . import MAX_TRIALS
from .choice import choose
from .gain_space import Gains, GainSpace, gains_table, gains_text
from .objectives import Measured, objective_names
from .store import BATCH, SAMPLER_SEED, SPREAD, TrialRecord, TuningStore
from .trial import REQUIRED_MARGIN, TrialReport, TrialWork, resting_arm, run_trial, run_trials, trial_pool

Progress = Callable[[str, int, int, float | None], None]
"""A callback that gets the running part's name, its finished and total steps, and the best tracking so far [mm]."""


@dataclass(frozen=True, slots=True, eq=False)
class Search:
    """The definition of a search; together with the versions of the packages it fixes every result.

    Attributes:
        scenario: Scenario with `controller.kind` set, and no file of gains.
        space: Gains that may be tried, and the start.
        seeds: Seeds of the attempts of each trial.
        late: Control periods by which the torque is late when the ringing is measured.
        folder: Folder to which everything is written.
    """

    scenario: Scenario
    space: GainSpace
    seeds: tuple[int, ...]
    late: int
    folder: Path

    @property
    def kind(self) -> str:
        """Controller that is tuned."""
        return str(self.scenario.controller.kind)

    def configuration(self) -> dict[str, Any]:
        """Return the definition, and the versions and digests on which every result depends, as JSON values."""
        return {
            "scenario": self.scenario.model_dump(mode="json", exclude={"summary", "tags"}),
            "seeds": list(self.seeds),
            "start": gains_table(self.space.start),
            "bounds": {name: list(bound) for name, bound in self.space.bounds.items()},
            "objectives": list(objective_names(self.scenario)),
            "required_margin": REQUIRED_MARGIN,
            "late": self.late,
            "sampler": {"seed": SAMPLER_SEED, "batch": BATCH, "spread": SPREAD},
            "origins": origins_of([self.scenario])
            | {"optuna": version_of("optuna"), "the search's code": code_digest("tuning")},
        }

    def gains_file(self, number: int) -> Path:
        """Return the path of the gains of a trial."""
        return self.folder / "gains" / f"trial_{number:04d}.toml"

    def with_gains(self, gains: Gains, file: Path, comment: str) -> Scenario:
        """Write the gains to a file and return the scenario that uses it."""
        write_output(file, gains_text(gains, comment).encode(), "gains")
        controller = self.scenario.controller.model_copy(update={"gains": str(file)})
        return self.scenario.model_copy(update={"controller": controller})

    def work_item(self, number: int, values: dict[str, float]) -> TrialWork:
        """Return a trial that is ready to run, its file of gains written."""
        gains = self.space.gains(self.space.rounded(values))
        comment = f"Trial {number} of a search over gains: {self.scenario.name}, {self.kind}."
        return TrialWork(number, self.with_gains(gains, self.gains_file(number), comment), self.seeds, self.late)


def plan_search(
    scenario: Scenario, out: Path, *, start: Path | None = None, seeds: tuple[int, ...] = (0,), late: int = 0
) -> Search:
    """Return a search that can run, and make its folder.

    Args:
        scenario: Scenario to tune for; its controller and its file of gains count.
        out: Folder to write to.
        start: File of the start gains; if absent, the scenario's file, or else the gains that ship with the robot.
        seeds: Seeds of the attempts.
        late: Control periods by which the torque is late when the ringing is measured.

    Raises:
        ConfigurationError: The seeds are kept for judging, the gains do not fit the controller, or the scenario cannot
            be prepared.
        ExportError: The folder cannot be made.
    """
    check_seeds(seeds)
    if not 0 <= late <= 10:
        raise ConfigurationError(f"late = {late} must be between 0 and 10 control periods")
    kind = scenario.controller.kind or Hand.load(scenario.hand).controller
    file = start or scenario.controller.gains or gains_file(scenario.robot, kind)
    gains = load_gains(file)
    if isinstance(gains, MotionGains) != (kind == "operational_space"):
        raise ConfigurationError(
            f"{file}: holds {type(gains).__name__}, but the controller is {kind!r}; choose another with --controller, "
            "or a start that fits"
        )
    controller = scenario.controller.model_copy(update={"kind": kind, "gains": None})
    chosen = scenario.model_copy(update={"controller": controller})
    space = GainSpace.around(gains, controller.rate)
    resting_arm(chosen, seeds[0])
    make_folder(out / "gains")
    return Search(chosen, space, seeds, late, out)


def check_seeds(seeds: tuple[int, ...]) -> None:
    """Refuse seeds that are kept for judging.

    Raises:
        ConfigurationError: There is no seed, one is negative, or one is at least `FIRST_JUDGING_SEED`.
    """
    if not seeds or min(seeds) < 0:
        raise ConfigurationError("--seeds takes FIRST:LAST without the last one, such as 0:3 for three attempts")
    if max(seeds) >= FIRST_JUDGING_SEED:
        raise ConfigurationError(
            f"seed {max(seeds)} is kept for judging the result; tune on seeds below {FIRST_JUDGING_SEED}, such as "
            "--seeds 0:3"
        )


def run_search(
    search: Search,
    trials: int,
    jobs: int = 1,
    progress: Progress | None = None,
    function: Callable[[TrialWork], TrialReport] = run_trial,
) -> TuningStore:
    """Run the missing trials of a search and return its store.

    Every finished trial is in `tuning.db` at once; an interrupt loses only the trials that are under way.

    Args:
        search: Search to run.
        trials: Number of trials in the end, including the start and the failed ones.
        jobs: Number of processes; the results do not depend on it.
        progress: Callback after every trial.
        function: Function that runs a trial; tests replace it.

    Raises:
        ConfigurationError: A number is out of range, or the folder holds another search.
        SimulationError: The worker processes of one trial died again and again.
    """
    if trials < 1 or jobs < 1:
        raise ConfigurationError(f"{trials} trials in {jobs} jobs: both must be at least 1")
    if trials > MAX_TRIALS or jobs > MAX_JOBS:
        raise ConfigurationError(f"{trials} trials in {jobs} jobs: at most {MAX_TRIALS} in {MAX_JOBS} jobs are allowed")
    space, force = search.space, search.scenario.strategy.grasp_force
    with ExitStack() as stack:
        stack.enter_context(locked(search.folder, "search"))
        store = TuningStore(
            search.folder / "tuning.db",
            search.configuration(),
            space.bounds,
            space.start_values,
            partial(Measured.scores, grasp_force=force),
            len(objective_names(search.scenario)),
        )
        pool = stack.enter_context(trial_pool(jobs))
        while proposals := store.propose(trials):
            work_items = [search.work_item(number, values) for number, values in proposals]
            for report in run_trials(pool, work_items, function):
                store.tell(report)
                if progress is not None:
                    records = store.records()
                    progress("trials", len(records), trials, _tracking(choose(records, force)[0]))
    return store


def _tracking(record: TrialRecord | None) -> float | None:
    measured = None if record is None else record.report.measured
    return None if measured is None or not math.isfinite(measured.tracking) else measured.tracking
