"""Forces against walls of known stiffness: at rest, while sliding, with joint friction, and at impact."""

import numpy as np
import pytest

from arms import ARMS, HOME, load, without_friction
from pilegrasp_ctrl.control.contact_impedance import YIELDING_STIFFNESS, ContactImpedanceController
from pilegrasp_ctrl.control.impedance import ImpedanceController
from pilegrasp_ctrl.control.sampled_data import largest_force_gain, least_inertia, tool_mobility
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.tasks.gains import Impedance
from pilegrasp_ctrl.tasks.impedance_law import ImpedanceLaw
from pilegrasp_ctrl.tasks.pose_task import pose_error
from pilegrasp_ctrl.trajectories.straight_line import StraightLine
from pilegrasp_ctrl.types import Reference
from spring_wall import SpringWall
from touch import LAG, WristSensor, home, run

SPRINGS = np.array([1200.0] * 3 + [60.0] * 3)
TO_WALL, ALONG, DOWN = np.array([1.0, 0, 0]), np.array([0, 1.0, 0]), np.array([0, 0, -1.0])
DESIRED = 10.0
SPEED = 0.1
WALLS = (1e3, 1e4)
SLIDES = [(TO_WALL, ALONG, 1e3), (TO_WALL, ALONG, 1e4), (DOWN, ALONG, 1e4), (DOWN, -TO_WALL, 1e4)]
"""Direction of the force, direction of the motion, and stiffness of the wall [N/m]."""


def wrench_along(direction, size=DESIRED):
    return np.concatenate((size * direction, np.zeros(3)))


@pytest.mark.parametrize("stiffness", WALLS)
@pytest.mark.parametrize("name", ARMS)
def test_at_rest_the_wall_carries_the_spring_and_the_desired_force(name, stiffness):
    arm = without_friction(name)
    start = home(arm)
    controller = ImpedanceController(arm, Impedance(SPRINGS), HOME[name])
    reference, desired = Reference(start.pose.moved([0.02, 0.01, -0.01])), wrench_along(TO_WALL, 6.0)
    wall = SpringWall(start.translation + 0.005 * TO_WALL, -TO_WALL, stiffness)

    def control(observation, state):
        return controller.step(observation, reference, state=state, desired_force=desired)

    _, wrenches, states = run(arm, control, wall, 1.5)
    pressed = -wrenches[-1, 0]
    assert pressed == pytest.approx(SPRINGS[0] * pose_error(states[-1], reference)[0] + 6.0, rel=0.02)
    # The same follows from two springs in series with known ends.
    expected = stiffness * (SPRINGS[0] * 0.015 + 6.0) / (stiffness + SPRINGS[0])
    assert pressed == pytest.approx(expected, rel=0.02)


def slide(arm, step, stiffness, normal=TO_WALL, along=ALONG, sensor=None, friction=1.0):
    """Press for 0.7 s, then slide at 0.1 m/s; return the force on the wall while the speed is constant."""
    start = home(arm)
    line = StraightLine(start.pose, 0.2 * along, SPEED)

    def control(observation, state):
        return step(observation, line.at(max(0.0, observation.time - 0.7)), state)

    wall = SpringWall(start.translation, -normal, stiffness)
    time, wrenches, _ = run(arm, control, wall, 0.7 + line.duration, sensor=sensor, friction=friction)
    steady = (time > 1.5) & (time < 0.7 + line.duration - 0.3)
    return -wrenches[steady, :3] @ normal


def relative_error(forces, what, desired=DESIRED):
    """Return the rms of the force's error over the desired force, and print it for `docs/impedance.md`."""
    error = np.sqrt(np.mean(np.square(forces - desired))) / desired
    print(f"{what}: mean {forces.mean():.2f} N of {desired:.2f} N, rms error {100.0 * error:.1f} %")
    return error


def named(name, normal, along, stiffness):
    return f"{name}, pressing along {normal}, sliding along {along}, {stiffness:g} N/m"


@pytest.mark.slow
@pytest.mark.parametrize(("normal", "along", "stiffness"), SLIDES)
@pytest.mark.parametrize("name", ARMS)
def test_the_force_is_kept_while_sliding_if_no_spring_acts_along_it(name, normal, along, stiffness):
    arm = load(name)
    free = np.concatenate((np.abs(normal) > 0.5, np.zeros(3, dtype=bool)))
    gains = Impedance(np.where(free, 0.0, SPRINGS), damping=np.where(free, 120.0, 0.0))
    controller = ImpedanceController(arm, gains, HOME[name])
    desired = wrench_along(normal)

    def step(observation, reference, state):
        return controller.step(observation, reference, state=state, desired_force=desired)

    assert relative_error(slide(arm, step, stiffness, normal, along), named(name, normal, along, stiffness)) < 0.05


