"""Runs the paper's experiments, judges its claims, and writes the results."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from pilegrasp_ctrl.files import write_whole
from pilegrasp_ctrl.provenance import versions
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.ledger import judge_claims, ledger_documents, record_examples
from pilegrasp_ctrl.scenarios.paper.page import results_page
from pilegrasp_ctrl.scenarios.paper.plan import EXPERIMENTS, PlannedCondition, plan
from pilegrasp_ctrl.study.run import Progress, run_study
from pilegrasp_ctrl.study.store import StudyStore

FIGURES = "figures"
"""Folder of the figures, below the study's."""
MEASURE = "pilegrasp_ctrl.analysis.motion.measure_attempt"
"""Function that measures each recording; the study keeps its result. A study is refused after its measure's package has
changed. The claims are in another package, so rewording one costs no attempts."""


def run_paper(
    planned: Sequence[PlannedCondition],
    folder: Path,
    first_seed: int,
    *,
    jobs: int,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> StudyStore:
    """Run the missing attempts into the folder's store, and return the open store.

    Raises:
        PilegraspError: `run_study` raises it, or the folder's study began with other seeds.
    """
    # Seed by seed, so that a study that is stopped early has attempts at every condition.
    attempts = sorted((pair for part in planned for pair in part.seeded(first_seed)), key=lambda pair: pair[1])
    configuration = {"study": "paper", "first seed": first_seed}
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
    recordings: bool = True,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, Any]:
    """Write `claims.json`, `index.html`, figures and recordings from all attempts in the store; return the document.

    Args:
        store: Store of the study.
        command: Command that the user typed.
        first_seed: First seed of every condition.
        recordings: Whether to make pages of typical attempts; existing pages are linked in any case.
        progress: Callback that gets the number of written pages and the number of all pages.
    """
    evidence = gather_evidence(store)
    entries = judge_claims(evidence)
    if recordings:
        record_examples((example for entry in entries for example in entry.examples), store, progress)
    claims = ledger_documents(entries)
    for claim in claims:
        found = claim["recordings"].items()
        claim["recordings"] = {
            outcome: file if file and (store.folder / file).is_file() else None for outcome, file in found
        }
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
        "attempts": sum(sample.n for sample in evidence),
        "conditions": len(evidence.samples),
        "processor_hours": sum(processor for processor, _ in store.costs().values()) / 3600.0,
        "versions": versions("scipy"),
        "figures": figures,
        "claims": claims,
    }
    text = json.dumps(document, indent=2, allow_nan=False)
    write_whole(store.folder / "claims.json", text.encode())
    write_whole(store.folder / "index.html", results_page(document, drawn, evidence).encode())
    return document


def gather_evidence(store: StudyStore) -> Evidence:
    """Return all attempts of the store at the experiments' conditions."""
    return Evidence.from_rows(store.attempts(), [part.condition for part in plan(EXPERIMENTS.values())])
