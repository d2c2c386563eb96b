"""What the environment breaks is no result: the study stops with a sentence, and the attempt is left to be done."""

import json
import tempfile

import numpy as np
import pytest

import places
from pilegrasp_ctrl import ArmModel, Observation, OperationalSpaceController, StraightLine
from pilegrasp_ctrl.exceptions import PileError, SimulationError, SolverError, environment_fault
from pilegrasp_ctrl.plugins import use_plugins
from pilegrasp_ctrl.qp.program import solve
from pilegrasp_ctrl.qp.solvers import make_solver
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.sim import monitors
from pilegrasp_ctrl.study import attempt
from pilegrasp_ctrl.study.attempt import WorkItem, run_work_item
from pilegrasp_ctrl.study.condition import conditions
from pilegrasp_ctrl.study.dispatch import InlinePool, dispatch
from pilegrasp_ctrl.study.origins import origins_of
from pilegrasp_ctrl.study.run import run_study
from pilegrasp_ctrl.study.worker_pool import WorkerPool
from pilegrasp_ctrl.tuning.trial import TrialWork, run_trial
from random_programs import random_program
from study_tasks import work
from synthetic_recording import synthetic

SHORT = {"line.displacement": [0.0, 0.01, 0.0], "line.speed": 0.3}
MEASURE = "study_tasks:refused_while"


@pytest.fixture
def work_item():
    (condition,) = conditions("free_space_line", {}, SHORT)
    return WorkItem(condition.scenario, condition.config_hash, 0, "yes", None, origins_of([condition.scenario]))


@pytest.fixture
def no_temporary_folder(monkeypatch, tmp_path):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "full"))


def test_a_recording_is_made_in_memory(work_item, no_temporary_folder, tmp_path):
    report = run_work_item(work_item)
    assert (report.success, report.error) == (True, None)
    (tmp_path / "a.npz").write_bytes(report.recording)
    assert Recording.load(tmp_path / "a.npz").meta["success"] is True


def test_the_bytes_of_a_recording_are_those_of_its_file(tmp_path):
    recording = synthetic(frames=3, objects=2)
    recording.save(tmp_path / "a.npz")
    assert recording.to_bytes() == (tmp_path / "a.npz").read_bytes()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("disk", "OSError: .*No space left on device"),
        ("package", "ImportError: libgomp"),
        ("hidden", "PermissionError: .*Permission denied"),
    ],
)
def test_a_study_that_the_environment_breaks_stops_and_repeats_the_attempt(tmp_path, monkeypatch, kind, words):
    use_plugins([places.ROOT / "tests" / "helpers"])
    if kind != "disk":  # one of them in a worker
        monkeypatch.setattr("pilegrasp_ctrl.study.run.open_pool", lambda jobs, scheduler: InlinePool())
    fault = tmp_path / "fault"
    monkeypatch.setenv("FAULT", str(fault))
    attempts = [(condition, 0) for condition in conditions("free_space_line", {}, SHORT)]
    fault.write_text(kind)
    with pytest.raises(SimulationError, match=rf"^seed 0 could not run on .*{words}.*the same command runs the rest$"):
        run_study(attempts, tmp_path / "study", jobs=1, measure=MEASURE)
    fault.unlink()
    with run_study(attempts, tmp_path / "study", jobs=1, measure=MEASURE) as store:
        (row,) = store.attempts()
    assert row.error is None
    assert row.result["measures"]["frames"] > 0


@pytest.mark.parametrize("fault", [OSError(28, "No space left on device"), ImportError("no module")])
def test_the_environment_is_found_behind_another_error(fault):
    try:
        raise fault
    except Exception:
        try:
            raise SimulationError("a sentence") from None
        except SimulationError as error:
            found = environment_fault(error)
    assert str(fault) in found
    assert environment_fault(PileError("the pile does not settle")) is None
    assert environment_fault(ValueError("a value")) is None


def test_a_fault_of_the_attempt_is_a_row_as_before(work_item, monkeypatch):
    def raises(item):
        raise PileError("the pile did not come to rest")

    monkeypatch.setattr(attempt, "_run", raises)
    assert run_work_item(work_item).error == "the pile did not come to rest"


def test_a_row_of_a_simulation_that_diverges_is_the_same_each_time_and_leaves_no_file(work_item, monkeypatch, tmp_path):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(monitors.Watchdog, "check", lambda self, data: diverge(self, data))

    def diverge(watchdog, data):
        watchdog._states.append((data.time, data.qpos.copy(), data.qvel.copy(), data.ctrl.copy()))
        watchdog._stop(data, "the state is not finite")

    first, second = run_work_item(work_item), run_work_item(work_item)
    assert first.error == second.error
    assert first.error.endswith("s the state is not finite")
    assert list(tmp_path.iterdir()) == []


