"""The values that cross the borders between rooms."""

import numpy as np
from scipy.spatial.transform import Rotation

from pilegrasp_ctrl.types import rotation_matrices


def test_quaternions_of_any_number_become_rotation_matrices():
    turns = Rotation.random(12, random_state=np.random.default_rng(1))
    quaternions = turns.as_quat(scalar_first=True)
    np.testing.assert_allclose(rotation_matrices(quaternions), turns.as_matrix(), atol=1e-14)
    np.testing.assert_array_equal(
        rotation_matrices(quaternions.reshape(3, 4, 4)), rotation_matrices(quaternions).reshape(3, 4, 3, 3)
    )
    np.testing.assert_array_equal(rotation_matrices((1, 0, 0, 0)), np.eye(3))
