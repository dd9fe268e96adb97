"""Noise: its size, its streams, its refusals."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.errors import ConfigError
from pipeline.simulate.sensors import draw_noise, no_noise, position_variance, quantised

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


steps = st.floats(1e-6, 1.0)


@given(st.lists(st.floats(-1e3, 1e3), min_size=2, max_size=20), steps)
def test_a_quantised_position_is_a_multiple_of_the_step_and_half_a_step_off_at_most(values, step):
    q = np.array(values)[:, None] * [1.0, 1.0]
    seen = quantised(q, np.array([step, 0.0]))
    np.testing.assert_allclose(seen[:, 0] / step, np.round(seen[:, 0] / step), atol=1e-6)
    assert np.abs(seen[:, 0] - q[:, 0]).max() <= 0.5 * step * (1 + 1e-9) + 1e-12
    np.testing.assert_array_equal(seen[:, 1], q[:, 1])
    assert quantised(q, None) is q


def test_the_error_of_an_encoder_is_uniform_over_its_step():
    """Under a motion of many steps: variance step²/12, kurtosis 1.8 (a normal error has 3)."""
    step, q = 2 * np.pi / 16384, np.random.default_rng(1).uniform(-3, 3, (200_000, 1))
    error = (quantised(q, np.array([step])) - q).ravel()
    assert error.std() == pytest.approx(step / np.sqrt(12), rel=0.01)
    assert np.mean(error**4) / error.var() ** 2 == pytest.approx(1.8, rel=0.01)
    assert np.abs(error).max() <= 0.5 * step * (1 + 1e-9) and abs(error.mean()) < 0.01 * step


def test_the_variance_of_a_measured_position_is_of_noise_and_step():
    noise = draw_noise(np.random.default_rng(3), 100_000, [1e-3, 1e-3], [0.0, 0.0], quantum_q=[2e-3, 0.0])
    q = np.random.default_rng(4).uniform(-1, 1, (100_000, 2))
    error = np.array([noise.measured(row, k) for k, row in enumerate(q)]) - q
    np.testing.assert_allclose(error.var(axis=0), position_variance([1e-3, 1e-3], [2e-3, 0.0]), rtol=0.02)
    np.testing.assert_allclose(position_variance([1e-3]), 1e-6)


def test_noise_without_steps_is_what_it_was():
    assert draw_noise(np.random.default_rng(0), 5, *SIGMA, quantum_q=[0.0, 0.0]).quantum is None


@pytest.mark.parametrize("quantum", [[1e-3], [1e-3, -1e-3], [[1e-3, 1e-3]]])
def test_senseless_steps_are_refused(quantum):
    with pytest.raises(ConfigError, match="quantum_q"):
        draw_noise(np.random.default_rng(0), 5, *SIGMA, quantum_q=quantum)
