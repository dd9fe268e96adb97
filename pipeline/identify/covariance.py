"""Covariance of a least-squares estimate: the formal one, and one that stays honest when the residual is coloured."""

from __future__ import annotations

import numpy as np
from scipy import linalg

LAG_SECONDS = 0.4
"""Newey–West lag: longer than the memory of a 4 Hz filter run both ways."""


def formal(R: np.ndarray) -> np.ndarray:
    """(W_wᵀ W_w)⁻¹ (p, p) from the triangular factor R of W_w: right where the weighted residual is white."""
    inverse = linalg.solve_triangular(R, np.eye(len(R)))
    return inverse @ inverse.T


def newey_west(
    W_w: np.ndarray, rho_w: np.ndarray, time: np.ndarray, R: np.ndarray, lag: float = LAG_SECONDS
) -> np.ndarray:
    """Sandwich (W_wᵀW_w)⁻¹ S (W_wᵀW_w)⁻¹ with Bartlett weights up to `lag` [s] (Newey & West 1987).

    W_w (r, p), rho_w (r,) weighted rows and residuals, time (r,) s: rows of one instant are summed before they are
    correlated over time, so the joints may be correlated with each other as well.
    """
    instants, row_instant = np.unique(time, return_inverse=True)
    scores = np.zeros((len(instants), W_w.shape[1]))
    np.add.at(scores, row_instant, W_w * rho_w[:, None])
    step = np.median(np.diff(instants)) if len(instants) > 1 else 1.0
    lags = min(int(round(lag / step)), len(instants) - 1)
    S = scores.T @ scores
    for k in range(1, lags + 1):
        gamma = scores[k:].T @ scores[:-k]
        S += (1.0 - k / (lags + 1.0)) * (gamma + gamma.T)
    # bread = R⁻¹ R⁻ᵀ: two triangular solves instead of an inverse of normal equations
    half = linalg.solve_triangular(R, linalg.solve_triangular(R, S, trans="T"))
    return linalg.solve_triangular(R, linalg.solve_triangular(R, half.T, trans="T"))
