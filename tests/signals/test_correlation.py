"""Autocorrelation against numbers known in closed form."""

import numpy as np
import pytest

from pipeline.signals.correlation import autocorrelation


def test_of_an_ar1_series():
    rng = np.random.default_rng(0)
    e = rng.standard_normal(20000)
    x = np.empty_like(e)
    x[0] = e[0]
    for k in range(1, len(e)):
        x[k] = 0.7 * x[k - 1] + e[k]
    np.testing.assert_allclose(autocorrelation(x, 3), [0.7, 0.49, 0.343], atol=0.03)


def test_is_free_of_offset_and_scale():
    x = np.random.default_rng(1).standard_normal(100)
    np.testing.assert_allclose(autocorrelation(5.0 - 3.0 * x, 10), autocorrelation(x, 10), atol=1e-12)


def test_of_two_alternating_values():
    assert autocorrelation(np.array([1.0, -1.0] * 50), 1)[0] == pytest.approx(-0.99)


def test_a_constant_has_none_and_lags_beyond_the_record_are_zero():
    assert not autocorrelation(np.ones(10), 3).any()
    assert not autocorrelation(np.array([1.0, 2.0]), 5)[1:].any()
