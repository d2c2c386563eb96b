import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from arms import ARMS, HOME, without_friction

from pilegrasp_ctrl import Arc, ArmSimulation, OperationalSpaceController, StraightLine
from pilegrasp_ctrl.exceptions import ConfigurationError, ModelError
from pilegrasp_ctrl.experiments import example_arm, tracking
from pilegrasp_ctrl.experiments.condition import CONDITIONS
from pilegrasp_ctrl.experiments.follow import follow
from pilegrasp_ctrl.experiments.tracking import tracking_table
from pilegrasp_ctrl.experiments.tracking_rows import PathRow, StepRow, TrackingTable

SCRIPT = Path(__file__).parents[1] / "scenarios" / "tracking_table.py"


@pytest.fixture(params=ARMS)
def arm(request):
    return without_friction(request.param)


@pytest.mark.parametrize("path", ["line", "arc"])
def test_without_friction_a_path_at_a_tenth_of_a_metre_per_second_is_tracked(arm, path):
    """What is left is the posture's share in the program; it pulls more the further the arm is from its posture."""
    q = HOME[arm.name]
    start = arm.update(q, np.zeros(arm.nv)).pose
    if path == "line":
        motion = StraightLine(start, [0.0, 0.3, 0.0], 0.1)
    else:
        motion = Arc(start, start.moved([0.0, 0.1, 0.0]).translation, [1.0, 0.0, 0.0], -np.pi, 0.1)
    done = follow(ArmSimulation(arm), OperationalSpaceController(arm, posture=q), motion.at, q, motion.duration + 0.5)
    errors = np.linalg.norm(done.error.reshape(-1, 2, 3), axis=2)
    assert errors[:, 0].max() < 1.5e-4
    assert errors[-1, 0] < 1e-4
    assert errors[:, 1].max() < 2e-4
    assert done.active_limits() == ()
    assert done.fallbacks == 0


def test_a_turning_arc_is_tracked(arm):
    q = HOME[arm.name]
    start = arm.update(q, np.zeros(arm.nv)).pose
    arc = Arc(start, start.moved([-0.2, 0.0, 0.0]).translation, [0.0, 0.0, 1.0], 0.6, 0.1, turning=True)
    done = follow(ArmSimulation(arm), OperationalSpaceController(arm, posture=q), arc.at, q, arc.duration)
    assert np.abs(done.error).max() < 1.5e-4


def test_limits_are_told_with_the_time_at_which_they_bound():
    arm, q = without_friction("panda"), HOME["panda"]
    line = StraightLine(arm.update(q, np.zeros(7)).pose, [0.0, 0.3, 0.0], 2.0, acceleration=40.0)
    done = follow(ArmSimulation(arm), OperationalSpaceController(arm, posture=q), line.at, q, 2.0)
    assert done.active_limits()
    assert done.active_limits(start=1.5) == ()


def test_every_row_is_there(monkeypatch):
    """2 arms, 2 paths at 3 speeds and 3 steps, 5 conditions, and for the arm that rubs 2 more."""

    def row(case):
        zeros = [0.0] * 5
        if case.motion == "step":
            return StepRow(case.arm, case.value, case.condition.name, *zeros, 0.0, ())
        return PathRow(case.arm, case.motion, case.value, case.condition.name, *zeros, ())

    monkeypatch.setattr(tracking, "_measure", row)
    table = tracking_table()
    assert len(table.paths) == 2 * 3 * (7 + 5)
    assert len(table.steps) == 3 * (7 + 5)
    assert len({(row.arm, row.path, row.speed, row.condition) for row in table.paths}) == len(table.paths)
    assert len({(row.arm, row.size, row.condition) for row in table.steps}) == len(table.steps)
    assert {row.condition for row in table.paths if row.arm == "wam7"} == {c.name for c in CONDITIONS}
    assert {row.speed for row in table.paths} == {0.05, 0.1, 0.25}
    assert {row.size for row in table.steps} == {0.005, 0.01, 0.025}


@pytest.fixture(scope="module")
def panda():
    return tracking_table(["panda"], [0.25], [0.01])


