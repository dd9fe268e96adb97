"""Central differences against the derivatives of polynomials."""

import numpy as np
import pytest

from pipeline.errors import DataError
from pipeline.signals.derivatives import central_difference


def test_exact_for_a_parabola_inside_and_one_sided_at_the_ends():
    t = np.arange(50) / 100.0
    x = np.column_stack([3 * t**2 - t, 5 * t])
    qd = central_difference(x, 100.0)
    np.testing.assert_allclose(qd[1:-1], np.column_stack([6 * t - 1, np.full_like(t, 5.0)])[1:-1], atol=1e-12)
    np.testing.assert_allclose(qd[[0, -1]], (x[[1, -1]] - x[[0, -2]]) * 100.0, atol=1e-12)


def test_two_samples_are_too_few():
    with pytest.raises(DataError, match="2 samples"):
        central_difference(np.zeros(2), 100.0)
