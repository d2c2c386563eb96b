"""The store of a study: its content, its errors and its counts."""

import json
import sqlite3
import sys

import pytest
from scipy.stats import norm

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.exceptions import ConfigurationError, ExportError
from pilegrasp_ctrl.files import locked
from pilegrasp_ctrl.neutral_values import with_older_meaning
from pilegrasp_ctrl.plugins import use_plugins
from pilegrasp_ctrl.study import origins
from pilegrasp_ctrl.study.attempt import AttemptReport
from pilegrasp_ctrl.study.condition import Condition, conditions
from pilegrasp_ctrl.study.origins import check_origins, compare, origins_of
from pilegrasp_ctrl.study.run import run_study
from pilegrasp_ctrl.study.store import StudyStore
from pilegrasp_ctrl.study.summary import summarise

ORIGINS = {"mujoco": "4.0.0", "robots/wam7": "sha256:a"}


def outcome(trigger):
    return {"name": "push", "status": "ended", "trigger": trigger}


def report(condition, seed, grasped=1, trigger="grasp force", error=None, recording=None):
    result = {"success": grasped > 0, "grasped": grasped, "outcomes": [outcome(trigger)]}
    text = None if error else json.dumps(result)
    return condition, AttemptReport(condition.config_hash, seed, text, error, grasped > 0, recording, 1.5, 2.5, "host")


@pytest.fixture
def counts():
    return conditions("spheres_wall", {"pile.count": [3, 5]})


@pytest.fixture
def store(tmp_path, counts):
    with StudyStore(tmp_path / "study", create=True) as store:
        store.adopt(counts, ORIGINS)
        yield store


def test_every_combination_is_a_condition():
    found = conditions("spheres_wall", {"pile.count": [3, 5], "hand": ["shovel"]}, {"pile.mass": 0.18})
    assert [dict(condition.varied) for condition in found] == [
        {"pile.count": 3, "hand": "shovel"},
        {"pile.count": 5, "hand": "shovel"},
    ]
    assert {condition.scenario.pile.mass for condition in found} == {0.18}
    assert found[0].as_dict() == {"scenario": "spheres_wall", "pile.count": 3, "hand": "shovel"}


@pytest.mark.parametrize(
    ("vary", "overrides", "sentence"),
    [
        ({"pile.count": [3, -1], "strategy.speed": [9.0, 0.1]}, {}, "pile.count = -1 .*; .*strategy.speed = 9.0 "),
        ({"pile.cuont": [3]}, {}, "unknown key 'pile.cuont'; did you mean"),
        ({"pile.count": []}, {}, "has no values"),
        ({"pile.count": [3]}, {"pile.count": 4}, "pile.count is set and varied"),
        ({"pile.count": [3, 3]}, {}, "pile.count = 3 and pile.count = 3 are the same configuration"),
    ],
)
def test_values_that_cannot_be_varied_are_named_in_one_sentence(vary, overrides, sentence):
    with pytest.raises(ConfigurationError, match=sentence) as error:
        conditions("spheres_wall", vary, overrides)
    assert "\n" not in str(error.value)


def test_any_reader_of_the_file_finds_the_row(store, counts):
    store.add([report(counts[0], 7)])
    with sqlite3.connect(store.path) as other:
        columns = [column[1] for column in other.execute("PRAGMA table_info(attempts)")]
        ((config_hash, seed, condition, result, error),) = other.execute("SELECT * FROM attempts")
    assert columns == ["config_hash", "seed", "condition", "result", "error"]
    assert (config_hash, seed, error) == (counts[0].config_hash, 7, None)
    assert json.loads(condition) == {"scenario": "spheres_wall", "pile.count": 3}
    assert json.loads(result)["success"] is True
    assert store.costs() == {(config_hash, 7): (1.5, 2.5)}
    assert sorted(path.name for path in store.folder.iterdir()) == ["study.db"]


