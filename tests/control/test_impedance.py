"""Impedance control: forces in steady contact, the inertia that a push meets, and the dead band."""

import numpy as np
import pytest

from arms import ARMS, HOME, load, simulate, without_friction
from pilegrasp_ctrl.control.impedance import ImpedanceController
from pilegrasp_ctrl.exceptions import ConfigurationError, ModelError
from pilegrasp_ctrl.tasks.gains import Impedance, MotionGains
from pilegrasp_ctrl.tasks.pose_task import pose_error
from pilegrasp_ctrl.tasks.posture_task import PostureTask
from pilegrasp_ctrl.types import Observation, Reference

WALL_STIFFNESS = 4000.0
WALL_DAMPING = 30.0
SPRINGS = Impedance([400.0] * 3 + [30.0] * 3)


@pytest.fixture(params=ARMS)
def arm(request):
    return without_friction(request.param)


def at_home(arm):
    return arm.update(HOME[arm.name], np.zeros(arm.nv))


def wall(arm, position):
    """Return the force (6,) on the tool of a springy wall that fills x > position, as a function of the state."""

    def wrench(state):
        depth = state.translation[0] - position
        return np.array([-max(0.0, WALL_STIFFNESS * depth + WALL_DAMPING * state.twist[0]), 0, 0, 0, 0, 0]) * (
            depth > 0
        )

    return wrench


def push(arm, controller, reference, wrench, duration=1.5, **options):
    """Let the arm come to rest against the wall, its wrench measured exactly; return the last state."""

    def step(observation):
        state = arm.update(observation.q, observation.v)
        seen = Observation(observation.time, observation.q, observation.v, wrench(state))
        output = controller.step(seen, reference, state=state, **options)
        assert output.fallback == ""
        return output.command.torque

    def external(q, v):
        state = arm.update(q, v)
        return state.J.T @ wrench(state)

    *_, (_, q, v, _) = simulate(arm, step, HOME[arm.name], duration, external=external)
    state = arm.update(q, v)
    assert np.abs(state.twist).max() < 2e-3
    return state


def test_steady_contact_gives_the_force_of_the_spring(arm):
    start = at_home(arm)
    reference = Reference(start.pose.moved([0.05, 0.0, 0.0]))
    wrench = wall(arm, start.translation[0] + 0.01)
    state = push(arm, ImpedanceController(arm, SPRINGS, HOME[arm.name]), reference, wrench)
    error = pose_error(state, reference)
    force = -wrench(state)[0]
    assert force > 10.0
    assert force == pytest.approx(400.0 * error[0], rel=0.02)
    np.testing.assert_allclose(error[1:], 0.0, atol=2e-3)


def test_a_desired_force_adds_to_the_spring_and_can_change_every_period(arm):
    start = at_home(arm)
    reference = Reference(start.pose.moved([0.02, 0.0, 0.0]))
    wrench = wall(arm, start.translation[0] + 0.01)
    wanted = np.array([8.0, 0, 0, 0, 0, 0])
    for controller, options in (
        (ImpedanceController(arm, SPRINGS, HOME[arm.name]), {"desired_force": wanted}),
        (ImpedanceController(arm, Impedance([400.0] * 3 + [30.0] * 3, desired_force=wanted), HOME[arm.name]), {}),
    ):
        state = push(arm, controller, reference, wrench, **options)
        assert -wrench(state)[0] == pytest.approx(8.0 + 400.0 * pose_error(state, reference)[0], rel=0.02)


def test_an_axis_without_a_spring_presses_with_its_desired_force_at_any_wall_position(arm):
    impedance = Impedance(
        [0.0, 400.0, 400.0, 30.0, 30.0, 30.0], damping=[120.0, 0, 0, 0, 0, 0], desired_force=[10.0, 0, 0, 0, 0, 0]
    )
    start = at_home(arm)
    wrench = wall(arm, start.translation[0] + 0.01)
    state = push(arm, ImpedanceController(arm, impedance, HOME[arm.name]), Reference(start.pose), wrench, 3.0)
    assert -wrench(state)[0] == pytest.approx(10.0, rel=0.02)


def test_with_a_shaped_inertia_steady_contact_gives_the_force_of_the_spring_too(arm):
    impedance = Impedance([400.0] * 3 + [30.0] * 3, damping_ratio=1.5, inertia=[8.0, 8.0, 8.0, 0.5, 0.5, 0.5])
    start = at_home(arm)
    reference = Reference(start.pose.moved([0.03, 0.0, 0.0]))
    wrench = wall(arm, start.translation[0] + 0.01)
    state = push(arm, ImpedanceController(arm, impedance, HOME[arm.name]), reference, wrench, duration=2.0)
    assert -wrench(state)[0] == pytest.approx(400.0 * pose_error(state, reference)[0], rel=0.02)


