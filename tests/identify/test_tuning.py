"""Noise levels derived from data against those that made the data."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.identify.tuning import force_noise, position_noise, quantum

RATE = 100.0
T = np.arange(3000) / RATE
MOTION = np.column_stack([np.sin(2 * np.pi * 0.5 * T), 0.5 * np.cos(2 * np.pi * 0.9 * T)])


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 1000), st.floats(1e-4, 1e-2))
def test_white_noise_is_found(seed, sigma):
    noisy = MOTION + sigma * np.random.default_rng(seed).normal(size=MOTION.shape)
    np.testing.assert_allclose(position_noise(noisy, RATE, 15.0), sigma, rtol=0.1)


def test_quantum_is_found_and_sets_the_floor():
    step = 2 * np.pi / 4096
    coarse = np.round(MOTION / step) * step
    np.testing.assert_allclose(quantum(coarse), step)
    assert np.all(position_noise(coarse, RATE, 15.0) >= 0.999 * step / np.sqrt(12))


def test_continuous_or_standing_signals_have_no_quantum():
    noisy = MOTION + np.random.default_rng(0).normal(size=MOTION.shape)
    assert np.all(quantum(noisy) == 0)
    assert np.all(quantum(np.zeros((10, 2))) == 0)


def test_force_noise_undoes_the_parallel_filter():
    np.testing.assert_allclose(force_noise(np.array([0.3]), 100.0, 4.0), 0.3 * np.sqrt(100 / 8))
    np.testing.assert_allclose(force_noise(np.array([0.3]), 100.0, 90.0), 0.3)
