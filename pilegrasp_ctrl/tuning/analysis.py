"""The analysis of a finished search: stability margins, step responses, and which gain matters."""

from __future__ import annotations

import hashlib
import json
import warnings
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import optuna
from optuna.importance import PedAnovaImportanceEvaluator, get_param_importances

from ..exceptions import ConfigurationError, SimulationError
from ..plant.step_response import StepResponse, step_response
from ..tasks.gains import load_gains
from .choice import choose, pareto_front
from .gain_space import Gains, gains_table
from .objectives import Measured
from .search import Progress, Search
from .stability_margin import MAX_STEP, Margin, find_margin, make_controller, stiffness_probe
from .store import TrialRecord, TuningStore
from .trial import TrialWork, resting_arm, run_trials, trial_pool

AXIS_NAMES = ("x", "y", "z", "about x", "about y", "about z")
"""Names of the six axes of a step response: along, then about, the axes of the world."""
LATE = (0, 1)
"""Control periods by which the torque is late in the margins: as simulated, and one period later."""
SWEEP = tuple(2.0 ** (power / 2.0) for power in range(-4, 5))
"""Factors on one gain at a time (chosen): 1/4 to 4, in steps of the square root of two."""
MIN_TRIALS = 10
"""Smallest number of completed trials from which the importance of each gain is computed (chosen)."""


@dataclass(frozen=True, slots=True, eq=False)
class Contender:
    """The start or the best trial in detail.

    Attributes:
        record: Trial.
        gains: Gains of the trial.
        margins: Stability margin by lateness of the torque in control periods.
        responses: Response to a step along each of the six axes; None if the loop diverged or was refused.
    """

    record: TrialRecord
    gains: Gains
    margins: Mapping[int, Margin]
    responses: tuple[StepResponse | None, ...]


@dataclass(frozen=True, slots=True)
class SweepPoint:
    """One gain changed, the others as in the best trial.

    Attributes:
        value: Value of the gain.
        measured: Measurements; None if the attempt was not completed.
        rings: Whether the loop rings at the required margin.
    """

    value: float
    measured: Measured | None
    rings: bool


@dataclass(frozen=True, slots=True, eq=False)
class SearchAnalysis:
    """A finished search and its analysis.

    Attributes:
        search: Search.
        records: Finished trials.
        front: Pareto front of the trials with margin.
        rule: Rule by which the best was chosen.
        start: Trial 0 in detail.
        best: Proposed trial in detail.
        importance: Share of each gain in good tracking; {} if fewer than `MIN_TRIALS` trials were completed.
        sweeps: Points of each gain, from low to high; {} in the same case.
    """

    search: Search
    records: list[TrialRecord]
    front: list[TrialRecord]
    rule: str
    start: Contender
    best: Contender
    importance: dict[str, float]
    sweeps: dict[str, list[SweepPoint]]


def analyse_search(
    search: Search, store: TuningStore, jobs: int = 1, progress: Progress | None = None
) -> SearchAnalysis:
    """Return the analysis of a finished search; results of an earlier run are read from the store.

    Raises:
        ConfigurationError: No trial was completed.
    """
    records = store.records()
    best, rule = choose(records, search.scenario.strategy.grasp_force)
    if best is None:
        reason = records[0].report.reason if records else "none was run"
        raise ConfigurationError(f"none of the {len(records)} trials was completed; the first: {reason}")
    if progress is not None:
        progress("stability margins", 0, 1, None)
    start = _contender(search, store, records[0])
    chosen = start if best.number == records[0].number else _contender(search, store, best)
    known = sum(record.report.measured is not None for record in records) >= MIN_TRIALS
    sweeps = _sweeps(search, store, best, jobs, progress) if known else {}
    importance = _importance(store.study) if known else {}
    return SearchAnalysis(search, records, pareto_front(records), rule, start, chosen, importance, sweeps)


def _contender(search: Search, store: TuningStore, record: TrialRecord) -> Contender:
    """Return margins and step responses of a trial; known margins are read from the store."""
    gains = load_gains(search.gains_file(record.number))
    arm, q = resting_arm(search.scenario, search.seeds[0])
    rate, solver = search.scenario.controller.rate, search.scenario.controller.solver
    margins = {}
    for late in sorted({*LATE, search.late}):
        key = _key("margin", gains, late)
        known = store.noted(key)
        if known is None:
            known = asdict(find_margin(stiffness_probe(arm, gains, q, rate=rate, solver=solver, late=late)))
            store.note(key, known)
        probes = tuple((factor, ringing) for factor, ringing in known["probes"])
        margins[late] = Margin(known["factor"], known["limited"], probes)
    responses: list[StepResponse | None] = []
    for axis in range(6):
        step = np.zeros(6)
        step[axis] = MAX_STEP[axis // 3]
        try:
            controller = make_controller(arm, gains, q, rate, solver)
            responses.append(step_response(arm, controller, q, displacement=step[:3], rotation=step[3:], rate=rate))
        except (SimulationError, ConfigurationError):
            responses.append(None)
    return Contender(record, gains, margins, tuple(responses))


def _sweeps(
    search: Search, store: TuningStore, best: TrialRecord, jobs: int, progress: Progress | None
) -> dict[str, list[SweepPoint]]:
    """Return the measurements of the first seed with one gain changed at a time."""
    centre = search.space.rounded(best.values)
    points: dict[str, list[tuple[float, str]]] = {}
    work_items: dict[int, tuple[str, TrialWork]] = {}
    for name in centre:
        for step, factor in enumerate(SWEEP):
            values = search.space.rounded({**centre, name: centre[name] * factor}) if factor != 1.0 else centre
            gains = search.space.gains(values)
            key = _key("sweep", gains, search.late)
            points.setdefault(name, []).append((values[name], key))
            if store.noted(key) is None and all(key != known for known, _ in work_items.values()):
                file = search.folder / "gains" / f"sweep_{name}_{step}.toml"
                scenario = search.with_gains(gains, file, f"One gain changed, {name}: {search.scenario.name}.")
                number = len(work_items)
                work_items[number] = (key, TrialWork(number, scenario, search.seeds[:1], search.late))
    with trial_pool(jobs) as pool:
        for done, report in enumerate(run_trials(pool, [work for _, work in work_items.values()])):
            measured = None if report.measured is None else report.measured.as_dict()
            store.note(work_items[report.number][0], {"measured": measured, "rings": not report.feasible})
            if progress is not None:
                progress("sensitivity", done + 1, len(work_items), None)
    return {name: [_point(value, store.noted(key)) for value, key in row] for name, row in points.items()}


def _point(value: float, noted: Mapping[str, Any]) -> SweepPoint:
    measured = noted["measured"]
    return SweepPoint(value, Measured(**measured) if measured else None, noted["rings"])


def _importance(study: optuna.Study) -> dict[str, float]:
    """Return the importance of each gain for the trials with the best tracking.

    After S. Watanabe, A. Bansal and F. Hutter, "PED-ANOVA: efficiently quantifying hyperparameter importance in
    arbitrary subspaces", IJCAI 2023.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return get_param_importances(
            study, evaluator=PedAnovaImportanceEvaluator(), target=lambda trial: float(trial.values[0])
        )


def _key(kind: str, gains: Gains, late: int) -> str:
    """Return the key under which the store notes a margin or a sweep point of these gains."""
    text = json.dumps(gains_table(gains), sort_keys=True)
    return f"{kind} {late} {hashlib.sha256(text.encode()).hexdigest()[:16]}"
