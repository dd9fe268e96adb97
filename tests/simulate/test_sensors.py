"""Noise: its size, its streams, its refusals."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.errors import ConfigError
from pipeline.simulate.sensors import draw_noise, no_noise

SIGMA = [1e-3, 2e-3], [1.0, 0.05]


@given(st.integers(0, 2**32 - 1), st.integers(1, 40), st.integers(0, 40))
@settings(max_examples=30, deadline=None)
def test_a_longer_run_begins_with_the_same_noise(seed, samples, more):
    short = draw_noise(np.random.default_rng(seed), samples, *SIGMA)
    long = draw_noise(np.random.default_rng(seed), samples + more, *SIGMA, loop="clean")
    np.testing.assert_array_equal(long.position[:samples], short.position)
    np.testing.assert_array_equal(long.input[:samples], short.input)


def test_noise_is_white_with_the_deviations_asked_for():
    noise = draw_noise(np.random.default_rng(4), 40_000, *SIGMA)
    both = np.hstack([noise.position, noise.input])
    np.testing.assert_allclose(both.std(axis=0), np.concatenate(SIGMA), rtol=0.02)
    correlation = np.corrcoef(np.hstack([both[1:], both[:-1]]).T) - np.eye(8)
    assert np.abs(correlation).max() < 0.025  # 5 standard deviations


def test_another_seed_gives_other_noise_and_none_gives_zeros():
    a, b = (draw_noise(np.random.default_rng(seed), 3, *SIGMA) for seed in (1, 2))
    assert not np.any(a.position == b.position)
    assert not np.any(no_noise(3, 2).position) and no_noise(3, 2).loop == "clean"


@pytest.mark.parametrize(
    ("sigma_q", "sigma_u", "loop"),
    [([1.0], [1.0], "open"), ([1.0], [1.0, 2.0], "clean"), ([-1.0], [1.0], "clean"), ([1.0], [-0.1], "disturbed")],
)
def test_senseless_noise_is_refused(sigma_q, sigma_u, loop):
    with pytest.raises(ConfigError, match="noise"):
        draw_noise(np.random.default_rng(0), 5, sigma_q, sigma_u, loop)
