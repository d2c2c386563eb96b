"""The loop of an attempt on backends without an engine: a user's own backend needs the methods of `Backend` alone."""

import gc
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from engineless import TABLE, WALL, CarryingArm, DrawnArm, LoggedArm, arm_of
from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.episode import run_attempt
from pilegrasp_ctrl.exceptions import ConfigurationError, SimulationError
from pilegrasp_ctrl.plant.arm_backend import ArmBackend
from pilegrasp_ctrl.programs.attempt import prepare
from pilegrasp_ctrl.sim.backend import Backend
from spring_wall import SpringWall

SHORT_LINE = {"line.displacement": [0.0, 0.03, 0.0]}


@pytest.fixture(autouse=True)
def cache(tmp_path_factory, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.getbasetemp() / "cache"))


@pytest.fixture
def engine_off(monkeypatch):
    """Fail if MuJoCo makes a step."""
    for name in ("mj_step", "mj_step1", "mj_step2"):
        monkeypatch.setattr(mujoco, name, lambda *_: pytest.fail("MuJoCo made a step"))


def attempt_of(scenario, **overrides):
    return prepare(load_scenario(scenario, {key.replace("__", "."): value for key, value in overrides.items()}), 0)


def short_line():
    return prepare(load_scenario("free_space_line", SHORT_LINE), 0)


def summarised(result):
    return [(outcome.name, outcome.status, outcome.trigger) for outcome in result.outcomes]


# --- the sequence of primitives ---------------------------------------------------------------------------------------


def test_touch_down_and_grasp_force_end_approach_and_push(engine_off):
    attempt = attempt_of("push_wall")
    result = run_attempt(attempt, arm_of(attempt, TABLE, WALL))
    assert summarised(result) == [("approach", "ended", "surface contact"), ("push", "ended", "grasp force")]
    wanted = attempt.scenario.strategy.grasp_force
    assert wanted <= result.outcomes[1].peak_force < 1.05 * wanted
    assert (result.success, result.grasped) == (True, 0)
    assert result.sim_time == result.outcomes[-1].end
    assert len(result.tick_times) == round((result.sim_time - 0.5) / attempt.period)


@pytest.mark.parametrize(
    ("walls", "name", "trigger"),
    [((), "approach", "travel limit: no surface"), ((TABLE,), "push", "travel limit: the force along the push")],
)
def test_without_a_surface_or_a_wall_the_primitive_ends_at_its_travel_limit(engine_off, walls, name, trigger):
    attempt = attempt_of("push_wall")
    result = run_attempt(attempt, arm_of(attempt, *walls))
    assert (result.outcomes[-1].name, result.outcomes[-1].status) == (name, "failed")
    assert result.outcomes[-1].trigger.startswith(trigger)
    assert result.reason == f"{name}: {result.outcomes[-1].trigger}"


def test_the_verdict_counts_the_backends_own_objects():
    attempt = attempt_of("push_wall", program="grasp")
    arm = arm_of(attempt, TABLE, WALL, kind=CarryingArm)
    arm.poses = np.array([[0.95, 0.0, 0.03, 1.0, 0.0, 0.0, 0.0], [0.95, 0.1, 0.03, 1.0, 0.0, 0.0, 0.0]])
    result = run_attempt(attempt, arm)
    assert [outcome.name for outcome in result.outcomes] == ["approach", "push", "grasp", "lift"]
    assert (result.success, result.grasped) == (True, 1)


def test_a_closed_hand_without_objects_has_grasped_nothing():
    attempt = attempt_of("push_wall", program="grasp")
    result = run_attempt(attempt, arm_of(attempt, TABLE, WALL))
    assert (result.success, result.grasped) == (False, 0)
    assert result.reason == "nothing was in the hand after the lift"


def test_an_order_is_filled_from_the_backends_own_objects():
    attempt = attempt_of("bin_picking", pile__count=3, order__count=1, order__operator="sees")
    near_wall = SpringWall([0.95, 0.0, 0.0], [-1.0, 0.0, 0.0], stiffness=2000.0, damping=20.0)
    arm = arm_of(attempt, TABLE, near_wall, kind=CarryingArm)
    arm.poses = attempt.pile.poses.copy()
    result = run_attempt(attempt, arm)
    assert (result.success, result.grasped, len(result.attempts)) == (True, 1, 1)
    assert [outcome.name for outcome in result.outcomes][-2:] == ["deliver", "release"]


# --- faults -----------------------------------------------------------------------------------------------------------


