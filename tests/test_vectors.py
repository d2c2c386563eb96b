"""Products and lengths without BLAS: the values of numpy's, with the sums in the order of the indices."""

import numpy as np
import pytest

from pilegrasp_ctrl.exceptions import ArgumentError
from pilegrasp_ctrl.planning.strategy import tool_rotation
from pilegrasp_ctrl.types import MassProperties, Pose
from pilegrasp_ctrl.vectors import components, in_order, inner, norm, product, rotated


def random(*shape):
    return np.random.default_rng(0).normal(size=shape)


def test_products_are_those_of_numpy():
    R, x, many = random(3, 3), random(3), random(5, 4, 3)
    np.testing.assert_allclose(rotated(R, x), R @ x, rtol=1e-14)
    np.testing.assert_allclose(rotated(R, many), many @ R.T, rtol=1e-14)
    np.testing.assert_allclose(rotated(many.reshape(5, 4, 3), x), many @ x, rtol=1e-14)
    np.testing.assert_allclose(components(many, x), many @ x, rtol=1e-14)
    np.testing.assert_allclose(product(R[:2], R), R[:2] @ R, rtol=1e-14)
    np.testing.assert_allclose(product(random(5, 2, 3), R), random(5, 2, 3) @ R, rtol=1e-14)
    assert inner(x, R[0]) == pytest.approx(x @ R[0])
    assert norm(x) == pytest.approx(np.linalg.norm(x))
    assert type(inner([1, 2], [3, 4])) is type(norm([3, 4])) is float


def test_each_matrix_turns_its_own_vector():
    turns, vectors = random(6, 3, 3), random(6, 3)
    expected = [turn @ vector for turn, vector in zip(turns, vectors, strict=True)]
    np.testing.assert_allclose(rotated(turns, vectors), expected, rtol=1e-14)


def test_sums_run_in_the_order_of_the_indices():
    # A compensated sum, as the builtin one since Python 3.12, would be 2.
    assert in_order([1e16, 1.0, 1.0, -1e16]) == 0.0
    assert in_order([]) == 0.0
    assert inner([1e16, 1.0, 1.0, -1e16], np.ones(4)) == 0.0
    assert rotated([[1e16, 1.0, -1e16]], np.ones(3)) == product([[1e16, 1.0, -1e16]], np.ones((3, 1))) == 0.0


def test_poses_compose_and_invert_like_homogeneous_matrices():
    def matrix(pose):
        return np.block([[pose.rotation, pose.translation[:, None]], [np.zeros((1, 3)), np.ones((1, 1))]])

    first, second = Pose(random(3), tool_rotation(0.4, -0.3)), Pose(-random(3), tool_rotation(-1.1, 2.0))
    np.testing.assert_allclose(matrix(first @ second), matrix(first) @ matrix(second), atol=1e-14)
    np.testing.assert_allclose(matrix(first.inverse()), np.linalg.inv(matrix(first)), atol=1e-14)


@pytest.mark.parametrize("least", [-1e-3, -1e-9, -1e-11, 0.0, 1e-15, 1e-3])
@pytest.mark.parametrize("others", [(0.0, 0.0), (1.0, 1.0), (10.0, 1e-6)])
def test_an_inertia_is_refused_where_an_eigenvalue_is_negative_beyond_rounding(least, others):
    rng = np.random.default_rng(1)
    for _ in range(20):
        axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        inertia = axes @ np.diag([least, *others]) @ axes.T
        inertia = 0.5 * (inertia + inertia.T)
        if least < 0.0:
            with pytest.raises(ArgumentError, match="not symmetric positive"):
                MassProperties(1.0, np.zeros(3), inertia)
        else:
            MassProperties(1.0, np.zeros(3), inertia)
