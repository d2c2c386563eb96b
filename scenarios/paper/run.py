"""Runs the paper's experiments, judges its claims, and writes the results."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.files import write_whole
from pilegrasp_ctrl.provenance import versions
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.ledger import (
    CLAIMS,
    DRAWS,
    judge_claims,
    ledger_documents,
    page_origin,
    record_examples,
)
from pilegrasp_ctrl.scenarios.paper.page import results_page
from pilegrasp_ctrl.scenarios.paper.paper_numbers import paper_beside_model
from pilegrasp_ctrl.scenarios.paper.plan import EXPERIMENTS, PlannedCondition, extra_conditions, plan, with_settings
from pilegrasp_ctrl.study.own_files import is_own
from pilegrasp_ctrl.study.run import Progress, run_study
from pilegrasp_ctrl.study.scheduler import Scheduler
from pilegrasp_ctrl.study.store import StudyStore

FIGURES = "figures"
"""Folder of the figures, below the study's."""
MEASURE = "pilegrasp_ctrl.analysis.motion:measure_attempt"
"""Function that measures each recording; the study keeps its result. A study is refused after the measure's module, or
one that it imports, has changed. The claims are in another package, so rewording one costs no attempts."""


def run_paper(
    planned: Sequence[PlannedCondition],
    folder: Path,
    first_seed: int,
    *,
    jobs: int,
    scheduler: Scheduler | None = None,
    settings: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
) -> StudyStore:
    """Run the missing attempts into the folder's store, and return the open store.

    The conditions already have the `settings`; the folder keeps them.

    Raises:
        PilegraspError: `run_study` raises it, or the folder's study began with other seeds or settings.
    """
    # Seed by seed, so that a study that is stopped early has attempts at every condition.
    attempts = sorted((pair for part in planned for pair in part.seeded(first_seed)), key=lambda pair: pair[1])
    configuration: dict[str, Any] = {"study": "paper", "first seed": first_seed}
    if settings:
        configuration["set"] = dict(settings)
    return run_study(
        attempts,
        folder,
        jobs=jobs,
        scheduler=scheduler,
        measure=MEASURE,
        configuration=configuration,
        progress=progress,
    )


def write_results(
    store: StudyStore,
    command: str,
    first_seed: int,
    *,
    attempts: int | None = None,
    settings: Mapping[str, Any] | None = None,
    recordings: bool = True,
    progress: Callable[[int, int], None] | None = None,
    draws: int = DRAWS,
) -> dict[str, Any]:
    """Write `claims.json`, `index.html`, figures and recordings from all attempts in the store; return the document.

    Args:
        store: Store of the study.
        command: Command that the user typed.
        first_seed: First seed of every condition.
        attempts: Largest number of attempts at a condition; the ledger's numbers if None.
        settings: Dotted keys and values with which every condition was run.
        recordings: Whether to make pages of typical attempts; pages that this program made are linked in any case.
        progress: Callback that gets the number of written pages and the number of all pages.
        draws: Number of fresh studies from which the probability of repeating a verdict is found.

    There are verdicts only when every attempt of the whole ledger is there, whichever experiments were asked for.
    """
    evidence = gather_evidence(store, settings)
    missing = missing_attempts(store, first_seed, attempts, settings)
    judged = judge_claims(evidence, complete=missing == 0, draws=draws)
    entries = judged.entries
    if recordings:
        record_examples((example for entry in entries for example in entry.examples), store, progress)
    rows = ledger_documents(entries)
    own = {
        example.page
        for entry in entries
        for example in entry.examples
        if is_own(store.folder / example.page, page_origin(example.row))
    }
    for claim in rows:
        found = claim["recordings"].items()
        claim["recordings"] = {outcome: file if file in own else None for outcome, file in found}
    drawn = [
        experiment
        for experiment in EXPERIMENTS.values()
        if any(evidence.sample(part.condition).n for part in experiment.conditions)
    ]
    (store.folder / FIGURES).mkdir(exist_ok=True)
    figures = {
        experiment.name: [f"{FIGURES}/{name}" for name in experiment.save_figure(evidence, store.folder / FIGURES)]
        for experiment in drawn
    }
    document = {
        "command": command,
        "seeds_from": first_seed,
        **({"set": dict(settings)} if settings else {}),
        "attempts": sum(sample.n for sample in evidence),
        "conditions": len(evidence.samples),
        "processor_hours": sum(processor for processor, _ in store.costs().values()) / 3600.0,
        "versions": versions("scipy"),
        "missing": missing,
        "expected": None if judged.repetition is None else judged.repetition.as_dict(),
        "figures": figures,
        "claims": rows[: len(CLAIMS)],
        "nulls": rows[len(CLAIMS) :],
        "paper_beside_model": paper_beside_model(evidence),
    }
    text = json.dumps(document, indent=2, allow_nan=False)
    write_whole(store.folder / "claims.json", text.encode())
    write_whole(store.folder / "index.html", results_page(document, drawn, evidence).encode("utf-8", errors="replace"))
    return document


def missing_attempts(
    store: StudyStore, first_seed: int, attempts: int | None = None, settings: Mapping[str, Any] | None = None
) -> int:
    """Return how many attempts of the whole ledger the store lacks; so it does where the settings do not fit.

    Args:
        store: Store of the study.
        first_seed: First seed of every condition.
        attempts: Largest number of attempts at a condition; the ledger's numbers if None.
        settings: Dotted keys and values with which every condition was run.
    """
    there = {(row.config_hash, row.seed) for row in store.attempts()}
    missing = 0
    for part in plan(EXPERIMENTS.values(), attempts):
        try:
            key = with_settings(part.condition, settings or {}).config_hash
        except ConfigurationError:
            missing += part.attempts
            continue
        missing += sum((key, seed) not in there for _, seed in part.seeded(first_seed))
    return missing


def gather_evidence(store: StudyStore, settings: Mapping[str, Any] | None = None) -> Evidence:
    """Return all attempts of the store at the experiments' conditions, which were run with these settings."""
    conditions = [part.condition for part in plan(EXPERIMENTS.values())]
    run_as: dict[str, str] = {}
    for condition in conditions if settings else ():
        # A condition to which the settings do not fit was not run.
        with suppress(ConfigurationError):
            run_as[condition.config_hash] = with_settings(condition, settings or {}).config_hash
    return Evidence.from_rows(store.attempts(), conditions, run_as, extra_conditions())