def test_a_saturated_sensor_fails_the_primitive(engine_off):
    class Overloaded(ArmBackend):
        def observe(self):
            observation = super().observe()
            return replace(observation, saturated="Fx beyond 32 N" if observation.time > 0.8 else "")

    attempt = short_line()
    result = run_attempt(attempt, arm_of(attempt, kind=Overloaded))
    assert summarised(result) == [("line", "failed", "wrist sensor saturated: Fx beyond 32 N")]
    assert result.sim_time == pytest.approx(0.8, abs=2.0 * attempt.period)


def test_a_collision_fails_the_primitive_in_the_next_period(engine_off):
    class Colliding(ArmBackend):
        def find_collision(self):
            return "collision with the cat" if self.observe().time > 0.8 else None

    attempt = short_line()
    result = run_attempt(attempt, arm_of(attempt, kind=Colliding))
    assert summarised(result) == [("line", "failed", "collision with the cat")]
    assert result.sim_time == pytest.approx(0.8, abs=3.0 * attempt.period)


def test_a_torque_at_its_limit_for_a_second_fails_the_primitive(engine_off):
    attempt = attempt_of("free_space_line")

    def control(*inputs):
        return attempt.control(*inputs)._replace(active_limits=("torque[1] upper",))

    result = run_attempt(replace(attempt, control=control), arm_of(attempt))
    assert summarised(result) == [("line", "failed", "torque[1] upper limit for 1 s")]
    assert result.sim_time == pytest.approx(1.5, abs=3.0 * attempt.period)


def test_a_backend_that_cannot_be_believed_stops_the_attempt(engine_off):
    attempt = attempt_of("push_wall")
    concrete = SpringWall([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], stiffness=1e9)
    with pytest.raises(SimulationError, match=r"wam7 diverged at 3\."):
        run_attempt(attempt, arm_of(attempt, concrete))
    assert gc.isenabled()


# --- what the loop calls ----------------------------------------------------------------------------------------------


def test_a_control_period_observes_applies_steps_and_looks_for_collisions():
    attempt = short_line()
    arm = arm_of(attempt, kind=LoggedArm)
    result = run_attempt(attempt, arm)
    period = ["observe", "apply", "step", "find_collision"]
    settling = round(0.5 / attempt.period)
    expected = ["object_poses", "observe", "apply", *["step", "observe", "apply"] * settling, "tare"]
    assert arm.calls == [*expected, *period * len(result.tick_times), "observe"]


def test_the_shipped_simulation_and_the_arm_without_an_engine_are_backends():
    attempt = short_line()
    methods = {name for name in dir(Backend) if not name.startswith("_")}
    assert methods == {"observe", "tare", "apply", "step", "find_collision", "object_poses", "view"}
    for backend in (attempt.simulation, arm_of(attempt)):
        assert methods <= {*dir(backend)}


def test_a_backend_that_lacks_a_method_is_rejected_by_its_name():
    class Half:
        view = None

        def observe(self):
            pytest.fail("observed")

    with pytest.raises(ConfigurationError, match="backend Half has no apply, find_collision, object_poses, step, tare"):
        run_attempt(short_line(), Half())


# --- recordings and frames --------------------------------------------------------------------------------------------


def test_a_backends_own_view_is_recorded_and_shown(engine_off):
    attempt, frames = attempt_of("push_wall"), []
    result = run_attempt(
        attempt, arm_of(attempt, TABLE, WALL, kind=DrawnArm), record=True, on_frame=lambda *frame: frames.append(frame)
    )
    recording, push = result.recording, result.outcomes[1]
    assert [body.name for body in recording.bodies] == ["ground", "tool"]
    tool, reference = recording.body_position[:, 1], recording.signals["tool_position"]
    shown = np.array([reference[np.abs(recording.signal_time - time).argmin()] for time in recording.frame_time])
    np.testing.assert_allclose(tool, shown, atol=1.5e-3)
    last = recording.contacts.at(len(recording.frame_time) - 1)
    assert recording.contacts.bodies[last].tolist() == [[1, 0]]
    assert recording.contacts.force[last][0, 0] == pytest.approx(-push.peak_force, abs=1.5)
    assert recording.meta["config_hash"] == attempt.scenario.config_hash()
    assert {name for _, name, *_ in frames} == {"approach", "push"}
    assert len(frames) == len(recording.frame_time) + len(result.outcomes)


@pytest.mark.parametrize("wanted", [{"record": True}, {"on_frame": print}])
def test_an_attempt_that_cannot_be_drawn_is_rejected_before_anything_moves(wanted):
    attempt = short_line()
    arm = arm_of(attempt)
    with pytest.raises(ConfigurationError, match=r"ArmBackend is None.*without record and on_frame"):
        run_attempt(attempt, arm, **wanted)
    np.testing.assert_array_equal(arm.q, attempt.posture)
