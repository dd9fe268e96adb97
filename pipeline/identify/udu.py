"""P = U diag(d) Uᵀ with U unit upper triangular: the Bierman–Thornton forms, which keep P positive definite.

(Bierman, Factorization Methods for Discrete Sequential Estimation, 1977, chapters III, V and VI.) All arrays may be
float32 or float64; the results have the dtype of U.
"""

from __future__ import annotations

import numpy as np


def factor(P: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """U (nx, nx) and d (nx,) of a symmetric positive semi-definite P (nx, nx). LinAlgError where it is not."""
    P = P.copy()
    n = len(P)
    U, d = np.eye(n, dtype=P.dtype), np.zeros(n, dtype=P.dtype)
    for j in range(n - 1, -1, -1):
        d[j] = P[j, j]
        if d[j] < 0:
            raise np.linalg.LinAlgError(f"P is not positive semi-definite: pivot {j} is {d[j]:.3g}")
        if d[j] > 0:
            U[:j, j] = P[:j, j] / d[j]
            P[:j, :j] -= d[j] * np.outer(U[:j, j], U[:j, j])
    return U, d


def predict(U: np.ndarray, d: np.ndarray, F: np.ndarray, G: np.ndarray, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The factors of F P Fᵀ + G diag(q) Gᵀ by Thornton's modified weighted Gram–Schmidt.

    U (nx, nx), d (nx,), F (nx, nx), G (nx, nq), q (nq,) ≥ 0.
    """
    W = np.concatenate([F @ U, G], axis=1)
    weight = np.concatenate([d, q])
    n = len(d)
    U_new, d_new = np.eye(n, dtype=U.dtype), np.zeros_like(d)
    for j in range(n - 1, -1, -1):
        row = W[j]
        weighted = weight * row
        d_new[j] = row @ weighted
        if j and d_new[j] > 0:
            U_new[:j, j] = (W[:j] @ weighted) / d_new[j]
            W[:j] -= np.outer(U_new[:j, j], row)
    return U_new, d_new


def update(U: np.ndarray, d: np.ndarray, h: np.ndarray, r: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Bierman's update by one scalar measurement y = h x + v, var(v) = r > 0: the new U, d and the gain K (nx,)."""
    f = U.T @ h
    v = d * f
    # alpha[j] = r + sum over i ≤ j of f_i v_i: the variance of the innovation as the columns come in
    alpha = r + np.cumsum(f * v)
    before = np.concatenate([np.array([r], dtype=U.dtype), alpha[:-1]])
    d_new = d * before / alpha
    # b[:, j] is the unscaled gain after the columns 0 … j−1: the running sum of v_i U[:, i]
    b = np.cumsum(U * v, axis=1)
    U_new = U.copy()
    U_new[:, 1:] -= b[:, :-1] * (f[1:] / before[1:])
    return U_new, d_new, b[:, -1] / alpha[-1]


def covariance(U: np.ndarray, d: np.ndarray) -> np.ndarray:
    """P (nx, nx) from its factors."""
    return (U * d) @ U.T
