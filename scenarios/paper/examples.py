"""Recordings of typical attempts: chosen from the store, carried out again, and shown as pages."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from pilegrasp_ctrl.exceptions import SimulationError
from pilegrasp_ctrl.scenarios.paper.claim import Claim
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.study.attempt import AttemptRow
from pilegrasp_ctrl.study.condition import Condition
from pilegrasp_ctrl.study.store import StudyStore

FOLDER = "recordings"


@dataclass(frozen=True, slots=True)
class Example:
    """A typical attempt: its row and what it shows, "success" or "failure"."""

    row: AttemptRow
    kind: str

    @property
    def page(self) -> str:
        """The page's name below the study's folder."""
        return f"{FOLDER}/{self.row.config_hash}-{self.row.seed}.html"


def examples(claim: Claim, evidence: Evidence) -> list[Example]:
    """Return a typical success and a typical failure, each from the first condition that has one."""
    return [Example(row, kind) for kind in ("success", "failure") if (row := _typical(claim.shown, evidence, kind))]


def _typical(conditions: Sequence[Condition], evidence: Evidence, kind: str) -> AttemptRow | None:
    """Return the attempt of median length among those that came out most often in the same way."""
    for condition in conditions:
        rows = [row for row in evidence.of(condition).rows if row.success == (kind == "success") and row.result]
        if rows:
            usual, _ = Counter(map(_way, rows)).most_common(1)[0]
            alike = sorted((row for row in rows if _way(row) == usual), key=_length)
            return alike[(len(alike) - 1) // 2]
    return None


def _way(row: AttemptRow) -> tuple[int, str]:
    result = row.result or {}
    return row.grasped, str(result.get("reason", ""))


def _length(row: AttemptRow) -> tuple[float, int]:
    return float((row.result or {}).get("sim_time", 0.0)), row.seed


def show(
    wanted: Iterable[Example], store: StudyStore, progress: Callable[[int, int], None] | None = None
) -> list[Path]:
    """Carry the attempts out again and write a page of each that has none yet; return all pages.

    Raises:
        SimulationError: where an attempt does not repeat itself.
    """
    from pilegrasp_ctrl.episode import run
    from pilegrasp_ctrl.viewer import write

    chosen = {example.page: example for example in wanted}
    (store.folder / FOLDER).mkdir(exist_ok=True)
    for done, (page, example) in enumerate(chosen.items()):
        if progress:
            progress(done, len(chosen))
        if (store.folder / page).is_file():
            continue
        row = example.row
        episode = run(store.scenario(row.config_hash), seed=row.seed, record=True)
        if (episode.success, episode.grasped) != (row.success, row.grasped):
            raise SimulationError(
                f"seed {row.seed} of {row.config_hash} came out differently when it was repeated; "
                f"{store.path} was made by another version: choose another folder"
            )
        assert episode.recording is not None
        write(episode.recording, store.folder / page)
    return [store.folder / page for page in chosen]
