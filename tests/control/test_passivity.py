"""Under any push, the arm with its impedance controller returns no more energy than the push put in."""

from itertools import pairwise

import numpy as np
import pinocchio as pin
import pytest

from arms import ARMS, HOME, load, random_states, without_friction
from pilegrasp_ctrl.control.impedance import ImpedanceController
from pilegrasp_ctrl.tasks.gains import Impedance
from pilegrasp_ctrl.tasks.impedance_law import ImpedanceLaw
from pilegrasp_ctrl.tasks.pose_task import pose_error
from pilegrasp_ctrl.types import Command, Reference
from spring_wall import SpringWall
from touch import home, run

RATE = 500.0
SOFT = Impedance([400.0] * 3 + [30.0] * 3)
UNEVEN = Impedance([800.0, 400.0, 200.0, 40.0, 20.0, 10.0], damping_ratio=0.5)
TOLERANCE = 2e-5
"""Tolerance as a share of the energy exchanged; chosen.

The wrench is held for a period in which the tool moves, and its work is computed with the mean of two velocities.
"""


def mobility(state):
    return state.J @ np.linalg.solve(state.M, state.J.T)


def stored(state, reference, stiffness):
    """Return the kinetic energy of the tool's inertia plus the potential of the springs [J]."""
    error = pose_error(state, reference)
    return 0.5 * state.twist @ np.linalg.solve(mobility(state), state.twist) + 0.5 * error @ (stiffness * error)


class Pushes:
    """A random wrench up to 3 Hz, of about 15 N and 0.4 N·m, held for each control period."""

    def __init__(self, seed):
        random = np.random.default_rng(seed)
        self._size = random.normal(size=(6, 6)) * np.repeat([15.0, 0.4], 3)[:, None] / np.sqrt(6.0)
        self._rate, self._phase = 2.0 * np.pi * random.uniform(0.2, 3.0, (6, 6)), random.uniform(0.0, 6.28, (6, 6))
        self.now = np.zeros(6)

    def at(self, time):
        self.now = (self._size * np.sin(self._rate * time + self._phase)).sum(axis=1)
        return self.now

    def __call__(self, pose, twist):
        return self.now


def dissipated(arm, gains, seed=0, disturb=None, duration=2.5):
    """Return the energy (n,) dissipated since the start, and the total energy exchanged [J]."""
    reference, pushes = Reference(home(arm).pose), Pushes(seed)
    controller = ImpedanceController(arm, gains, HOME[arm.name])
    wrenches = []

    def control(observation, state):
        wrenches.append(pushes.at(observation.time).copy())
        output = controller.step(observation, reference, state=state)
        if disturb is None:
            return output
        return output._replace(command=Command(output.command.torque + disturb(state)))

    _, _, states = run(arm, control, pushes, duration)
    work = [0.0]
    for wrench, before, after in zip(wrenches, states, states[1:], strict=False):
        turned = 0.5 * (before.twist[3:] + after.twist[3:]) / RATE
        work.append(wrench[:3] @ (after.translation - before.translation) + wrench[3:] @ turned)
    energy = np.array([stored(state, reference, gains.stiffness) for state in states])
    return np.cumsum(work) + energy[0] - energy, np.abs(work).sum()


def largest_drop(values):
    """Return the largest drop of a value below an earlier one."""
    return float(np.max(np.maximum.accumulate(values) - values))


@pytest.mark.slow
@pytest.mark.parametrize("gains", [SOFT, UNEVEN], ids=["even", "uneven"])
@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("name", ARMS)
def test_the_arm_never_returns_more_energy_than_pushes_put_in(name, seed, gains):
    energy, exchanged = dissipated(without_friction(name), gains, seed)
    assert exchanged > 1.0
    assert energy[-1] > 0.3 * exchanged
    assert largest_drop(energy) < TOLERANCE * exchanged


def test_joint_friction_dissipates_energy():
    energy, exchanged = dissipated(load("wam7"), SOFT)
    assert largest_drop(energy) < TOLERANCE * exchanged


def negative_damping(arm):
    """Return a torque of 1.1 times the springs' dampers, with the sign reversed."""
    task = ImpedanceLaw(SOFT)
    return lambda state: 1.1 * state.J.T @ (task.damping(mobility(state)) @ state.twist)


