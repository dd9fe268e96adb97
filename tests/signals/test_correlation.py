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


def test_is_free_of_scale_and_sees_an_offset():
    x = np.random.default_rng(1).standard_normal(1000)
    np.testing.assert_allclose(autocorrelation(-3.0 * x, 10), autocorrelation(x, 10), atol=1e-12)
    assert (autocorrelation(x + 1.0, 10) > 0.4).all()


def test_of_two_alternating_values():
    assert autocorrelation(np.array([1.0, -1.0] * 50), 1)[0] == pytest.approx(-0.99)


def test_zero_has_none_and_lags_beyond_the_record_are_zero():
    assert not autocorrelation(np.zeros(10), 3).any()
    assert not autocorrelation(np.array([1.0, 2.0]), 5)[1:].any()
