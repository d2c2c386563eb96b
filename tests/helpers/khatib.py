"""Closed forms without limits, which the quadratic program must reproduce if no limit is active."""

from __future__ import annotations

import numpy as np

from pilegrasp_ctrl.arm.state import ArmState
from pilegrasp_ctrl.types import Array


def operational_space_torque(state: ArmState, acceleration: Array, posture_torque: Array) -> Array:
    """Return the joint torques (nv,) [N·m] of Khatib's operational-space formulation, IEEE J-RA 3(1), 1987.

        Lambda = (J M⁻¹ Jᵀ)⁻¹,   J̄ = M⁻¹ Jᵀ Lambda,   F = Lambda (acceleration - Jdot_v) + J̄ᵀ h
        torque = Jᵀ F + (I - Jᵀ J̄ᵀ) posture_torque

    The projector is dynamically consistent: the tool accelerates as wanted for every posture torque.

    Args:
        state: State of the arm, away from singular postures.
        acceleration: (6,) Wanted acceleration of the tool [m/s², rad/s²].
        posture_torque: (nv,) Torque that acts in the freedom that the tool leaves [N·m].
    """
    J, h = state.J, state.h
    M_inverse = np.linalg.inv(state.M)
    Lambda = np.linalg.inv(J @ M_inverse @ J.T)
    J_bar = M_inverse @ J.T @ Lambda
    F = Lambda @ (acceleration - state.Jdot_v) + J_bar.T @ h
    projector = np.eye(len(h)) - J.T @ J_bar.T
    return J.T @ F + projector @ posture_torque


def least_squares_torque(
    state: ArmState, acceleration: Array, posture_acceleration: Array, weight: Array, posture_weight: float
) -> Array:
    """Return the joint torques (nv,) [N·m] of the quadratic program's own cost, without its limits.

    The accelerations a minimise `|W^½ (J a + Jdot_v - acceleration)|² + w |a - posture_acceleration|²`. They are found
    by orthogonal factorisation of the rows.

    Args:
        state: State of the arm.
        acceleration: (6,) Wanted acceleration of the tool [m/s², rad/s²].
        posture_acceleration: (nv,) Wanted acceleration of the joints [rad/s²].
        weight: (6,) Diagonal of W.
        posture_weight: Weight w.
    """
    root, posture_root = np.sqrt(weight), np.sqrt(posture_weight)
    rows = np.vstack((root[:, None] * state.J, posture_root * np.eye(len(state.h))))
    target = np.concatenate((root * (acceleration - state.Jdot_v), posture_root * posture_acceleration))
    a = np.linalg.lstsq(rows, target, rcond=None)[0]
    return state.M @ a + state.h