def hybrid(arm, normal, **gains):
    impedance = Impedance(SPRINGS, **gains)
    return ContactImpedanceController.create(arm, impedance, HOME[arm.name], force_directions=normal, wrench_lag=LAG)


@pytest.mark.slow
@pytest.mark.parametrize("stiffness", WALLS)
@pytest.mark.parametrize("name", ARMS)
def test_the_remaining_spring_takes_its_share_of_the_force(name, stiffness):
    arm = without_friction(name)
    controller, desired = hybrid(arm, TO_WALL), wrench_along(TO_WALL)
    forces = slide(arm, lambda o, r, s: controller.step(o, r, s, desired), stiffness)
    left = YIELDING_STIFFNESS * SPRINGS[0]
    assert (
        relative_error(forces, named(name, TO_WALL, ALONG, stiffness), DESIRED * stiffness / (stiffness + left)) < 0.02
    )


@pytest.mark.slow
@pytest.mark.parametrize(("normal", "along", "stiffness"), SLIDES)
@pytest.mark.parametrize("name", ARMS)
def test_force_feedback_compensates_spring_and_joint_friction(name, normal, along, stiffness):
    arm = load(name)
    controller, desired = hybrid(arm, normal, force_gain=5.0), wrench_along(normal)
    forces = slide(arm, lambda o, r, s: controller.step(o, r, s, desired), stiffness, normal, along, WristSensor())
    assert relative_error(forces, named(name, normal, along, stiffness)) < 0.05


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.7, 1.3])
def test_if_friction_differs_from_the_model_only_force_feedback_keeps_the_force(friction):
    arm, desired, errors = load("wam7"), wrench_along(TO_WALL), []
    for gain in (0.0, 5.0):
        controller = hybrid(arm, TO_WALL, force_gain=gain)
        forces = slide(
            arm, lambda o, r, s, c=controller: c.step(o, r, s, desired), 1e4, sensor=WristSensor(), friction=friction
        )
        errors.append(relative_error(forces, f"wam7, {friction:g} of the modelled friction, force gain {gain:g} 1/s"))
    assert errors[0] > 0.1
    assert errors[1] < 0.05


def test_joint_friction_holds_a_hand_at_rest_and_force_feedback_breaks_it_loose():
    arm, desired, pressed = load("wam7"), wrench_along(TO_WALL), []
    start = home(arm)
    wall = SpringWall(start.translation, -TO_WALL, 1e4)
    for gain in (0.0, 5.0):
        controller = hybrid(arm, TO_WALL, force_gain=gain)

        def control(observation, state, controller=controller):
            return controller.step(observation, Reference(start.pose), state, desired)

        _, wrenches, _ = run(arm, control, wall, 2.0, sensor=WristSensor())
        pressed.append(-wrenches[-1, 0])
    print(f"wam7 at rest: {pressed[0]:.1f} N of 10 N without the sensor, {pressed[1]:.1f} N with it")
    assert pressed[0] < 8.0
    assert pressed[1] == pytest.approx(DESIRED, rel=0.02)


def test_a_force_gain_that_would_oscillate_is_rejected():
    arm = without_friction("panda")
    gains = Impedance(SPRINGS)
    mobility = tool_mobility(arm, gains, HOME["panda"])
    damping = ImpedanceLaw(gains).damping(mobility)[0, 0]
    limit = largest_force_gain(damping, np.linalg.inv(mobility)[0, 0], LAG)
    hybrid(arm, TO_WALL, force_gain=0.9 * limit)
    with pytest.raises(ConfigurationError, match=r"force_gain = .* too large"):
        hybrid(arm, TO_WALL, force_gain=1.1 * limit)


@pytest.mark.parametrize(("share", "swings"), [(0.25, False), (1.2, True)])
def test_the_force_begins_to_oscillate_at_the_largest_force_gain(share, swings):
    """The limit has both terms of the formula; the remaining spring adds to the wall's stiffness."""
    arm, stiffness = without_friction("panda"), 1000.0
    gains = Impedance(SPRINGS)
    mobility = tool_mobility(arm, gains, HOME["panda"])
    damping, inertia = ImpedanceLaw(gains).damping(mobility)[2, 2], np.linalg.inv(mobility)[2, 2]
    both = stiffness + YIELDING_STIFFNESS * SPRINGS[2]
    limit = largest_force_gain(damping, inertia, LAG) + LAG**2 * damping * both / (inertia + damping * LAG) ** 2
    plain = hybrid(arm, DOWN)
    controller = ContactImpedanceController(
        plain.free, plain.yielding, force_gain=share * limit * both / stiffness, force_ramp=0.0
    )
    start, desired = home(arm), wrench_along(DOWN)
    reference = Reference(start.pose)

    def control(observation, state):
        return controller.step(observation, reference, state, desired)

    wall = SpringWall(start.translation, -DOWN, stiffness)
    _, wrenches, _ = run(arm, control, wall, 3.0, sensor=WristSensor(noise=0.0))
    assert (np.ptp(wrenches[-250:, 2]) > 2.0) == swings


