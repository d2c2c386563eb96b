"""Stiff in free motion, yielding where a force is asked for: the law, a stiff table, and the shovel's push."""

import mujoco
import numpy as np
import pytest
from arms import simulate, without_friction

from pilegrasp_ctrl.control.gains import Impedance
from pilegrasp_ctrl.control.hybrid_impedance import YIELDING_STIFFNESS, HybridImpedanceController
from pilegrasp_ctrl.control.impedance import ImpedanceController
from pilegrasp_ctrl.episode import run
from pilegrasp_ctrl.sim.backend import Simulation
from pilegrasp_ctrl.sim.hand import Hand
from pilegrasp_ctrl.types import Observation, Reference

IMPEDANCE = Impedance(stiffness=[2500.0, 2500.0, 2500.0, 120.0, 120.0, 120.0])
PRESS = np.array([0.0, 0.0, -5.0, 0.0, 0.0, 0.0])
HOME = np.array([0.26, 0.82, -0.01, 1.68, -0.87, 0.81, -1.03])


@pytest.fixture(scope="module")
def hybrid():
    arm = without_friction("wam7", tool=Hand.load("shovel").mass_properties())
    return arm, HybridImpedanceController.create(arm, IMPEDANCE, HOME, "daqp", 500.0)


def spring_force(arm, controller, displacement, desired_force):
    """Return what a displaced reference adds to the force on the tool [N, N·m]."""
    state = arm.update(HOME, np.zeros(7))
    observation = Observation(0.0, HOME, np.zeros(7))
    here, there = Reference(state.pose), Reference(state.pose.moved(displacement))
    torques = [controller.step(observation, target, state, desired_force).command.torque for target in (here, there)]
    inverse = np.linalg.inv(state.M)
    return np.linalg.solve(state.J @ inverse @ state.J.T, state.J @ inverse @ (torques[1] - torques[0]))


def test_without_a_desired_force_it_is_the_impedance_controller(hybrid):
    arm, controller = hybrid
    plain = ImpedanceController(arm, IMPEDANCE, HOME)
    state = arm.update(HOME, 0.1 * np.ones(7))
    observation = Observation(0.0, HOME, 0.1 * np.ones(7))
    reference = Reference(state.pose.moved([0.0, 0.01, -0.01]))
    np.testing.assert_array_equal(
        controller.step(observation, reference, state, np.zeros(6)).command.torque,
        plain.step(observation, reference, state=state).command.torque,
    )


@pytest.mark.parametrize(("force", "share"), [(np.zeros(6), 1.0), (PRESS, YIELDING_STIFFNESS)])
def test_with_a_desired_force_only_its_axis_yields(hybrid, force, share):
    arm, controller = hybrid
    for axis, stiffness in enumerate((2500.0, 2500.0, share * 2500.0)):
        displacement = 0.01 * np.eye(3)[axis]
        added = spring_force(arm, controller, displacement, force)
        np.testing.assert_allclose(added[:3], stiffness * displacement, atol=0.02 * 25.0)


def test_the_desired_force_is_what_it_presses_with(hybrid):
    arm, controller = hybrid
    state = arm.update(HOME, np.zeros(7))
    observation, reference = Observation(0.0, HOME, np.zeros(7)), Reference(state.pose)
    torque = controller.step(observation, reference, state, PRESS).command.torque - state.h
    inverse = np.linalg.inv(state.M)
    np.testing.assert_allclose(
        np.linalg.solve(state.J @ inverse @ state.J.T, state.J @ inverse @ torque), PRESS, atol=0.1
    )


def test_sliding_along_a_stiff_table_it_keeps_the_desired_force(hybrid):
    arm, controller = hybrid
    start = arm.update(HOME, np.zeros(7)).pose
    table, speed, stiffness, damping = start.translation[2], 0.05, 2e4, 200.0
    forces = []

    def contact(q, v):
        state = arm.update(q, v)
        force = max(0.0, stiffness * (table - state.translation[2]) - damping * state.twist[2])
        forces.append(force)
        return state.J.T @ [-0.3 * force, 0.0, force, 0.0, 0.0, 0.0]

    def torque(observation):
        reference = Reference(start.moved([speed * observation.time, 0.0, 0.0]), np.array([speed, 0, 0, 0, 0, 0.0]))
        state = arm.update(observation.q, observation.v)
        return controller.step(observation, reference, state, PRESS).command.torque

    for _ in simulate(arm, torque, HOME, 2.0, external=contact):
        pass
    settled = np.array(forces[len(forces) // 4 :])
    assert settled.mean() == pytest.approx(5.0, abs=0.25)
    assert settled.min() > 3.0


@pytest.fixture(scope="module")
def slide(tmp_path_factory):
    """The shovel's push over the bare table: the contact's force at every physics step, the sensor's at every tick."""
    felt, read = [], []
    step, observe = mujoco.mj_step, Simulation.observe

    def felt_step(model, data, steps=1):
        force = np.zeros(6)
        for _ in range(steps):
            step(model, data)
            total = np.zeros(3)
            for contact in range(data.ncon):
                mujoco.mj_contactForce(model, data, contact, force)
                total += data.contact.frame[contact].reshape(3, 3).T @ force[:3]
            felt.append((data.time, *total))

    def read_wrench(self):
        observation = observe(self)
        read.append((observation.time, *observation.wrench[:3]))
        return observation

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        patch.setattr(mujoco, "mj_step", felt_step)
        patch.setattr(Simulation, "observe", read_wrench)
        push = run("push_wall", overrides={"hand": "shovel"}).outcomes[1]
    sliding = (np.array([row for row in rows if push.start + 0.5 < row[0] < push.end - 0.1]) for rows in (felt, read))
    return [rows[:, 1:].mean(axis=0) for rows in sliding]


def test_the_shovel_presses_on_the_table_as_asked_for(slide):
    force, _ = slide
    assert force[2] == pytest.approx(5.0, abs=0.5)
    assert force[0] == pytest.approx(-0.5 * force[2], rel=0.1)


def test_the_wrist_sensor_reads_on_average_what_the_table_does(slide):
    force, wrench = slide
    np.testing.assert_allclose(wrench, force, atol=0.5)
