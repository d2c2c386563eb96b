"""The spectral radius, against LAPACK's eigenvalues."""

import numpy as np
import pytest

from pilegrasp_ctrl.kernels.spectrum import spectral_radius

plain = getattr(spectral_radius, "py_func", spectral_radius)


def test_the_spectral_radius_is_the_largest_absolute_eigenvalue():
    rng = np.random.default_rng(0)
    for _ in range(500):
        n = rng.integers(1, 15)
        A = rng.standard_normal((n, n)) * 10.0 ** rng.uniform(-3.0, 3.0)
        np.testing.assert_allclose(spectral_radius(A), np.abs(np.linalg.eigvals(A)).max(), rtol=1e-10)


def test_compiled_and_plain_spectral_radius_are_equal_to_the_bit():
    rng = np.random.default_rng(1)
    for A in rng.standard_normal((5, 6, 6)):
        assert spectral_radius(A) == plain(A)


@pytest.mark.parametrize("matrix", [[[1.0, 0.002], [0.0, 1.0]], [[0.0, -1.0], [1.0, 0.0]], np.eye(12)])
def test_a_motion_that_neither_grows_nor_decays_has_the_spectral_radius_1(matrix):
    assert abs(spectral_radius(np.array(matrix)) - 1.0) < 1e-12


def test_a_matrix_without_eigenvalues_but_zero_and_one_with_entries_that_are_not_finite():
    assert spectral_radius(np.zeros((3, 3))) == spectral_radius(np.array([[0.0, 1.0], [0.0, 0.0]])) == 0.0
    for value in (np.nan, np.inf):
        assert spectral_radius(np.array([[0.5, value], [0.0, 0.5]])) == np.inf
