"""Whole attempts without replaced parts: their sequence, result and recording, to the last bit."""

import json

import numpy as np
import pytest

from pilegrasp_ctrl.analysis.carried import carried_in, count_carried
from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.episode import LOOP_PARTS, run, run_attempt
from pilegrasp_ctrl.programs.attempt import prepare
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.robots import description

pytestmark = pytest.mark.slow

KEYS = [
    "scenario",
    "seed",
    "config_hash",
    "success",
    "grasped",
    "reason",
    "outcomes",
    "packing_density",
    "sim_time",
    "wall_time",
    "realtime_factor",
    "controller",
    "carried",
]
OUTCOME_KEYS = ["name", "status", "trigger", "start", "end", "travel", "peak_force"]
CONTROL_PERIOD = 0.002


@pytest.fixture(scope="module", autouse=True)
def cache(tmp_path_factory):
    """Give these tests an empty cache of piles of their own."""
    folder = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(folder))
        yield folder


@pytest.fixture(scope="module")
def grasp(cache):
    return run("spheres_wall", seed=0, record=True)


@pytest.fixture(scope="module")
def alone(cache):
    return run("spheres_alone", seed=0, record=True)


@pytest.fixture(scope="module")
def line(cache):
    return run("free_space_line", record=True)


@pytest.fixture(scope="module")
def scoop(cache):
    return run("spheres_wall", seed=0, record=True, overrides={"hand": "shovel"})


def summarised(outcomes):
    return [(outcome.name, outcome.status, outcome.trigger) for outcome in outcomes]


# --- the attempts of the paper ----------------------------------------------------------------------------------------


def test_beside_a_wall_the_hand_approaches_pushes_closes_and_lifts(grasp):
    assert summarised(grasp.outcomes) == [
        ("approach", "ended", "surface contact"),
        ("push", "ended", "grasp force"),
        ("grasp", "ended", "closed"),
        ("lift", "ended", "lifted"),
    ]
    assert (grasp.success, grasp.reason) == (True, "")
    assert 1 <= grasp.grasped <= 18


def test_primitives_follow_one_another_without_a_gap(grasp):
    for earlier, later in zip(grasp.outcomes, grasp.outcomes[1:], strict=False):
        assert later.start == earlier.end > earlier.start
    assert grasp.sim_time == grasp.outcomes[-1].end
    assert grasp.outcomes[0].start == pytest.approx(0.5, abs=CONTROL_PERIOD)


def test_the_push_ends_at_the_first_tick_at_which_the_force_is_reached(grasp):
    wanted = load_scenario("spheres_wall").strategy.grasp_force
    assert wanted <= grasp.outcomes[1].peak_force < 1.3 * wanted


def test_the_shovel_runs_the_same_primitives_and_tilts_back(scoop):
    assert summarised(scoop.outcomes) == [
        ("approach", "ended", "surface contact"),
        ("push", "ended", "grasp force"),
        ("grasp", "ended", "tilted back"),
        ("lift", "ended", "lifted"),
    ]
    assert scoop.success
    assert scoop.grasped >= 1


def test_without_a_support_the_push_does_not_reach_its_force_and_the_hand_does_not_close(alone):
    assert [(outcome.name, outcome.status) for outcome in alone.outcomes] == [("approach", "ended"), ("push", "failed")]
    push = alone.outcomes[1]
    assert "travel limit" in push.trigger
    assert push.peak_force < load_scenario("spheres_alone").strategy.grasp_force
    assert push.travel > 0.2
    assert (alone.success, alone.grasped) == (False, 0)
    assert "push" in alone.reason
    assert push.trigger in alone.reason


def test_a_push_into_the_bare_wall_ends_by_the_force_and_grasps_nothing():
    result = run("push_wall")
    assert summarised(result.outcomes) == [("approach", "ended", "surface contact"), ("push", "ended", "grasp force")]
    assert (result.success, result.grasped, result.reason) == (True, 0, "")


# --- result and recording ---------------------------------------------------------------------------------------------


def test_the_result_as_a_dictionary_has_the_promised_keys(grasp):
    facts = grasp.as_dict()
    assert list(facts) == KEYS
    assert facts["carried"] == count_carried(carried_in(grasp.recording))
    assert facts["carried"]["kept"] == facts["grasped"] >= 1
    assert [list(outcome) for outcome in facts["outcomes"]] == [OUTCOME_KEYS] * 4
    assert list(facts["controller"]) == ["ticks", "median_us", "p99_us", "limited", "fallbacks"]
    assert (facts["scenario"], facts["seed"]) == ("spheres_wall", 0)
    assert facts["config_hash"] == load_scenario("spheres_wall").config_hash()
    assert facts["realtime_factor"] * facts["wall_time"] == pytest.approx(facts["sim_time"])


def test_every_tick_is_counted(grasp):
    duration = grasp.outcomes[-1].end - grasp.outcomes[0].start
    assert grasp.as_dict()["controller"]["ticks"] == round(duration / CONTROL_PERIOD)
    assert grasp.as_dict()["controller"]["p99_us"] >= grasp.as_dict()["controller"]["median_us"] > 0.0


@pytest.mark.parametrize("name", ["grasp", "alone", "line"])
def test_the_dictionary_is_json(request, name):
    facts = request.getfixturevalue(name).as_dict()
    assert json.loads(json.dumps(facts, allow_nan=False)) == facts


def test_the_recording_names_its_scenario_and_outcome(grasp):
    facts = grasp.as_dict()
    meta = grasp.recording.meta
    for key in ("scenario", "seed", "config_hash", "success", "grasped", "reason", "outcomes"):
        assert meta[key] == facts[key]
    assert meta["config"] == load_scenario("spheres_wall").model_dump(mode="json")


