"""How a pile moves before the hand, without a support, beside a wall and in a corner: a table and the paper's Fig. 2.

Usage: python motion_pattern.py [FIRST LAST [FOLDER]], a range of seeds and where motion_pattern.png and .json go
"""

import json
from collections.abc import Iterator
from pathlib import Path

import pilegrasp_ctrl as pg
from motion_figure import pattern_figure
from motion_table import MotionPattern, markdown
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.scenarios.paper.motion_verdict import motion_verdict
from script import run_script, seed_range


def recordings(support: str, seeds: range) -> Iterator[Recording]:
    """Carry out the attempts with 18 light spheres."""
    keys = {"support.kind": support}
    attempts = (pg.run("spheres_wall", seed=seed, record=True, overrides=keys) for seed in seeds)
    yield from (attempt.recording for attempt in attempts if attempt.recording is not None)


def main(first: int = 0, last: int = 2, folder: Path = Path(".")) -> None:
    """Measure, print the table and what follows from it, draw."""
    folder.mkdir(parents=True, exist_ok=True)
    seeds = seed_range(first, last)
    patterns = [MotionPattern.of(kind, recordings(kind, seeds)) for kind in ("none", "wall", "corner")]
    answers = motion_verdict({pattern.name: pattern.measures for pattern in patterns})
    print(markdown(patterns), *(f"{name}: {answer}" for name, answer in answers.items()), sep="\n")
    pattern_figure(patterns).savefig(folder / "motion_pattern.png", dpi=130)
    rows = {"conditions": [pattern.summary() for pattern in patterns], "verdict": answers}
    (folder / "motion_pattern.json").write_text(json.dumps(rows, indent=2), encoding="utf-8")


if __name__ == "__main__":
    run_script(main)
