"""Autocorrelation of a sampled series."""

from __future__ import annotations

import numpy as np


def autocorrelation(x: np.ndarray, lags: int) -> np.ndarray:
    """Normalised autocorrelation r[1 … lags] of x (N,) about zero: a mean of residuals or innovations is an error too.

    The biased estimate Σ x[k] x[k+l] / Σ x[k]², which is positive semidefinite; zeros for lags beyond N−1 and x = 0.
    """
    x = np.asarray(x, dtype=float)
    energy = x @ x
    r = np.zeros(lags)
    if energy == 0.0:
        return r
    for lag in range(1, min(lags, len(x) - 1) + 1):
        r[lag - 1] = x[:-lag] @ x[lag:] / energy
    return r