def test_what_was_measured_is_what_mechanics_says(panda):
    """The error at rest is J M⁻¹ times the torque that the controller does not know of, over the stiffness."""
    rows = {row.condition: row for row in panda.steps}
    arm, q = without_friction("panda"), HOME["panda"]
    state = arm.update(q, np.zeros(7))

    def predicted(torque):
        return np.linalg.norm((state.J @ np.linalg.solve(state.M, torque))[:3]) / 900.0

    assert rows["nominal"].at_rest < 1e-5
    weight = np.array([0.0, 0.0, 0.5 * 9.81, 0.0, 0.0, 0.0])
    assert rows["payload 0.5 kg"].at_rest == pytest.approx(predicted(state.J.T @ weight), rel=0.1)
    for name in ("mass +10 %", "mass -10 %"):
        assert rows[name].at_rest == pytest.approx(predicted(0.1 * state.h), rel=0.1)


def test_rows_agree_with_each_other(panda):
    for row in panda.paths:
        assert row.rms <= row.peak
        assert row.at_rest <= row.peak
        assert row.settling_time == np.inf or row.at_rest < 1e-3
    nominal, *others = (row for row in panda.paths if row.path == "arc")
    assert nominal.condition == "nominal"
    assert all(row.rms > 2.0 * nominal.rms for row in others)
    (noisy,) = (row for row in panda.steps if row.condition == "sensor noise")
    assert noisy.overshoot > 0.0


def test_the_wam_with_its_friction_needs_the_compensation():
    table = tracking_table(["wam7"], [], [0.025])
    at_rest = {row.condition: row.at_rest for row in table.steps}
    assert at_rest["no friction"] < 1e-4 < at_rest["nominal"] < 1.5e-3 < at_rest["friction not compensated"]
    assert table.paths == ()


def test_the_number_of_jobs_changes_nothing(panda):
    assert tracking_table(["panda"], [], [0.01], jobs=2).steps == panda.steps


def test_markdown_has_a_line_per_row_and_says_never_where_nothing_settles(panda):
    paths, steps = panda.markdown().split("\n\n")
    lines = paths.splitlines()
    assert len(lines) == 2 + len(panda.paths)
    assert len(steps.splitlines()) == 2 + len(panda.steps)
    assert len({line.count("|") for line in lines}) == 1
    (sagging,) = (line for line in lines if "| line | 0.25 m/s | payload 0.5 kg |" in line)
    assert "| never |" in sagging
    assert "inf" not in paths + steps


def test_the_documented_table_is_what_comes_out(panda):
    """Docs that went stale are out by more than half a tenth of a millimetre, a second or a degree."""
    page = SCRIPT.parents[1] / "docs" / "tracking.md"
    shown = [line.split(" | ") for line in page.read_text(encoding="utf-8").splitlines()]
    for line in panda.markdown().splitlines():
        if "| panda |" in line:
            cells = line.split(" | ")
            (found,) = (row for row in shown if row[:3] == cells[:3] and row[3 if "/s" in cells[2] else 2] in cells)
            for old, new in zip(found, cells, strict=True):
                assert old == new or float(old) == pytest.approx(float(new), abs=0.05, rel=0.05)


def test_a_row_tells_which_kinds_of_limits_bound():
    row = PathRow("wam7", "line", 0.1, "nominal", 0.0, 0.0, 0.0, 0.0, 0.0, ("torque[1] upper", "torque[2] lower"))
    assert TrackingTable((row,), ()).markdown().splitlines()[2].endswith("| torque |")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"arms": ["iiwa"]}, "no arm 'iiwa' to measure; the arms are wam7, panda"),
        ({"speeds": [0.0]}, "positive"),
        ({"steps": [-0.01]}, "positive"),
        ({"jobs": 0}, "positive"),
    ],
)
def test_a_table_that_cannot_be_measured_is_refused(arguments, message):
    with pytest.raises(ConfigurationError, match=message):
        tracking_table(**arguments)


def test_without_the_pandas_data_the_error_says_what_to_install(monkeypatch):
    def missing(name):
        raise example_arm.PackageNotFoundError(name)

    monkeypatch.setattr(example_arm, "distribution", missing)
    with pytest.raises(ModelError, match="example-robot-data"):
        example_arm.panda_urdf()


def script(*arguments):
    environment = {**os.environ, "PYTHONPATH": str(SCRIPT.parents[1])}
    command = [sys.executable, str(SCRIPT), *arguments]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=False)


def test_the_script_prints_the_part_that_was_asked_for(panda):
    done = script("--arms", "panda", "--speeds", "--steps", "0.01")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == TrackingTable((), panda.steps).markdown() + "\n"


def test_the_script_refuses_with_a_sentence():
    done = script("--speeds", "-1")
    assert done.returncode != 0
    assert "Traceback" not in done.stderr
    assert "positive" in done.stderr