def test_a_transaction_is_on_the_disk_when_it_ends(store):
    assert store._connection.execute("PRAGMA synchronous").fetchone() == (3,)
    assert store._connection.execute("PRAGMA journal_mode").fetchone() == ("delete",)


def test_an_attempt_is_stored_once(store, counts):
    store.add([report(counts[0], 0)])
    with pytest.raises(ExportError, match="UNIQUE"):
        store.add([report(counts[1], 0), report(counts[0], 0)])
    # A transaction is whole or not at all.
    assert len(store.attempts()) == 1


def test_missing_attempts_alone_are_handed_out_each_once(store, counts):
    attempts = [(condition, seed) for condition in counts for seed in (0, 1)]
    store.add([report(counts[0], 1)])
    assert store.missing(attempts + attempts) == [attempts[0], *attempts[2:]]


def test_rows_come_in_the_order_of_the_conditions_and_the_seeds(store, counts):
    store.add([report(counts[1], 0), report(counts[0], 2), report(counts[0], 1)])
    keys = [(row.condition["pile.count"], row.seed) for row in store.attempts()]
    assert keys == [(3, 1), (3, 2), (5, 0)]
    (row,) = store.attempts([(counts[1], 0), (counts[1], 5)])
    assert (row.condition["pile.count"], row.seed) == (5, 0)


def test_an_attempt_can_be_run_again_from_the_store_alone(store, counts):
    assert store.scenario(counts[1].config_hash) == counts[1].scenario
    with pytest.raises(ConfigurationError, match="no scenario has the hash"):
        store.scenario("0" * 16)


def test_a_kept_order_from_before_there_was_an_operator_is_one_that_sees(store):
    kept = Condition(load_scenario("bin_picking", {"order.operator": "sees"}), {})
    values = kept.scenario.model_dump(mode="json")
    assert with_older_meaning(values) == values
    del values["order"]["operator"]
    store.adopt([kept], ORIGINS)
    store.scenario_values = lambda config_hash: values
    assert store.scenario(kept.config_hash).order.operator == "sees"


def test_a_file_of_the_users_is_found_from_another_working_directory(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "gains.toml").write_text("[motion]\nstiffness = 100.0\n")
    (tmp_path / "ball.toml").write_text("shape = 'sphere'\nradius = 0.03\nmass = 0.06\n")
    changes = {"controller.gains": "gains.toml", "pile.object": "./ball.toml"}
    condition = Condition(load_scenario("spheres_wall", changes), {})
    with StudyStore("study", create=True) as store:
        store.adopt([condition], ORIGINS)
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    with StudyStore(tmp_path / "study") as store:
        scenario = store.scenario(condition.config_hash)
    assert scenario.controller.gains == str(tmp_path / "gains.toml")
    assert scenario.pile.object == str(tmp_path / "ball.toml")


def test_a_file_of_the_users_that_has_changed_is_found(tmp_path):
    gains = tmp_path / "gains.toml"
    gains.write_text("[motion]\nstiffness = 100.0\n")
    condition = Condition(load_scenario("spheres_wall", {"controller.gains": str(gains)}), {})
    with StudyStore(tmp_path / "study", create=True) as store:
        store.adopt([condition], ORIGINS)
        gains.write_text("[motion]\nstiffness = 101.0\n")
        with pytest.raises(ConfigurationError, match="has changed since"):
            store.scenario(condition.config_hash)


def test_a_recording_lies_beside_its_row(store, counts):
    store.add([report(counts[0], 3, recording=b"npz"), report(counts[0], 4)])
    with_recording, without = store.attempts()
    file = store.folder / "recordings" / f"{counts[0].config_hash}-3.npz"
    assert store.recording_file(with_recording.config_hash, with_recording.seed) == file
    assert file.read_bytes() == b"npz"
    assert not store.recording_file(without.config_hash, without.seed).exists()