def test_a_trial_that_the_environment_breaks_is_no_failed_trial(monkeypatch, tmp_path):
    (condition,) = conditions("free_space_line", {}, SHORT)
    gone = condition.scenario.controller.model_copy(update={"gains": str(tmp_path / "gone.toml")})
    work = TrialWork(0, condition.scenario.model_copy(update={"controller": gone}), (0,))
    with pytest.raises(SimulationError, match=r"^trial 0 could not run: .*No such file.*same command runs the rest$"):
        run_trial(work)


# --- what the environment refuses a solver ----------------------------------------------------------------------------

REFUSED = [
    MemoryError(),
    OSError(28, "No space left on device", "/tmp/model.lp"),
    PermissionError(13, "Permission denied", "/opt/solver.lic"),
    ImportError("libgomp.so.1: cannot open shared object file"),
]


class Failing:
    """A solver that answers some programs, and then raises."""

    def __init__(self, error, after=0):
        self.exact, self.error, self.left = make_solver("daqp"), error, after

    def solve(self, program):
        self.left -= 1
        if self.left < 0:
            raise self.error
        return self.exact.solve(program)


@pytest.mark.parametrize("error", REFUSED, ids=lambda error: type(error).__name__)
def test_what_the_environment_refuses_a_solver_is_no_answer_to_a_program(error):
    program = random_program(0)
    with pytest.raises(SolverError, match=f"^Failing raised {type(error).__name__}") as caught:
        solve(program, Failing(error))
    assert environment_fault(caught.value).startswith(type(error).__name__)
    # The softened program is not tried: its answer would be another one.
    once = Failing(error)
    once.left, once.exact.solve = 0, None
    with pytest.raises(SolverError):
        solve(program, once)
    assert once.left == -1


@pytest.mark.parametrize("error", REFUSED, ids=lambda error: type(error).__name__)
def test_a_controller_holds_the_arm_and_says_what_the_environment_refused(error):
    arm = ArmModel.load("wam7")
    q = 0.5 * (arm.q_lower + arm.q_upper)
    line = StraightLine(arm.update(q, np.zeros(7)).pose, [0.0, 0.1, 0.05], 0.5)
    controller = OperationalSpaceController(arm, posture=q, solver=Failing(error))
    output = controller.step(Observation(0.0, q, np.zeros(7)), line.at(0.1))
    assert output.fallback.startswith(f"Failing raised {type(error).__name__}")
    assert output.refused.startswith(type(error).__name__)
    another = OperationalSpaceController(arm, posture=q, solver=Failing(ValueError("no")))
    output = another.step(Observation(0.0, q, np.zeros(7)), line.at(0.1))
    assert (bool(output.fallback), output.refused) == (True, "")


@pytest.mark.parametrize("error", REFUSED, ids=lambda error: type(error).__name__)
def test_an_attempt_whose_solver_the_environment_refuses_something_has_no_result(work_item, monkeypatch, error):
    monkeypatch.setattr("pilegrasp_ctrl.control.inverse_dynamics.make_solver", lambda name: Failing(error, after=5))
    with pytest.raises(SimulationError, match=rf"^seed 0 could not run on .*{type(error).__name__}.*runs the rest$"):
        run_work_item(work_item)
    monkeypatch.setattr(
        "pilegrasp_ctrl.control.inverse_dynamics.make_solver", lambda name: Failing(ValueError("no"), after=5)
    )
    assert run_work_item(work_item).error is None


def test_memory_that_is_too_small_stops_a_study_and_leaves_the_attempt(tmp_path):
    items = [(str(tmp_path), number, "lacks memory" if number == 2 else "works") for number in range(4)]
    died = []
    with (
        pytest.raises(SimulationError, match=r"memory is too small .* no result"),
        WorkerPool(2) as pool,
    ):
        list(dispatch(pool, work, items, lambda item, deaths: died.append(item)))
    assert died == []
    assert (tmp_path / "2").stat().st_size == 1 + WorkerPool.retries


# --- the file of the last states --------------------------------------------------------------------------------------


def test_the_last_states_go_to_a_fresh_file_and_through_no_link(monkeypatch, tmp_path):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    victim = tmp_path / "victim"
    victim.write_text("mine")
    (tmp_path / "pilegrasp-last-states-abc-7.npz").symlink_to(victim)
    files = set()
    for _ in range(2):
        watchdog = monitors.Watchdog("abc-7")
        watchdog._states.append((0.0, *(np.zeros(2) for _ in range(3))))
        files.add(watchdog._write_states())
    assert len(files) == 2
    assert victim.read_text() == "mine"
    assert all(file.name.startswith("pilegrasp-last-states-abc-7-") for file in files)


def test_last_states_that_cannot_be_written_leave_the_reason(no_temporary_folder):
    watchdog = monitors.Watchdog("abc-7")
    watchdog._states.append((0.0, *(np.zeros(2) for _ in range(3))))
    assert watchdog._write_states() is None
    error = SimulationError("at 0.500 s the state is not finite", None)
    assert json.dumps(str(error)) == '"at 0.500 s the state is not finite"'
