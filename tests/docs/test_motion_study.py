"""The study of the motion pattern: its table, its figure and its script."""

import json
import runpy
from dataclasses import replace
from types import SimpleNamespace

import pytest

import pilegrasp_ctrl
from motion_pattern import BLUE, RED, pattern_figure
from motion_table import MotionPattern, markdown
from odd_recordings import ODD_RECORDINGS
from places import STUDIES
from pushed_pile import (
    crowd,
    push_recording,
)

SCRIPT = STUDIES / "motion_pattern.py"


def test_a_condition_is_summed_up_and_drawn(tmp_path):
    recordings = (push_recording(crowd(0.02, 0.1), held=("o1_4",)) for _ in range(2))
    pattern = MotionPattern.of("wall", recordings)
    bare = MotionPattern.of("none", [ODD_RECORDINGS["failed approach"]])
    summary = pattern.summary()
    assert (summary["attempts"], summary["triggered"], summary["held"]) == (2, 2, 2)
    assert summary["approach_speed"]["mean"] == pytest.approx(0.08, rel=1e-3)
    assert pattern.field.attempts == 2
    assert bare.field is None
    assert "chain_objects" not in summary
    chained = [row | {"force_chains": {"objects": 2.5, "to_support": 0.4, "at_end": []}} for row in pattern.measures]
    assert "| chains at a wall [% of the time] | 40 ± 0 |" in markdown([replace(pattern, measures=tuple(chained))])
    table = markdown([pattern, bare])
    assert "| approach speed [mm/s] | 80 ± 0 | none |" in table.splitlines()
    figure = pattern_figure([pattern, bare])
    figure.savefig(tmp_path / "pattern.png")
    assert (tmp_path / "pattern.png").stat().st_size > 10_000
    before, beside = figure.axes[0].collections[:2]
    assert len(before.U) > 20
    assert (before.U < 0.0).all()
    assert (beside.U > 0.0).all()
    assert [line.get_color() for line in figure.axes[0].lines] == [RED, RED]
    assert BLUE != RED
    assert not figure.axes[1].collections


@pytest.mark.slow
def test_the_script_measures_three_conditions(tmp_path, monkeypatch, capsys):
    asked = []

    def attempted(name, *, seed, record, overrides):
        asked.append((name, seed, overrides["support.kind"]))
        recording = push_recording(crowd(0.01 * seed, 0.1), held=("o1_4",))
        return SimpleNamespace(recording=recording if record else None)

    monkeypatch.setattr(pilegrasp_ctrl, "run", attempted)
    monkeypatch.setattr("sys.argv", ["motion_pattern.py", "1", "3", str(tmp_path)])
    runpy.run_path(str(SCRIPT), run_name="__main__")
    assert asked == [("spheres_wall", seed, kind) for kind in ("none", "wall", "corner") for seed in (1, 2)]
    written = json.loads((tmp_path / "motion_pattern.json").read_text())
    assert [row["condition"] for row in written["conditions"]] == ["none", "wall", "corner"]
    assert written["verdict"]["approach"]["verdict"] == "holds"
    assert (tmp_path / "motion_pattern.png").exists()
    assert "| attempts | 2 | 2 | 2 |" in capsys.readouterr().out