@pytest.mark.parametrize(
    ("asked", "sentence"),
    [
        ({"mujoco": "4.1.0"}, r"mujoco is 4\.0\.0 for .*study\.db, and 4\.1\.0 here; choose another folder"),
        ({"robots/wam7": "sha256:b"}, "robots/wam7 has another digest here than for .*study.db; choose another folder"),
    ],
)
def test_a_study_of_another_origin_is_refused_and_left_alone(store, counts, asked, sentence):
    with pytest.raises(ConfigurationError, match=sentence):
        store.adopt(counts, ORIGINS | asked)
    assert store.origins() == ORIGINS
    store.adopt(counts, ORIGINS | {"objects/cube": "sha256:c"})
    assert store.origins() == ORIGINS | {"objects/cube": "sha256:c"}


def test_another_study_is_refused_with_the_reason(store, counts):
    store.adopt(counts, ORIGINS, {"scenario": {"pile": {"count": 18}}})
    with pytest.raises(ConfigurationError, match=r"holds another study: scenario\.pile\.count = 18 there, and 5 is"):
        store.adopt(counts, ORIGINS, {"scenario": {"pile": {"count": 5}}})


def test_a_file_that_is_not_a_study_is_refused(tmp_path):
    with pytest.raises(ExportError, match="no such study"):
        StudyStore(tmp_path)
    (tmp_path / "study.db").write_text("not a database, but long enough to be taken for something else " * 20)
    with pytest.raises(ExportError, match="is not a study"):
        StudyStore(tmp_path)
    other = tmp_path / "other"
    other.mkdir()
    with sqlite3.connect(other / "study.db") as connection:
        connection.execute("CREATE TABLE attempts (x)")
    with pytest.raises(ExportError, match="is not a study"):
        StudyStore(other, create=True)


def test_one_writer_at_a_time(tmp_path):
    attempts = [(Condition(load_scenario("spheres_wall"), {}), 0)]
    with locked(tmp_path, "study"), pytest.raises(ConfigurationError, match="another study writes there now"):
        run_study(attempts, tmp_path)
    (tmp_path / "file").write_text("")
    with pytest.raises(ExportError, match="the folder cannot be made"):
        run_study(attempts, tmp_path / "file")


def test_counts_and_wilson_intervals(store, counts):
    grasped = [0, 1, 2, 1, 1, 1, 1, 1, 3]
    store.add([report(counts[0], seed, held, "grasp force" if held else "x") for seed, held in enumerate(grasped)])
    store.add([report(counts[0], 9, 0, error="the pile did not come to rest"), report(counts[1], 0)])
    row, other = summarise(store)
    assert (row.n, row.successes, row.multiple, row.triggered, row.errors) == (10, 8, 2, 8, 1)
    # Wilson 1927: at the ends of the interval the score test is just not rejected.
    for end in (row.ci_low, row.ci_high):
        score = (row.rate - end) / (end * (1.0 - end) / row.n) ** 0.5
        assert abs(score) == pytest.approx(norm.ppf(0.975))
    assert other.as_dict() == {
        "condition": {"scenario": "spheres_wall", "pile.count": 5},
        "n": 1,
        "successes": 1,
        "rate": 1.0,
        "ci_low": pytest.approx(0.2065, abs=1e-4),
        "ci_high": 1.0,
        "multiple": 0,
        "triggered": 1,
        "errors": 0,
    }
    (asked,) = summarise(store, [(counts[0], seed) for seed in range(2)])
    assert (asked.n, asked.successes) == (2, 1)


MEASURE = "pilegrasp_ctrl.analysis.motion:measure_attempt"