def test_force_feedback_does_not_wind_up_without_contact():
    arm = without_friction("panda")
    controller, desired = hybrid(arm, TO_WALL, force_gain=5.0), wrench_along(TO_WALL)
    start = home(arm)
    plain = hybrid(arm, TO_WALL)
    reference = Reference(start.pose)
    displacements = []
    for one in (controller, plain):
        *_, states = run(arm, lambda o, s, c=one: c.step(o, reference, s, desired), None, 1.0, sensor=WristSensor())
        displacements.append(states[-1].translation - start.translation)
    np.testing.assert_allclose(displacements[0], displacements[1], atol=1e-6)


def touch(arm, gains, normal, stiffness=1e4):
    """Run into a wall at 0.1 m/s, with the reference 10 mm beyond; return the wall's force from the first touch on."""
    start = home(arm)
    ahead = 0.03
    line = StraightLine(start.pose, (ahead + 0.01) * normal, SPEED, acceleration=2.0)
    controller = ImpedanceController(arm, gains, HOME[arm.name])
    wall = SpringWall(start.translation + ahead * normal, -normal, stiffness)

    def control(observation, state):
        return controller.step(observation, line.at(observation.time), state=state)

    _, wrenches, states = run(arm, control, wall, 1.5, substeps=8)
    forces = -wrenches[:, :3] @ normal
    first = int(np.argmax(forces > 0.0))
    assert normal @ states[first].twist[:3] == pytest.approx(SPEED, rel=0.02)
    return forces[first:]


@pytest.mark.slow
@pytest.mark.parametrize("normal", [TO_WALL, DOWN])
@pytest.mark.parametrize("name", ARMS)
def test_the_hand_stays_in_contact_and_the_impact_is_that_of_its_inertia(name, normal):
    arm = without_friction(name)
    gains = Impedance(SPRINGS)
    mobility = tool_mobility(arm, gains, HOME[name])
    inertia = float(normal @ np.linalg.inv(mobility)[:3, :3] @ normal)
    forces = touch(arm, gains, normal)
    impact = SPEED * np.sqrt(1e4 * inertia)
    print(f"{name}, along {normal}: impact {impact:.1f} N, at rest {forces[-1]:.1f} N, at most {forces.max():.1f} N")
    assert forces.min() > 0.0
    assert forces[-1] < forces.max() < forces[-1] + impact


def test_with_too_little_damping_the_hand_bounces():
    forces = touch(without_friction("panda"), Impedance(SPRINGS, damping_ratio=0.3), DOWN)
    assert forces.min() == 0.0


def ringing(arm, inertia, stiffness=1e4):
    """Return the range of the force [N] after 1.5 s of pressing down with a late wrench."""
    start = home(arm)
    gains = shaped(inertia)
    controller = ImpedanceController(arm, gains, HOME[arm.name])
    reference, wall = Reference(start.pose), SpringWall(start.translation, -DOWN, stiffness)

    def control(observation, state):
        return controller.step(observation, reference, state=state)

    _, wrenches, _ = run(arm, control, wall, 2.0, sensor=WristSensor(noise=0.0), substeps=8)
    return np.ptp(wrenches[-250:, 2])


def shaped(inertia):
    return Impedance(
        [400.0] * 3 + [30.0] * 3,
        inertia=[8.0, 8.0, inertia, 0.3, 0.3, 0.3],
        desired_force=wrench_along(DOWN),
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_an_inertia_too_small_for_the_sensor_rings_and_is_rejected(name):
    arm = without_friction(name)
    bound = next(m for m in np.arange(0.1, 8.0, 0.05) if m >= least_inertia(arm, shaped(m), HOME[name], LAG)[2])
    assert ringing(arm, 0.4 * bound) > 5.0
    assert ringing(arm, 1.1 * bound) < 0.2
    with pytest.raises(ConfigurationError, match=r"inertia\[2\] = .* too small for a wrench 21.9 ms late"):
        ImpedanceController(arm, shaped(0.9 * bound), HOME[name], wrench_lag=LAG)
    ImpedanceController(arm, shaped(1.1 * bound), HOME[name], wrench_lag=LAG)
