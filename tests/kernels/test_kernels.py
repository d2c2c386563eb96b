"""Kernels: the friction law, the shortest turn, and linear algebra against numpy's."""

import numpy as np
import pinocchio as pin
import pytest

from arms import ARMS, load, random_states
from pilegrasp_ctrl.kernels import algebra, frame, program, wrist
from pilegrasp_ctrl.kernels.friction import coulomb_torque


def test_three_quarters_of_the_coulomb_friction_act_at_the_scale_and_all_of_it_beyond():
    v, coulomb, torque = np.array([0.0, 0.02, -0.02, 1.0]), np.array([2.0, 2.0, 4.0, 3.0]), np.empty(4)
    coulomb_torque(v, coulomb, 0.02, torque)
    np.testing.assert_allclose(torque, [0.0, 1.52, -3.05, 3.0], atol=0.01)


@pytest.mark.parametrize("distance", [0.0, 1e-12, 1e-9, 1e-6, 1e-3, 0.5])
def test_the_shortest_turn_keeps_its_digits_at_every_angle(distance):
    rng = np.random.default_rng(0)
    for angle in (distance, np.pi - distance):
        for _ in range(200):
            axis, start = rng.normal(size=3), pin.exp3(rng.normal(size=3))
            axis /= np.linalg.norm(axis)
            vector = np.empty(3)
            frame.rotation_vector(pin.exp3(angle * axis) @ start, start, vector)
            # Half a turn has no sense.
            gap = min(np.linalg.norm(vector - angle * axis), np.linalg.norm(vector + angle * axis))
            assert (gap if angle > 3.1415 else np.linalg.norm(vector - angle * axis)) < 1e-14


@pytest.mark.parametrize("name", ARMS)
def test_linear_algebra_agrees_with_numpy(name):
    arm = load(name)
    for q, v in random_states(arm, 10):
        state = arm.update(q, v)
        factor, x = np.empty((7, 7)), state.h.copy()
        assert algebra.cholesky(state.M, factor)
        algebra.solve_factored(factor, x)
        np.testing.assert_allclose(x, np.linalg.solve(state.M, state.h), rtol=1e-9)
        columns, shown = np.empty((7, 6)), np.empty((6, 6))
        algebra.mobility(factor, state.J, columns, shown)
        np.testing.assert_allclose(shown, state.J @ np.linalg.solve(state.M, state.J.T), atol=1e-9)
        H, f = np.zeros((7, 7)), np.zeros(7)
        algebra.add_normal_equations(state.J, state.twist, H, f)
        np.testing.assert_allclose(H, state.J.T @ state.J, atol=1e-12)
        np.testing.assert_allclose(f, -state.J.T @ state.twist, atol=1e-12)
    assert not algebra.cholesky(-np.eye(7), factor)
    assert not algebra.cholesky(np.full((7, 7), np.nan), factor)


@pytest.mark.parametrize("place", range(6))
def test_the_distance_to_the_bounds_is_the_smallest_one_or_not_a_number_if_one_is_not(place):
    bounds = np.array([[-1.0, -2.0, -3.0], [5.0, 0.5, 4.0]])
    x, G, slack = np.array([1.0, -1.5]), np.array([[2.0, 1.0]]), np.empty((2, 3))
    assert program.smallest_margin(x, G, *bounds) == 0.5
    assert program.write_slack(x, G, *bounds, slack) == 0.5
    np.testing.assert_array_equal(slack, [[2.0, 0.5, 3.5], [4.0, 2.0, 3.5]])
    assert program.nearest_bound(*bounds) == -0.5
    bounds.flat[place] = np.nan
    assert np.isnan(program.smallest_margin(x, G, *bounds))
    assert np.isnan(program.write_slack(x, G, *bounds, slack))
    assert np.isnan(program.nearest_bound(*bounds))


def test_the_inverse_is_numpy_s_and_a_singular_matrix_is_noticed():
    rng = np.random.default_rng(0)
    for size in (1, 2, 3, 7):
        for _ in range(20):
            A, inverse = rng.normal(size=(size, size)), np.empty((size, size))
            assert algebra.invert(A, inverse)
            np.testing.assert_allclose(inverse, np.linalg.inv(A), rtol=1e-9, atol=1e-9)
    swap, inverse = np.array([[0.0, 1.0], [1.0, 0.0]]), np.empty((2, 2))
    assert algebra.invert(swap, inverse)
    np.testing.assert_array_equal(inverse, swap)
    assert not algebra.invert(np.ones((2, 2)), inverse)


def test_a_reading_is_rounded_to_whole_steps_within_the_range_and_names_the_first_channel_at_its_end():
    readings = np.array([0.4, -2.5, 3.5, -7.6, 1e9, -3.0])
    limit, steps = np.array([5.0, 5.0, 5.0, 7.0, 9.0, 3.0]), np.empty(6)
    assert wrist.whole_steps(2.0 * readings, 2.0, np.eye(6), np.zeros(6), limit, steps) == 3
    np.testing.assert_array_equal(steps, [0.0, -2.0, 4.0, -7.0, 9.0, -3.0])
    assert wrist.whole_steps(np.zeros(6), 1.0, np.eye(6), readings, np.full(6, 2e9), steps) == -1
    np.testing.assert_array_equal(steps, np.rint(readings))
    readings[2] = np.nan
    assert wrist.whole_steps(readings, 1.0, np.eye(6), np.zeros(6), np.full(6, 2e9), steps) == -1
    assert np.isnan(steps).all()  # a product with what is not a number is not one either


def test_the_forces_of_a_primitive_are_changes_since_its_start():
    start, wrench = np.array([1.0, 2.0, 3.0, 9.0, 9.0, 9.0]), np.array([4.0, 6.0, 3.0, 0.0, 0.0, 0.0])
    assert wrist.change_size(wrench, start) == 5.0
    assert wrist.change_along(wrench, start, np.array([0.0, -1.0, 0.0])) == -4.0
