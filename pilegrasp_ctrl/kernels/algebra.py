"""Linear algebra for the few numbers of an arm; sums run in the order of the indices."""

# mypy: allow-untyped-defs

from __future__ import annotations

from math import sqrt

import numpy as np

from .compile import FLAG, MATRIX, NOTHING, NUMBER, OUT_MATRIX, OUT_VECTOR, VECTOR, kernel


@kernel(NOTHING, MATRIX, VECTOR, OUT_VECTOR)
def multiply(A, x, y):
    """Fill y = A x."""
    for i in range(A.shape[0]):
        total = 0.0
        for j in range(A.shape[1]):
            total += A[i, j] * x[j]
        y[i] = total


@kernel(NOTHING, MATRIX, VECTOR, OUT_VECTOR)
def multiply_transposed(A, x, y):
    """Fill y = Aᵀ x."""
    for j in range(A.shape[1]):
        total = 0.0
        for i in range(A.shape[0]):
            total += A[i, j] * x[i]
        y[j] = total


@kernel(NOTHING, MATRIX, MATRIX, OUT_MATRIX)
def product(A, B, C):
    """Fill C = A B."""
    for i in range(A.shape[0]):
        for j in range(B.shape[1]):
            total = 0.0
            for k in range(A.shape[1]):
                total += A[i, k] * B[k, j]
            C[i, j] = total


@kernel(NOTHING, MATRIX, VECTOR, OUT_MATRIX, OUT_VECTOR)
def add_normal_equations(A, b, H, f):
    """Add Aᵀ A to H and -Aᵀ b to f, so that ½ xᵀ H x + fᵀ x grows by ½ |A x - b|², up to a constant."""
    n = A.shape[1]
    for i in range(n):
        for j in range(i + 1):
            total = H[i, j]
            for k in range(A.shape[0]):
                total += A[k, i] * A[k, j]
            H[i, j] = total
            H[j, i] = total
        total = f[i]
        for k in range(A.shape[0]):
            total -= A[k, i] * b[k]
        f[i] = total


@kernel(NOTHING, MATRIX, VECTOR, OUT_VECTOR)
def add_multiplied_transposed(A, x, y):
    """Add Aᵀ x to y."""
    for j in range(A.shape[1]):
        total = y[j]
        for i in range(A.shape[0]):
            total += A[i, j] * x[i]
        y[j] = total


@kernel(FLAG, MATRIX, OUT_MATRIX)
def cholesky(H, L):
    """Fill the lower triangle of L with the factor of H = L Lᵀ; return False if H is not positive definite."""
    for j in range(H.shape[0]):
        for i in range(j, H.shape[0]):
            total = H[i, j]
            for k in range(j):
                total -= L[i, k] * L[j, k]
            if i == j:
                if not total > 0.0:
                    return False
                L[j, j] = sqrt(total)
            else:
                L[i, j] = total / L[j, j]
    return True


@kernel(NOTHING, MATRIX, OUT_VECTOR)
def solve_factored(L, x):
    """Replace x by (L Lᵀ)⁻¹ x."""
    n = x.shape[0]
    for i in range(n):
        for k in range(i):
            x[i] -= L[i, k] * x[k]
        x[i] /= L[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            x[i] -= L[k, i] * x[k]
        x[i] /= L[i, i]


@kernel(NOTHING, MATRIX, OUT_MATRIX)
def solve_factored_columns(L, X):
    """Replace each column of X by (L Lᵀ)⁻¹ times it."""
    for column in range(X.shape[1]):
        for i in range(X.shape[0]):
            for k in range(i):
                X[i, column] -= L[i, k] * X[k, column]
            X[i, column] /= L[i, i]
        for i in range(X.shape[0] - 1, -1, -1):
            for k in range(i + 1, X.shape[0]):
                X[i, column] -= L[k, i] * X[k, column]
            X[i, column] /= L[i, i]


@kernel(NOTHING, MATRIX, NUMBER, OUT_MATRIX)
def gram_of_rows(J, shift, gram):
    """Fill J Jᵀ + shift 1."""
    for i in range(J.shape[0]):
        for j in range(i + 1):
            total = shift if i == j else 0.0
            for k in range(J.shape[1]):
                total += J[i, k] * J[j, k]
            gram[i, j] = total
            gram[j, i] = total


@kernel(NOTHING, MATRIX, MATRIX, OUT_MATRIX, OUT_MATRIX)
def mobility(L, J, X, out):
    """Fill X = M⁻¹ Jᵀ and J M⁻¹ Jᵀ, the mobility of the rows J, for M = L Lᵀ."""
    for i in range(J.shape[0]):
        for j in range(J.shape[1]):
            X[j, i] = J[i, j]
    solve_factored_columns(L, X)
    for i in range(J.shape[0]):
        for j in range(i + 1):
            total = 0.0
            for k in range(J.shape[1]):
                total += J[i, k] * X[k, j]
            out[i, j] = total
            out[j, i] = total


@kernel(NUMBER, VECTOR)
def length_square(x):
    """Return |x|²."""
    total = 0.0
    for i in range(x.shape[0]):
        total += x[i] * x[i]
    return total


@kernel(FLAG, MATRIX, OUT_MATRIX)
def invert(A, inverse):
    """Fill the inverse of A by Gauss-Jordan elimination with row exchanges; return False if A is singular."""
    n = A.shape[0]
    rest = np.empty((n, n))
    for i in range(n):
        for j in range(n):
            rest[i, j] = A[i, j]
            inverse[i, j] = 1.0 if i == j else 0.0
    for j in range(n):
        best = j
        for i in range(j + 1, n):
            if abs(rest[i, j]) > abs(rest[best, j]):
                best = i
        pivot = rest[best, j]
        if not abs(pivot) > 0.0:
            return False
        for k in range(n):
            rest[best, k], rest[j, k] = rest[j, k], rest[best, k] / pivot
            inverse[best, k], inverse[j, k] = inverse[j, k], inverse[best, k] / pivot
        for i in range(n):
            factor = rest[i, j]
            if i != j and factor != 0.0:
                for k in range(n):
                    rest[i, k] -= factor * rest[j, k]
                    inverse[i, k] -= factor * inverse[j, k]
    return True


@kernel(NUMBER, VECTOR, VECTOR)
def distance(x, y):
    """Return |x - y|."""
    total = 0.0
    for i in range(x.shape[0]):
        total += (x[i] - y[i]) * (x[i] - y[i])
    return sqrt(total)
