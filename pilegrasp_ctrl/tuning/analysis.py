"""What a finished search is asked: how far it is to ringing, how the arm answers a step, which gain matters."""

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
from .stability_margin import LARGEST_STEP, Margin, find_margin, make_controller, stiffness_probe
from .store import TrialRecord, TuningStore
from .trial import TrialWork, resting_arm, run_trials, trial_pool

AXES = ("x", "y", "z", "about x", "about y", "about z")
LATE = (0, 1)
"""The margin is found as simulated, and with the torque a control period later."""
SWEEP = tuple(2.0 ** (power / 2.0) for power in range(-4, 5))
"""Factors on one gain at a time: a quarter to four times."""
ENOUGH = 10
"""Fewer completed trials say nothing about which gain matters."""


@dataclass(frozen=True, slots=True, eq=False)
class Contender:
    """The start or the best, looked at closely.

    Attributes:
        record: the trial.
        gains: what it used.
        margins: by lateness in control periods.
        responses: to a step along each of the six axes; None where the loop diverged or was refused.
    """

    record: TrialRecord
    gains: Gains
    margins: Mapping[int, Margin]
    responses: tuple[StepResponse | None, ...]


@dataclass(frozen=True, slots=True)
class SweepPoint:
    """One gain changed, the others as in the best.

    Attributes:
        value: of the gain.
        measured: None where the attempt was not completed.
        rings: whether the loop rings at the required margin.
    """

    value: float
    measured: Measured | None
    rings: bool


@dataclass(frozen=True, slots=True, eq=False)
class Explanation:
    """A finished search and what was learned from it.

    Attributes:
        search: what was asked.
        records: every finished trial.
        front: the Pareto front of those with margin.
        rule: how the best was chosen.
        start: trial 0.
        best: the one that is proposed.
        importance: by gain, share of what sets good tracking apart; {} where fewer than `ENOUGH` trials were completed.
        sweeps: by gain, from low to high; {} likewise.
    """

    search: Search
    records: list[TrialRecord]
    front: list[TrialRecord]
    rule: str
    start: Contender
    best: Contender
    importance: dict[str, float]
    sweeps: dict[str, list[SweepPoint]]


def explain(search: Search, store: TuningStore, jobs: int = 1, progress: Progress | None = None) -> Explanation:
    """Look closely at start and best; what was computed for an earlier page is taken from the store.

    Raises:
        ConfigurationError: where no trial was completed.
    """
    records = store.records()
    best, rule = choose(records, search.scenario.strategy.grasp_force)
    if best is None:
        reason = records[0].report.reason if records else "none was carried out"
        raise ConfigurationError(f"none of the {len(records)} trials was completed; the first: {reason}")
    if progress is not None:
        progress("stability margins", 0, 1, None)
    start = _look_at(search, store, records[0])
    chosen = start if best.number == records[0].number else _look_at(search, store, best)
    known = sum(record.report.measured is not None for record in records) >= ENOUGH
    sweeps = _sweeps(search, store, best, jobs, progress) if known else {}
    importance = _importance(store.study) if known else {}
    return Explanation(search, records, pareto_front(records), rule, start, chosen, importance, sweeps)


def _look_at(search: Search, store: TuningStore, record: TrialRecord) -> Contender:
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
        step[axis] = LARGEST_STEP[axis // 3]
        try:
            controller = make_controller(arm, gains, q, rate, solver)
            responses.append(step_response(arm, controller, q, displacement=step[:3], rotation=step[3:], rate=rate))
        except (SimulationError, ConfigurationError):
            responses.append(None)
    return Contender(record, gains, margins, tuple(responses))


def _sweeps(
    search: Search, store: TuningStore, best: TrialRecord, jobs: int, progress: Progress | None
) -> dict[str, list[SweepPoint]]:
    """Change one gain at a time and run the first seed."""
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
    """Return by how much each gain sets the trials with the best tracking apart.

    After S. Watanabe, A. Bansal and F. Hutter, "PED-ANOVA: efficiently quantifying hyperparameter importance in
    arbitrary subspaces", IJCAI 2023.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return get_param_importances(
            study, evaluator=PedAnovaImportanceEvaluator(), target=lambda trial: float(trial.values[0])
        )


def _key(what: str, gains: Gains, late: int) -> str:
    text = json.dumps(gains_table(gains), sort_keys=True)
    return f"{what} {late} {hashlib.sha256(text.encode()).hexdigest()[:16]}"