def test_the_recording_is_sampled_at_its_rates_from_beginning_to_end(grasp):
    recording = grasp.recording
    start, end = grasp.outcomes[0].start, grasp.outcomes[-1].end
    # The end of a primitive is an additional sample.
    ends = [outcome.end for outcome in grasp.outcomes]
    regular = recording.signal_time[~np.isin(recording.signal_time, ends)]
    for times, period in ((recording.frame_time, 1.0 / 30.0), (regular, 0.01)):
        assert times[0] == pytest.approx(start, abs=period)
        assert times[-1] == pytest.approx(end, abs=period)
        assert np.diff(times).max() <= 2.0 * period + 1e-9
        assert np.median(np.diff(times)) == pytest.approx(period, abs=CONTROL_PERIOD + 1e-9)
    assert np.isin(ends, recording.signal_time).all()


def test_the_recorded_force_reaches_the_threshold_at_the_end_of_the_push(grasp):
    recording, push = grasp.recording, grasp.outcomes[1]
    during = (recording.signal_time >= push.start) & (recording.signal_time <= push.end)
    force = recording.signals["push_force"][during]
    assert force.max() == pytest.approx(push.peak_force)
    assert force.argmax() > 0.9 * len(force)


def test_as_many_recorded_objects_rise_as_were_counted(grasp):
    recording = grasp.recording
    objects = [index for index, body in enumerate(recording.bodies) if body.role == "object"]
    rise = recording.body_position[-1, objects, 2] - recording.body_position[0, objects, 2]
    assert len(objects) == 18
    assert np.count_nonzero(rise > 0.1) == grasp.grasped


def test_progress_reports_time_and_primitive():
    calls = []
    result = run("push_wall", progress=lambda time, name: calls.append((time, name)))
    times = [time for time, _ in calls]
    assert list(dict.fromkeys(name for _, name in calls)) == ["approach", "push"]
    assert times == sorted(times)
    assert len(calls) == pytest.approx(10.0 * (result.sim_time - times[0]), abs=2)


# --- to the last bit --------------------------------------------------------------------------------------------------


def saved(recording, file):
    recording.save(file)
    return file.read_bytes()


def test_the_same_seed_gives_the_same_bits_with_and_without_the_cache(grasp, cache, tmp_path):
    """The first attempt settled its pile, and the second one finds it in the cache."""
    piles = {file: file.stat().st_mtime_ns for file in cache.rglob("*.npz")}
    assert piles
    again = run("spheres_wall", seed=0, record=True)
    assert {file: file.stat().st_mtime_ns for file in cache.rglob("*.npz")} == piles
    assert again.outcomes == grasp.outcomes
    assert (again.grasped, again.sim_time) == (grasp.grasped, grasp.sim_time)
    first, second = (saved(result.recording, tmp_path / "a.npz") for result in (grasp, again))
    assert first == second


def test_recording_does_not_change_the_attempt(line):
    unrecorded = run("free_space_line")
    assert unrecorded.recording is None
    assert unrecorded.outcomes == line.outcomes


def test_a_saved_recording_is_read_back_unchanged(grasp, tmp_path):
    file = tmp_path / "attempt.npz"
    grasp.recording.save(file)
    again = Recording.load(file)
    np.testing.assert_array_equal(again.body_position, grasp.recording.body_position)
    assert again.meta == grasp.recording.meta


def test_another_seed_gives_another_pile_and_other_noise():
    one, other = (prepare(load_scenario("spheres_alone"), seed) for seed in (0, 1))
    assert other.scenario.config_hash() == one.scenario.config_hash()
    assert np.linalg.norm(one.pile.poses[:, :3] - other.pile.poses[:, :3], axis=1).min() > 1e-3
    assert (one.simulation.observe().wrench != other.simulation.observe().wrench).all()


# --- tracking and limits ----------------------------------------------------------------------------------------------


def test_a_line_in_free_space_is_tracked(line):
    assert summarised(line.outcomes) == [("line", "ended", "end of the line")]
    recording, phase = line.recording, line.outcomes[0]
    during = (recording.signal_time >= phase.start) & (recording.signal_time <= phase.end)
    error = recording.signals["tracking_error"][during]
    assert np.sqrt(np.mean(error**2)) < 1e-3
    assert error.max() < 3e-3
    assert recording.signals["orientation_error"][during].max() < np.radians(0.5)
    reference = recording.signals["reference_position"][during]
    np.testing.assert_allclose(
        reference[-1] - reference[0], load_scenario("free_space_line").line.displacement, atol=1e-4
    )


def test_the_hand_feels_nothing_in_free_space(line):
    assert np.abs(line.recording.signals["wrench"][:, :3]).max() < 1.0


@pytest.mark.parametrize("name", ["line", "grasp", "scoop"])
def test_no_limit_is_exceeded(request, name):
    signals = request.getfixturevalue(name).recording.signals
    joints = description("wam7")["joints"]
    assert signals["torque_ratio"].max() <= 1.0 + 1e-6
    assert (np.abs(signals["v"]) <= joints["velocity"]).all()
    assert (signals["q"] >= joints["position_lower"]).all()
    assert (signals["q"] <= joints["position_upper"]).all()


def test_an_observer_of_the_loop_is_called_after_each_part_and_changes_nothing(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    scenario, told = load_scenario("free_space_line", {"line.displacement": [0.0, 0.03, 0.0]}), []
    plain = run_attempt(prepare(scenario, 0))
    seen = run_attempt(prepare(scenario, 0), on_part=told.append)
    assert seen.outcomes == plain.outcomes
    assert set(told) == set(LOOP_PARTS)
    assert told.count("step") == told.count("check") == told.count("control")
    first = told.index("primitive") - 2
    assert told[first : first + len(LOOP_PARTS)] == list(LOOP_PARTS)
