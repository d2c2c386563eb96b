"""Inverse dynamics at its limits: active limits are named, and there is always a torque within them."""

import numpy as np
import pytest

from arms import ARMS, HOME, load, nearby, quiet_states, random_states, without_friction
from pilegrasp_ctrl.control.operational_space import OperationalSpaceController
from pilegrasp_ctrl.types import Observation, Reference


@pytest.fixture(params=ARMS)
def arm(request):
    return load(request.param)


def test_under_saturation_the_heavier_axes_keep_their_acceleration(arm):
    q, v = HOME[arm.name], np.zeros(7)
    state = arm.update(q, v)
    wanted = np.array([6.0, 6.0, 3.0, 200.0, -200.0, 200.0])
    weak = without_friction(arm.name, torque_limit=np.abs(state.h) + 0.1 * arm.torque_limit)

    def residuals(weight):
        controller = OperationalSpaceController(weak, weight=weight, limits=["torque"], friction=False)
        output = controller.step(Observation(0.0, q, v), Reference(state.pose, acceleration=wanted))
        assert output.active_limits
        residual = state.J @ output.acceleration - wanted
        return np.linalg.norm(residual[:3]), np.linalg.norm(residual[3:])

    linear_first, angular_first = residuals([1e4] * 3 + [1.0] * 3), residuals([1.0] * 3 + [1e4] * 3)
    assert linear_first[0] < 0.5 * angular_first[0]
    assert angular_first[1] < 0.5 * linear_first[1]


def test_active_limits_are_named_by_joint_and_side(arm):
    q, v = HOME[arm.name], np.zeros(7)
    state = arm.update(q, v)
    up = Reference(state.pose, acceleration=np.array([0.0, 0.0, 30.0, 0.0, 0.0, 0.0]))
    free = OperationalSpaceController(without_friction(arm.name), friction=False).step(Observation(0.0, q, v), up)
    assert free.active_limits == ()
    joint = int(np.argmax(np.abs(free.command.torque - state.h)))
    push = free.command.torque[joint] - state.h[joint]
    limit = arm.torque_limit.copy()
    limit[joint] = np.abs(state.h[joint] + 0.5 * push)
    bound = OperationalSpaceController(without_friction(arm.name, torque_limit=limit), friction=False).step(
        Observation(0.0, q, v), up
    )
    side = "upper" if state.h[joint] + 0.5 * push > 0.0 else "lower"
    assert f"torque[{joint}] {side}" in bound.active_limits
    assert abs(bound.command.torque[joint]) == pytest.approx(limit[joint], abs=1e-9)

    speed = arm.velocity_limit.copy()
    fast = v.copy()
    fast[joint] = 0.99 * speed[joint] * np.sign(free.acceleration[joint])
    running = Reference(state.pose, state.J @ fast, up.acceleration)
    output = OperationalSpaceController(without_friction(arm.name), friction=False).step(
        Observation(0.0, q, fast), running
    )
    side = "upper" if fast[joint] > 0.0 else "lower"
    assert f"velocity[{joint}] {side}" in output.active_limits

    near = arm.q_upper.copy() if free.acceleration[joint] > 0.0 else arm.q_lower.copy()
    near[joint] = q[joint] + 0.002 * np.sign(free.acceleration[joint])
    key, side = ("q_upper", "upper") if free.acceleration[joint] > 0.0 else ("q_lower", "lower")
    output = OperationalSpaceController(without_friction(arm.name, **{key: near}), friction=False).step(
        Observation(0.0, q, v), up
    )
    assert f"position[{joint}] {side}" in output.active_limits


@pytest.mark.parametrize("solver", ["daqp", "osqp"])
@pytest.mark.parametrize("name", ARMS)
def test_there_is_always_a_torque_within_the_limits(name, solver):
    """The drives are weak, and the joints far out of range and fast; most states have contradictory bounds."""
    strong = load(name)
    arm = without_friction(name, torque_limit=0.3 * strong.torque_limit, velocity_limit=0.4 * strong.velocity_limit)
    controller = OperationalSpaceController(arm, solver=solver)
    rng = np.random.default_rng(0)
    fallbacks = 0
    for _ in range(30):
        q = arm.q_lower + (arm.q_upper - arm.q_lower) * rng.uniform(-0.1, 1.1, 7)
        v = rng.normal(scale=2.0, size=7)
        pose = arm.update(q + rng.normal(scale=0.3, size=7), v).pose
        output = controller.step(Observation(0.0, q, v), Reference(pose))
        assert np.isfinite(output.command.torque).all()
        assert np.isfinite(output.acceleration).all()
        assert (np.abs(output.command.torque) <= arm.torque_limit).all()
        fallbacks += output.fallback != ""
    assert fallbacks <= (0 if solver == "daqp" else 3)


@pytest.mark.parametrize("speed", [1e3, 1e50, 1e100])
def test_an_absurd_speed_gives_a_finite_torque(arm, speed):
    controller = OperationalSpaceController(arm)
    q = HOME[arm.name]
    output = controller.step(Observation(0.0, q, np.full(7, speed)), Reference(arm.update(q, np.zeros(7)).pose))
    assert np.isfinite(output.command.torque).all()
    assert (np.abs(output.command.torque) <= arm.torque_limit).all()


class SilentSolver:
    """A solver that never finds a solution."""

    name = "silent"

    def solve(self, problem):
        return None


def test_if_the_solver_fails_gravity_is_held_and_motion_damped(arm):
    controller = OperationalSpaceController(arm, solver=SilentSolver())
    q, v = next(quiet_states(arm, 1))
    still = controller.step(Observation(0.0, q, 0.0 * v), nearby(arm.update(q, v)))
    np.testing.assert_allclose(still.command.torque, arm.update(q, 0.0 * v).h)
    np.testing.assert_allclose(still.acceleration, 0.0, atol=1e-9)
    assert "silent found no accelerations" in still.fallback
    moving = controller.step(Observation(0.0, q, v), nearby(arm.update(q, v)))
    assert v @ (moving.command.torque - arm.update(q, v).h) < 0.0
    wild = controller.step(Observation(0.0, q, 100.0 * np.ones(7)), nearby(arm.update(q, v)))
    assert (np.abs(wild.command.torque) <= arm.torque_limit).all()
    assert all(name.startswith(("torque[", "motor[")) for name in wild.active_limits)
    assert wild.active_limits


def test_solvers_agree_with_and_without_active_limits(arm):
    home = HOME[arm.name]
    exact, splitting = (OperationalSpaceController(arm, posture=home, solver=name) for name in ("daqp", "osqp"))
    active = 0
    for q, v in random_states(arm, 40, seed=2):
        reference = nearby(arm.update(0.9 * q + 0.1 * home, v))
        one, other = (controller.step(Observation(0.0, q, v), reference) for controller in (exact, splitting))
        np.testing.assert_allclose(one.command.torque, other.command.torque, atol=1e-5)
        active += bool(one.active_limits)
    assert active > 0
