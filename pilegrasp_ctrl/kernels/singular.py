"""The part of a wanted acceleration that is taken away along directions that the arm is about to lose."""

# mypy: allow-untyped-defs

from __future__ import annotations

from .compile import MATRIX, NOTHING, NUMBER, OUT_VECTOR, VECTOR, kernel


@kernel(NOTHING, VECTOR, MATRIX, VECTOR, VECTOR, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, OUT_VECTOR)
def singular_loss(squares, U, missing, twist, threshold, rate, damping, free, weight, lost):
    """Fill the loss of acceleration, from the squared singular values and the directions u_i, columns of U.

    lambda_i² = max(1 - sigma_i² / threshold², 0)² max(|y_i| - free, 0) / rate²,      y_i = u_i · missing
    lost = Σ s_i (y_i + damping u_i · twist) u_i,      s_i = lambda_i² / (sigma_i² + weight + lambda_i²)
    """
    for k in range(lost.shape[0]):
        lost[k] = 0.0
    for i in range(squares.shape[0]):
        y, speed = 0.0, 0.0
        for k in range(missing.shape[0]):
            y += U[k, i] * missing[k]
            speed += U[k, i] * twist[k]
        square = max(squares[i], 0.0)
        depth = max(1.0 - squares[i] / (threshold * threshold), 0.0)
        damped = depth * depth * max(abs(y) - free, 0.0) / (rate * rate)
        share = damped / (square + weight + damped)
        for k in range(lost.shape[0]):
            lost[k] += share * (y + damping * speed) * U[k, i]