def test_origins_name_what_a_result_depends_on():
    wall, cubes = load_scenario("spheres_wall"), load_scenario("cubes_wall", {"hand": "shovel"})
    found = origins_of([wall, cubes])
    assert {"pilegrasp", "mujoco", "pin", "numpy", "robots/wam7", "robots/hands/rbo_hand2"} <= found.keys()
    assert {"robots/hands/shovel", "objects/cube", "objects/light_sphere"} <= found.keys()
    assert "robots/hands/shovel" not in origins_of([wall])
    for solver, package in {"osqp": "osqp", "proxqp": "proxsuite", "clarabel": "clarabel"}.items():
        assert package not in found
        assert package in origins_of([load_scenario("spheres_wall", {"controller.solver": solver})])
    assert found["measure"] == "none"
    assert found["Python"] == ".".join(map(str, sys.version_info[:2]))
    assert {"numba", "llvmlite", "eigenpy", "scipy", "qpsolvers"} <= found.keys()
    assert "absent" not in found.values()
    assert origins_of([wall], MEASURE)["measure"] == MEASURE


def test_each_object_of_a_mixture_is_an_origin():
    mixed = load_scenario("spheres_wall", {"pile.object": "light_sphere+cube", "pile.count": 4})
    assert {"objects/light_sphere", "objects/cube"} <= origins_of([mixed]).keys()


def test_a_study_of_another_python_is_refused_in_a_sentence_and_not_mixed(tmp_path, monkeypatch):
    (condition,) = conditions("free_space_line", {}, {"line.displacement": [0.0, 0.01, 0.0]})
    with StudyStore(tmp_path, create=True) as store:
        store.adopt([condition], origins_of([condition.scenario]))
    monkeypatch.setattr("platform.python_version_tuple", lambda: ("3", "99", "1"))
    with pytest.raises(ConfigurationError, match=r"Python is 3\.\d+ for .*study\.db, and 3\.99 here; choose another"):
        run_study([(condition, 0)], tmp_path)
    with StudyStore(tmp_path) as store:
        assert store.attempts() == []


def test_a_worker_of_another_python_is_refused(monkeypatch):
    (condition,) = conditions("free_space_line", {}, {"line.displacement": [0.0, 0.02, 0.0]})
    planned = origins_of([condition.scenario]) | {"Python": "3.99"}
    with pytest.raises(ConfigurationError, match=r"Python is 3\.99 for the study, and .* here; give every worker"):
        check_origins(planned, condition.scenario, None)


def test_a_measure_counts_with_the_modules_that_it_imports(tmp_path):
    package = tmp_path / "measured_here"
    package.mkdir()
    for name in ("__init__", "helper"):
        (package / f"{name}.py").write_text("WIDTH = 0.1\n")
    (package / "spread.py").write_text("from .helper import WIDTH\n\ndef spread(recording):\n    return {}\n")
    use_plugins([tmp_path])
    before = origins_of([], "measured_here.spread:spread")
    (package / "helper.py").write_text("WIDTH = 0.25\n")
    use_plugins([tmp_path])
    after = origins_of([], "measured_here.spread:spread")
    assert {name for name in after if after[name] != before[name]} == {"the measure's code"}


def test_a_changed_file_of_a_robot_or_an_object_is_another_origin(tmp_path, monkeypatch):
    wall = load_scenario("spheres_wall")
    before = origins_of([wall])
    hand = tmp_path / "hand"
    hand.mkdir()
    (hand / "robot.toml").write_text("mass = 1.0\n")
    (hand / "README.md").write_text("a hand")
    ball = tmp_path / "light_sphere.toml"
    ball.write_text("mass = 0.06\n")
    monkeypatch.setattr("pilegrasp_ctrl.robots.folder_of", lambda name: hand)
    monkeypatch.setattr(origins, "object_files", lambda: {"light_sphere": ball})
    first = origins_of([wall])
    (hand / "README.md").write_text("a hand, described better")
    assert origins_of([wall]) == first
    (hand / "robot.toml").write_text("mass = 1.1\n")
    ball.write_text("mass = 0.07\n")
    second = origins_of([wall])
    changed = {"robots/wam7", "robots/hands/rbo_hand2", "objects/light_sphere"}
    assert {name for name in first if first[name] != second[name]} == changed
    assert {name for name in first if first[name] != before[name]} == changed
    with pytest.raises(ConfigurationError, match=r"robots/|objects/light_sphere differs"):
        compare(first, second, "the study", "start anew")
