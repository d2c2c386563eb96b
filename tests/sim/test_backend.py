"""The simulated robot: reset, observation, command and step."""

import tempfile

import numpy as np
import pytest

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.exceptions import SimulationError
from pilegrasp_ctrl.programs.attempt import prepare
from pilegrasp_ctrl.sim.stepper import Stepper


@pytest.fixture(scope="module")
def backend(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        attempt = prepare(load_scenario("spheres_wall", {"pile.count": 2}), seed=0)
    return attempt.simulation, attempt.arm, attempt.simulation.observe().q.copy()


POSES = np.array([[0.9, 0.1, 0.027, 1.0, 0.0, 0.0, 0.0], [0.9, -0.1, 0.027, 0.0, 1.0, 0.0, 0.0]])


def test_reset_puts_arm_and_objects_at_their_poses_at_rest(backend):
    simulation, _, q = backend
    simulation.reset(q, POSES)
    observation = simulation.observe()
    np.testing.assert_array_equal(observation.q, q)
    np.testing.assert_array_equal(observation.v, 0.0)
    assert observation.time == 0.0
    np.testing.assert_array_equal(simulation.object_poses(), POSES)
    position, quaternion = simulation.view.poses()
    objects = [body.role == "object" for body in simulation.view.bodies]
    np.testing.assert_allclose(position[objects], POSES[:, :3])
    np.testing.assert_allclose(quaternion[objects], POSES[:, 3:])
    assert not simulation.data.ctrl.any()


def test_a_step_is_a_control_period_and_gravitys_torque_holds_the_arm(backend):
    simulation, arm, q = backend
    simulation.reset(q, POSES)
    before = simulation.observe()
    simulation.apply(arm.update(q, np.zeros(7)).h, 0.0)
    for _ in range(50):
        simulation.step()
    after = simulation.observe()
    assert after.time == pytest.approx(0.1)
    np.testing.assert_allclose(after.q, q, atol=2e-3)
    np.testing.assert_array_equal(before.q, q)
    assert (before.time, np.abs(before.v).max()) == (0.0, 0.0)


@pytest.mark.parametrize("joint", range(7))
def test_a_positive_torque_turns_its_joint_in_the_positive_direction(backend, joint):
    simulation, arm, q = backend
    simulation.reset(q, POSES)
    torque = arm.update(q, np.zeros(7)).h.copy()
    torque[joint] += 2.0 * arm.friction_coulomb[joint] + 0.2
    simulation.apply(torque, 0.0)
    for _ in range(10):
        simulation.step()
    assert simulation.observe().v[joint] > 1e-3


def test_the_closure_moves_every_finger_and_no_joint_of_the_arm(backend):
    simulation, _, q = backend
    simulation.reset(q, POSES)
    torque = np.arange(1.0, 8.0)
    simulation.apply(torque, 0.6)
    np.testing.assert_array_equal(simulation.data.ctrl, [*torque, *[0.6] * 5])


def test_after_a_reset_the_motion_is_the_same_to_the_last_bit(backend):
    simulation, arm, q = backend
    ends = []
    for _ in range(2):
        simulation.reset(q, POSES)
        simulation.apply(0.9 * arm.update(q, np.zeros(7)).h, 0.5)
        for _ in range(50):
            simulation.step()
        ends.append((simulation.data.qpos.copy(), simulation.data.qvel.copy()))
    np.testing.assert_array_equal(ends[0][0], ends[1][0])
    np.testing.assert_array_equal(ends[0][1], ends[1][1])


def test_what_a_backend_returns_is_not_changed_by_later_steps(backend):
    simulation, _, q = backend
    simulation.reset(q, POSES)
    observation = simulation.observe()
    returned = [observation.q, observation.v, observation.wrench, simulation.object_poses(), *simulation.view.poses()]
    kept = [array.copy() for array in returned]
    for _ in range(5):
        simulation.data.qvel[:] = 0.3
        simulation.step()
    assert not np.array_equal(simulation.object_poses(), kept[3])
    for array, before in zip(returned, kept, strict=True):
        np.testing.assert_array_equal(array, before)


def test_a_reset_forgets_what_was_watched(backend, tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    simulation, _, q = backend
    simulation.reset(q, POSES)
    for _ in range(20):
        simulation.step()
    simulation.reset(q, POSES)
    simulation.data.qvel[0] = np.nan
    with pytest.raises(SimulationError, match=r"at 0\.002 s .*not finite.*the last states are in"):
        simulation.step()
    (file,) = tmp_path.glob("pilegrasp-last-states-*.npz")
    assert len(np.load(file)["time"]) == 1


def test_another_stepper_may_advance_the_simulation(backend):
    simulation, _, q = backend
    steps = []

    class CountingStepper(Stepper):
        def step(self):
            steps.append(self.data.time)
            super().step()

    shipped, simulation.stepper = simulation.stepper, CountingStepper(simulation.scene.model, simulation.data)
    simulation.reset(q, POSES)
    simulation.step()
    simulation.stepper = shipped
    assert steps == [0.0, 0.001]
    assert simulation.observe().time == 0.002
