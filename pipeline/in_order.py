"""Sums taken term by term, first to last, so that they have the same bits on every machine and in compiled code.

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
