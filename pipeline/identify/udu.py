"""P = U diag(d) Uᵀ with U unit upper triangular: the Bierman–Thornton forms, which keep P positive definite.

(Bierman, Factorization Methods for Discrete Sequential Estimation, 1977, chapters III, V and VI.) All arrays may be
float32 or float64; the results have the dtype of U.
"""

from __future__ import annotations

import numpy as np

from pipeline.in_order import product, total


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
    """The factors after a step by F (ns, nx), the upper rows of [A B; 0 I], with noise G diag(q) Gᵀ on these states.

    U (nx, nx), d (nx,), G (ns, nq), q (nq,) ≥ 0. F U = [A Us, A Usp + B Up]: the columns of the parameters are those
    of the new U as they are; the others, beside G, are made orthogonal by Thornton's modified weighted Gram–Schmidt.
    """
    ns = len(F)
    T = product(F, U)
    U_new, d_new = U.copy(), d.copy()
    U_new[:ns, ns:] = T[:, ns:]
    W, weight = np.concatenate([T[:, :ns], G], axis=1), np.concatenate([d[:ns], q])
    for j in range(ns - 1, -1, -1):
        row = W[j]
        weighted = weight * row
        d_new[j] = total(row * weighted)
        U_new[:j, j] = 0.0
        if j and d_new[j] > 0:
            U_new[:j, j] = total(W[:j] * weighted) / d_new[j]
            W[:j] -= np.outer(U_new[:j, j], row)
    return U_new, d_new


def update(U: np.ndarray, d: np.ndarray, h: np.ndarray, r: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Bierman's update by one scalar measurement y = h x + v, var(v) = r > 0: the new U, d and the gain K (nx,)."""
    f = U.T @ h
    v = d * f
    # alpha[j + 1] = r + sum over i ≤ j of f_i v_i: the variance of the innovation as the columns come in
    alpha = np.cumsum(np.concatenate([np.array([r], dtype=U.dtype), f * v]))
    before, after = alpha[:-1], alpha[1:]
    # b[:, j] is the unscaled gain after the columns 0 … j−1: the running sum of v_i U[:, i]
    b = np.cumsum(U * v, axis=1)
    U_new = U.copy()
    U_new[:, 1:] -= b[:, :-1] * (f[1:] / before[1:])
    return U_new, d * (before / after), b[:, -1] / after[-1]


def covariance(U: np.ndarray, d: np.ndarray) -> np.ndarray:
    """P (nx, nx) from its factors."""
    return (U * d) @ U.T


def variances(U: np.ndarray, d: np.ndarray) -> np.ndarray:
    """The diagonal (nx,) of P."""
    return total(U * U * d)