def too_much_friction(arm):
    """Return a compensation of friction that does not exist, along the measured velocity."""
    return lambda state: 0.05 * arm.torque_limit * np.tanh(state.v / 0.02)


# With negative damping a light wrist exceeds all limits after 50 ms.
@pytest.mark.parametrize(("disturb", "duration"), [(negative_damping, 0.04), (too_much_friction, 0.5)])
@pytest.mark.parametrize("name", ARMS)
def test_the_energy_balance_detects_a_controller_that_feeds_energy_in(name, disturb, duration):
    arm = without_friction(name)
    energy, exchanged = dissipated(arm, SOFT, disturb=disturb(arm), duration=duration)
    assert largest_drop(energy) > 100.0 * TOLERANCE * exchanged


@pytest.mark.parametrize("name", ARMS)
def test_contact_with_a_stiff_wall_adds_no_energy(name):
    """The hand hits the wall at about 0.2 m/s; the energy stored in the wall counts too."""
    arm, stiffness = without_friction(name), 1e4
    start = home(arm)
    direction, ahead = np.array([0.0, 0.0, -1.0]), 0.02
    reference = Reference(start.pose.moved(0.04 * direction))
    controller = ImpedanceController(arm, SOFT, HOME[name])
    wall = SpringWall(start.translation + ahead * direction, -direction, stiffness)
    _, wrenches, states = run(
        arm, lambda observation, state: controller.step(observation, reference, state=state), wall, 1.5, substeps=8
    )
    held = np.square(np.linalg.norm(wrenches[:, :3], axis=1)) / (2.0 * stiffness)
    energy = held + [stored(state, reference, SOFT.stiffness) for state in states]
    assert held.max() > 0.003
    assert largest_drop(-energy) < TOLERANCE * energy[0]
    assert energy[-1] < 0.6 * energy[0]


@pytest.mark.parametrize("name", ARMS)
def test_the_damping_exceeds_half_the_growth_of_the_tool_s_inertia(name):
    """½ Lambda' < D holds with the shipped springs and all joints at full speed, away from singular postures."""
    arm, task = without_friction(name), ImpedanceLaw(Impedance([2500.0] * 3 + [120.0] * 3))
    step, worst = 1e-6, 0.0
    for q, v in random_states(arm, 150, speed=1.0):
        state, ahead = arm.update(q, v), arm.update(q + step * v, v)
        if np.linalg.svd(state.J, compute_uv=False)[-1] < 0.1:
            continue
        here = np.linalg.inv(mobility(state))
        growth = 0.5 * (np.linalg.inv(mobility(ahead)) - here) / step
        damping = np.linalg.inv(np.linalg.cholesky(task.damping(mobility(state))))
        worst = max(worst, np.linalg.eigvalsh(damping @ (growth + growth.T) @ damping.T)[-1] / 2.0)
    print(f"{name}: half the growth of the inertia is at most {worst:.2f} of the damping")
    assert 0.1 < worst < 1.0


def test_unequal_springs_give_no_energy_on_a_closed_path_of_rotations():
    """Around a cone of 1 rad the moment's work sums to zero; that of K e would not."""
    arm = without_friction("panda")
    state = home(arm)
    task = ImpedanceLaw(Impedance([400.0] * 3 + [40.0, 20.0, 10.0]))
    reference = Reference(state.pose)
    angles = np.linspace(0.0, 2.0 * np.pi, 1001)
    axes = np.stack((np.cos(angles) + 0.2, np.sin(angles) + 0.1, np.full_like(angles, 0.7)), axis=1)
    rotations = [pin.exp3(axis / np.linalg.norm(axis)) for axis in axes]
    inertia, none = np.linalg.inv(mobility(state)), np.zeros(6)
    exact = plain = 0.0
    for before, after in pairwise(rotations):
        turn = pin.log3(after @ before.T)
        turned = state._replace(rotation=pin.exp3(0.5 * turn) @ before @ state.rotation)
        error = pose_error(turned, reference)
        exact += (inertia @ task.acceleration(turned, reference, error, none, none, mobility(turned)))[3:] @ turn
        plain += (task.stiffness @ error)[3:] @ turn
    assert abs(exact) < 1e-3
    assert abs(plain) > 0.1
