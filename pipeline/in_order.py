"""Linear algebra term by term, first to last, so that it has the same bits on every machine and in compiled code.

A library's matrix product adds in an order of its own, and finite differences make of its rounding 1e-6 in an estimate.
"""

from __future__ import annotations

import numpy as np


def total(terms: np.ndarray) -> np.ndarray:
    """The sum over the last axis."""
    return np.cumsum(terms, axis=-1)[..., -1]


def product(A: np.ndarray, B: np.ndarray) -> np.ndarray:
    """A B (m, n) of A (m, k) and B (k, n)."""
    return total(A[:, None, :] * B.T[None, :, :])


def solve(A: np.ndarray, b: np.ndarray) -> np.ndarray:
    """x (N, n) of A x = b, A (N, n, n), b (N, n): elimination with row pivoting. LinAlgError where an A is singular."""
    A, x, n, every = A.copy(), b.copy(), b.shape[1], np.arange(len(b))
    for k in range(n):
        pivot = k + np.argmax(np.abs(A[:, k:, k]), axis=1)
        A[every, pivot], A[:, k] = A[:, k].copy(), A[every, pivot]
        x[every, pivot], x[:, k] = x[:, k].copy(), x[every, pivot]
        if not (np.abs(A[:, k, k]) > 0.0).all():
            raise np.linalg.LinAlgError("singular matrix")
        for i in range(k + 1, n):
            factor = A[:, i, k] / A[:, k, k]
            A[:, i, k + 1 :] -= factor[:, None] * A[:, k, k + 1 :]
            x[:, i] -= factor * x[:, k]
    for k in reversed(range(n)):
        for j in range(k + 1, n):
            x[:, k] -= A[:, k, j] * x[:, j]
        x[:, k] /= A[:, k, k]
    return x


def normalised(r: np.ndarray, S: np.ndarray) -> float | None:
    """rᵀ S⁻¹ r of r (n,) and S (n, n), by S = L D Lᵀ; None where S is not positive definite."""
    n, result = len(r), 0.0
    L, d, v = np.eye(n), np.empty(n), r.copy()
    for i in range(n):
        d[i] = S[i, i]
        for j in range(i):
            value = S[i, j]
            for k in range(j):
                value -= L[i, k] * d[k] * L[j, k]
            L[i, j] = value / d[j]
            d[i] -= L[i, j] * value
            v[i] -= L[i, j] * v[j]
        if not d[i] > 0.0:
            return None
        result += v[i] * v[i] / d[i]
    return float(result)
