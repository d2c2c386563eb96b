"""A copied or pickled controller answers as the original does, to the bit; and threads do not disturb one another."""

import copy
import pickle
import sys
import threading

import numpy as np
import pytest

from arms import ARMS, HOME, load, without_friction
from pilegrasp_ctrl import ArmSimulation, OperationalSpaceController, StraightLine
from pilegrasp_ctrl.control.contact_impedance import ContactImpedanceController
from pilegrasp_ctrl.control.disturbance_observer import DisturbanceObserver, ObservedController
from pilegrasp_ctrl.control.impedance import ImpedanceController
from pilegrasp_ctrl.control.inverse_dynamics import InverseDynamics
from pilegrasp_ctrl.limits.acceleration_limit import AccelerationLimit
from pilegrasp_ctrl.limits.standard import limits_of
from pilegrasp_ctrl.limits.torque_limit import TorqueRateLimit
from pilegrasp_ctrl.tasks.axis_task import AxisTask
from pilegrasp_ctrl.tasks.frame_task import FrameTask
from pilegrasp_ctrl.tasks.gains import Impedance
from pilegrasp_ctrl.tasks.joint_task import CouplingTask
from pilegrasp_ctrl.tasks.posture_task import PostureTask

STIFF = Impedance([1200.0] * 3 + [20.0] * 3)
YIELDING = Impedance(
    [0.0, 1200.0, 1200.0, 20.0, 20.0, 20.0], desired_force=[5.0, 0.0, 0.0, 0.0, 0.0, 0.0], damping=40.0
)

CONTROLLERS = {
    "daqp": lambda arm, q: OperationalSpaceController(arm, posture=q),
    "osqp": lambda arm, q: OperationalSpaceController(arm, posture=q, solver="osqp"),
    "proxqp": lambda arm, q: OperationalSpaceController(arm, posture=q, solver="proxqp"),
    "quadprog": lambda arm, q: OperationalSpaceController(arm, posture=q, solver="quadprog"),
    "list of tasks": lambda arm, q: composed(arm, q),
    "observed": lambda arm, q: ObservedController(OperationalSpaceController(arm, posture=q), DisturbanceObserver(arm)),
    "impedance": lambda arm, q: ImpedanceController(arm, STIFF, q),
    "contact": lambda arm, q: ContactImpedanceController.create(arm, STIFF, q),
}


class Composed(InverseDynamics):
    """A list of tasks, stepped with a reference as the other controllers are."""

    def step(self, observation, reference):
        self.tasks[0].set_target(reference)
        return super().step(observation)


def composed(arm, q):
    link, one, other = "panda_link4" if arm.name == "panda" else "link4", arm.joint_names[0], arm.joint_names[2]
    elbow = AxisTask(arm, [0.0, 0.0, 1.0], [0.0, 0.3, 1.0], link, weight=1e-2)
    tasks = [FrameTask(arm), elbow, PostureTask(arm, q), CouplingTask(arm, {one: 1.0, other: 1.0})]
    return Composed(arm, tasks, [*limits_of(arm), TorqueRateLimit(arm, 1000.0), AccelerationLimit(arm, 10.0)])


COPIES = {"deepcopy": copy.deepcopy, "pickle": lambda made: pickle.loads(pickle.dumps(made))}


def torques(controller, arm, q, steps=60, start=0):
    """The torques of some periods along a line, each at the state that its own torque led to."""
    line = StraightLine(arm.update(q, np.zeros(arm.nv)).pose, [0.05, 0.1, 0.0], 0.2)
    found = []

    def step(observation):
        more = ()
        if isinstance(controller, ContactImpedanceController):
            more = arm.update(observation.q, observation.v), np.array([0.0, 0.0, -5.0, 0.0, 0.0, 0.0])
        output = controller.step(observation, line.at(observation.time), *more)
        found.append(output.command.torque)
        return output.command.torque

    for _ in zip(range(steps), ArmSimulation(arm).run(step, q, 1.0), strict=False):
        pass
    return np.array(found)


@pytest.mark.parametrize("copied", COPIES)
@pytest.mark.parametrize("kind", CONTROLLERS)
@pytest.mark.parametrize("name", ARMS)
def test_a_fresh_controller_and_its_copy_give_the_same_torques(name, kind, copied):
    arm, q = load(name), HOME[name]
    original = CONTROLLERS[kind](arm, q)
    twin = COPIES[copied](original)
    np.testing.assert_array_equal(torques(twin, arm, q), torques(original, arm, q))


@pytest.mark.parametrize("copied", COPIES)
@pytest.mark.parametrize("kind", CONTROLLERS)
def test_a_used_controller_and_its_copy_go_on_alike(kind, copied):
    arm, q = load("panda"), HOME["panda"]
    original = CONTROLLERS[kind](arm, q)
    torques(original, arm, q, steps=20)
    twin = COPIES[copied](original)
    np.testing.assert_array_equal(torques(twin, arm, q), torques(original, arm, q))


@pytest.mark.parametrize("copied", COPIES)
def test_a_copied_arm_gives_the_same_state_and_stays_read_only(copied):
    arm, q = load("wam7"), HOME["wam7"]
    twin = COPIES[copied](arm)
    for own, others in zip(arm.update(q, 0.1 * q)[:10], twin.update(q, 0.1 * q)[:10], strict=True):
        np.testing.assert_array_equal(own, others)
    with pytest.raises(ValueError, match="read-only"):
        twin.torque_limit[0] = 1.0
    assert repr(twin) == repr(arm)


def test_threads_that_share_an_arm_give_the_torques_of_one_thread():
    arm, q = without_friction("panda"), HOME["panda"]
    expected = torques(OperationalSpaceController(arm, posture=q), arm, q, steps=300)
    found, interval = {}, sys.getswitchinterval()

    def work(number):
        found[number] = torques(OperationalSpaceController(arm, posture=q), arm, q, steps=300)

    sys.setswitchinterval(1e-5)
    try:
        threads = [threading.Thread(target=work, args=(number,)) for number in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    finally:
        sys.setswitchinterval(interval)
    for number in range(3):
        np.testing.assert_array_equal(found[number], expected)