PUSH = np.array([6.0, -4.0, 5.0, 0.3, 0.2, -0.4])


def response(arm, controller, seen, push=PUSH):
    """Return the tool's acceleration under a push; the controller sees `seen`, and the reference is at the tool."""
    state = at_home(arm)
    output = controller.step(Observation(0.0, state.q, state.v, seen), Reference(state.pose))
    assert output.active_limits == ()
    return state.J @ np.linalg.solve(state.M, output.command.torque - state.h + state.J.T @ push)


def weak(arm):
    return PostureTask(arm, weight=1e-9)


def test_without_a_shaped_inertia_a_push_accelerates_the_inertia_of_the_arm(arm):
    controller = ImpedanceController(arm, SPRINGS, weak(arm))
    state = at_home(arm)
    mobility = state.J @ np.linalg.inv(state.M) @ state.J.T
    np.testing.assert_allclose(response(arm, controller, PUSH), mobility @ PUSH, atol=1e-4)
    np.testing.assert_allclose(response(arm, controller, np.zeros(6)), mobility @ PUSH, atol=1e-4)


def test_with_a_shaped_inertia_a_push_accelerates_that_inertia(arm):
    inertia = np.array([20.0, 20.0, 5.0, 0.3, 0.3, 0.3])
    controller = ImpedanceController(arm, Impedance(SPRINGS.stiffness, inertia=inertia), weak(arm))
    np.testing.assert_allclose(response(arm, controller, PUSH), PUSH / inertia, atol=1e-4)


@pytest.mark.parametrize("share", [0.5, 0.999, 1.001, 3.0])
def test_only_the_part_of_a_push_beyond_the_dead_band_moves_the_tool(arm, share):
    """The part within the band is cancelled; otherwise it would accelerate the arm's own, smaller inertia."""
    inertia = np.array([20.0, 20.0, 5.0, 0.3, 0.3, 0.3])
    controller = ImpedanceController(
        arm, Impedance(SPRINGS.stiffness, inertia=inertia, dead_band=(2.5, 0.5)), weak(arm)
    )
    push = share * np.array([1.5, 0.0, 2.0, 0.3, 0.4, 0.0])
    expected = max(0.0, 1.0 - 1.0 / share) * push / inertia
    np.testing.assert_allclose(response(arm, controller, push, push), expected, atol=1e-4)


@pytest.mark.parametrize(("ratio", "overshoots"), [(0.3, True), (1.0, False)])
def test_the_damping_ratio_decides_whether_a_step_overshoots(arm, ratio, overshoots):
    controller = ImpedanceController(arm, Impedance(SPRINGS.stiffness, ratio), HOME[arm.name])
    start = at_home(arm)
    reference = Reference(start.pose.moved([0.0, 0.0, -0.03]))
    heights = [
        arm.update(q, v).translation[2] - start.translation[2]
        for _, q, v, _ in simulate(arm, lambda o: controller.step(o, reference).command.torque, HOME[arm.name], 1.0)
    ]
    assert (min(heights) < -0.033) == overshoots
    assert heights[-1] == pytest.approx(-0.03, abs=2e-3)


def test_the_friction_feed_forward_follows_the_reference_only():
    arm = load("wam7")
    state = at_home(arm)
    plain, compensated = (ImpedanceController(arm, SPRINGS, friction=on) for on in (False, True))
    observation = Observation(0.0, state.q, state.v)

    def extra(reference):
        return (
            compensated.step(observation, reference).command.torque - plain.step(observation, reference).command.torque
        )

    np.testing.assert_allclose(extra(Reference(state.pose.moved([0.05, 0.0, 0.0]))), 0.0, atol=1e-9)
    assert np.abs(extra(Reference(state.pose, np.array([0.1, 0, 0, 0, 0, 0])))).max() > 1.0


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"impedance": MotionGains(400.0)}, TypeError, "Impedance in N/m"),
        ({"solver": "gurobi"}, ConfigurationError, "gurobi"),
        ({"posture": np.zeros(5)}, ConfigurationError, "must be 7 finite numbers"),
    ],
)
def test_arguments_that_cannot_be_used_are_rejected(arguments, error, message):
    with pytest.raises(error, match=message):
        ImpedanceController(**{"arm": load("panda"), "impedance": SPRINGS, **arguments})


def test_forces_that_are_not_finite_are_rejected(arm):
    state = at_home(arm)
    shaped = ImpedanceController(arm, Impedance(100.0, inertia=5.0))
    reference, nan = Reference(state.pose), np.full(6, np.nan)
    with pytest.raises(ModelError, match="observed wrench"):
        shaped.step(Observation(0.0, state.q, state.v, nan), reference)
    with pytest.raises(ConfigurationError, match="desired_force"):
        shaped.step(Observation(0.0, state.q, state.v), reference, desired_force=np.zeros(3))
