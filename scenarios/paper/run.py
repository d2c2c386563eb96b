"""Run the paper's experiments, judge its claims, and write both down."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from pilegrasp_ctrl.files import write_whole
from pilegrasp_ctrl.provenance import versions
from pilegrasp_ctrl.scenarios.paper import NAMES, experiment
from pilegrasp_ctrl.scenarios.paper.charts import save
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.examples import show
from pilegrasp_ctrl.scenarios.paper.experiment import Experiment
from pilegrasp_ctrl.scenarios.paper.ledger import documents, ledger
from pilegrasp_ctrl.scenarios.paper.measure import MEASURE
from pilegrasp_ctrl.scenarios.paper.page import page
from pilegrasp_ctrl.scenarios.paper.plan import Work, plan
from pilegrasp_ctrl.study.run import Progress, run_study
from pilegrasp_ctrl.study.store import StudyStore

FIGURES = "figures"


def run_paper(
    work: Sequence[Work],
    folder: Path,
    first_seed: int,
    *,
    jobs: int,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> StudyStore:
    """Run what is missing into the folder's store and return it, open.

    Raises:
        PilegraspError: as `run_study`; where the folder's study began with other seeds.
    """
    # Seed by seed, so that a study that is stopped early says something of every condition.
    attempts = sorted((pair for part in work for pair in part.pairs(first_seed)), key=lambda pair: pair[1])
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
    """Write `claims.json`, `index.html`, figures and recordings from all that the store holds; return the document.

    Args:
        store: of the study.
        command: what the user typed.
        first_seed: of every condition.
        recordings: whether to make pages of typical attempts; those that are there are linked in any case.
        progress: called with the number of pages that are written, and of all.
    """
    experiments = [experiment(name) for name in NAMES]
    evidence = gather(store, experiments)
    entries = ledger(evidence)
    if recordings:
        show((example for *_, examples in entries for example in examples), store, progress)
    claims = documents(entries)
    for claim in claims:
        found = claim["recordings"].items()
        claim["recordings"] = {kind: file if file and (store.folder / file).is_file() else None for kind, file in found}
    drawn = [part for part in experiments if any(evidence.of(row.condition).n for row in part.rows)]
    (store.folder / FIGURES).mkdir(exist_ok=True)
    figures = {
        part.name: [f"{FIGURES}/{name}" for name in save(part, evidence, store.folder / FIGURES)] for part in drawn
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
    write_whole(store.folder / "index.html", page(document, drawn, evidence).encode())
    return document


def gather(store: StudyStore, experiments: Sequence[Experiment]) -> Evidence:
    """Return all attempts of the store at the experiments' conditions."""
    return Evidence.of_rows(store.attempts(), [part.condition for part in plan(experiments, None)])
