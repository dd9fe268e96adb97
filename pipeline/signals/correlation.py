"""Autocorrelation of a sampled series."""

from __future__ import annotations

import numpy as np


def autocorrelation(x: np.ndarray, lags: int) -> np.ndarray:
    """Normalised autocorrelation r[1 … lags] of x (N,) about its mean; zeros for a constant series.

    The biased estimate Σ x[k] x[k+l] / Σ x[k]², which is positive semidefinite; lags beyond N−1 are zero.
    """
    x = np.asarray(x, dtype=float) - np.mean(x)
    energy = x @ x
    r = np.zeros(lags)
    if energy == 0.0:
        return r
    for lag in range(1, min(lags, len(x) - 1) + 1):
        r[lag - 1] = x[:-lag] @ x[lag:] / energy
    return r
