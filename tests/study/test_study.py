"""Studies of real attempts: equal wherever they run, with their errors and recordings."""

import os
import signal

import pytest

import pilegrasp_ctrl as pg
import places
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.plugins import use_plugins
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.study.attempt import WorkItem, repeatable, run_work_item
from pilegrasp_ctrl.study.condition import Condition, conditions
from pilegrasp_ctrl.study.origins import origins_of
from pilegrasp_ctrl.study.run import run_study
from pilegrasp_ctrl.study.summary import summarise
from study_tasks import final_position

SHORT = {"line.displacement": [0.0, 0.02, 0.0]}
OUT_OF_REACH = [1.9, 0.0, 0.25]
MEASURE = "study_tasks:final_position"


def short_attempts(seeds=2):
    """Lines at two speeds, and one that the arm cannot reach."""
    found = conditions("free_space_line", {"line.speed": [0.2, 0.3]}, SHORT)
    found += conditions("free_space_line", {"line.start": [OUT_OF_REACH]}, SHORT)
    return [(condition, seed) for condition in found for seed in range(seeds)]


def recording_of(store, row):
    return store.recording_file(row.config_hash, row.seed)


@pytest.fixture(scope="module", autouse=True)
def helpers():
    use_plugins([places.ROOT / "tests" / "helpers"])
    yield
    use_plugins([])


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    seen = []
    folder = tmp_path_factory.mktemp("study")
    with run_study(short_attempts(), folder, jobs=2, record="first", measure=MEASURE, progress=seen.append) as store:
        yield store, seen


@pytest.mark.slow
def test_an_attempt_that_raises_is_a_row_and_stops_no_other(study):
    store, _ = study
    rows = store.attempts(short_attempts())
    assert [row.success for row in rows] == [True, True, True, True, False, False]
    for row in rows[4:]:
        assert row.result is None
        assert "cannot reach (1.90, 0.00, 0.25)" in row.error


def test_a_row_holds_what_a_single_run_gives(study):
    store, _ = study
    row = store.attempts()[1]
    again = pg.run(store.scenario(row.config_hash), seed=row.seed, record=True)
    measures = row.result["measures"]
    assert {key: value for key, value in row.result.items() if key != "measures"} == repeatable(again)
    assert measures == final_position(again.recording)
    assert not {"wall_time", "realtime_factor"} & row.result.keys()
    assert row.result["controller"].keys() == {"ticks", "limited", "fallbacks"}


def test_the_first_seed_of_each_condition_left_a_recording(study):
    store, _ = study
    recorded = [recording_of(store, row).is_file() for row in store.attempts()]
    # An attempt that raised leaves no recording.
    assert recorded == [True, False, True, False, False, False]
    row = store.attempts()[0]
    assert Recording.load(recording_of(store, row)).meta["config_hash"] == row.config_hash


def test_a_measure_shows_its_mean_beside_the_rate(study):
    store, _ = study
    rows = summarise(store)
    frames = [
        [row.result["measures"]["frames"] for row in store.attempts() if row.config_hash == key and row.result]
        for key in dict.fromkeys(row.config_hash for row in store.attempts())
    ]
    assert [row.as_dict().get("measures") for row in rows] == [
        {"frames": sum(found) / len(found)} if found else None for found in frames
    ]


def test_progress_counts_up_to_all(study):
    _, seen = study
    assert [state.done for state in seen] == sorted(state.done for state in seen)
    last = seen[-1]
    assert (last.total, last.done, last.successes, last.errors) == (6, 6, 4, 2)
    assert last.rate > 0.0
    assert last.seconds_left == 0.0
    assert seen[0].seconds_left is None


def test_a_finished_study_starts_no_worker_and_is_refused_with_another_measure(study, monkeypatch):
    store, _ = study
    monkeypatch.setattr("pilegrasp_ctrl.study.run.open_pool", None)
    run_study(short_attempts(), store.folder, measure=MEASURE).close()
    with pytest.raises(ConfigurationError, match=r"measure is study_tasks:final_position for .*, and none here"):
        run_study(short_attempts(), store.folder)


@pytest.mark.slow
def test_failures_leave_recordings(tmp_path):
    attempts = [(condition, 0) for condition in conditions("push_wall", {"strategy.grasp_force": [200.0]})]
    with run_study(attempts, tmp_path, jobs=1, record="failures") as store:
        (row,) = store.attempts()
        assert not row.success
        assert Recording.load(recording_of(store, row)).meta["reason"] == row.result["reason"]


@pytest.fixture(scope="module")
def cluster():
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        yield cluster


@pytest.mark.slow
def test_a_cluster_that_loses_a_worker_gives_the_same_table_and_the_same_recordings(study, cluster, tmp_path):
    store, _ = study
    killed = []

    def kill_one(state):
        if state.finished and not killed:
            killed.append(next(iter(cluster.workers.values())).pid)
            os.kill(killed[0], signal.SIGKILL)

    options = {"record": "first", "measure": MEASURE, "progress": kill_one}
    with run_study(short_attempts(), tmp_path, scheduler=cluster.scheduler_address, **options) as other:
        assert killed
        assert other.attempts() == store.attempts()
        for row in other.attempts():
            ours, theirs = recording_of(store, row), recording_of(other, row)
            assert ours.is_file() == theirs.is_file()
            assert not ours.is_file() or ours.read_bytes() == theirs.read_bytes()


def work_item(condition, **changes):
    origins = origins_of([condition.scenario]) | changes
    return WorkItem(condition.scenario, condition.config_hash, 0, "no", None, origins)


def test_a_worker_of_another_version_or_with_another_file_refuses_the_attempt(tmp_path):
    gains = tmp_path / "gains.toml"
    gains.write_text("[motion]\nstiffness = 100.0\n")
    scenario = pg.load_scenario("free_space_line", {"controller.gains": str(gains)})
    condition = Condition(scenario, {})
    with pytest.raises(ConfigurationError, match=r"mujoco is 3\.0\.0 for the study, and .* here; give every worker"):
        run_work_item(work_item(condition, mujoco="3.0.0"))
    asked = work_item(condition)
    gains.write_text("[motion]\nstiffness = 101.0\n")
    with pytest.raises(ConfigurationError, match="has changed since the study began"):
        run_work_item(asked)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"pile.object": ["teapot", "light_spheer"]}, "'teapot' is not known.*; .*did you mean 'light_sphere'"),
        ({"controller.rate": [333.0]}, "controller.rate = 333 Hz does not fit"),
        ({"controller.gains": ["missing.toml"]}, "missing.toml: no such file"),
    ],
)
def test_a_scenario_that_cannot_run_is_refused_before_a_worker_starts(tmp_path, changes, sentence):
    with pytest.raises(ConfigurationError, match=sentence):
        run_study([(condition, 0) for condition in conditions("spheres_wall", changes)], tmp_path / "study")
    assert not (tmp_path / "study").exists()


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"record": "some"}, "choose from none, failures, first, all"),
        ({"jobs": 0}, "must be at least 1"),
        (
            {"measure": "study_tasks:speed"},
            "measure = 'study_tasks:speed': the module 'study_tasks' has no function 'speed'",
        ),
        ({"measure": "nothing"}, "is not of the form module:function"),
    ],
)
def test_arguments_out_of_range_are_refused(tmp_path, arguments, sentence):
    with pytest.raises(ConfigurationError, match=sentence):
        run_study(short_attempts(1), tmp_path, **arguments)
    with pytest.raises(ConfigurationError, match="seed = -1"):
        run_study([(short_attempts(1)[0][0], -1)], tmp_path)
