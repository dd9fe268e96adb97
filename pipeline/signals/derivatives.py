"""Derivatives of sampled signals."""

from __future__ import annotations

import numpy as np

from pipeline.errors import DataError


def central_difference(x: np.ndarray, rate: float) -> np.ndarray:
    """(x[k+1] − x[k−1])·rate/2 along axis 0, one-sided at the two ends; x (N,) or (N, m), `rate` in Hz.

    No phase error (Gautier & Poignet 2001, section 5.1). Raises DataError for fewer than 3 samples.
    """
    if len(x) < 3:
        raise DataError(f"central difference: {len(x)} samples, 3 are needed; record longer")
    return np.gradient(x, 1.0 / rate, axis=0)
