"""Formal and Newey–West covariance: against the definition, and against the scatter over many draws."""

import numpy as np
import pytest

from pipeline.identify.covariance import formal, newey_west


def system(rng, N=400, p=2, phi=0.0):
    W = np.column_stack([np.ones(N), np.sin(np.arange(N) * 0.05)])[:, :p]
    e = rng.standard_normal(N + 100)
    for k in range(1, len(e)):
        e[k] += phi * e[k - 1]
    return W, e[100:]


def test_formal_is_the_inverse_of_the_information():
    rng = np.random.default_rng(0)
    W = rng.standard_normal((50, 4))
    np.testing.assert_allclose(formal(np.linalg.qr(W)[1]), np.linalg.inv(W.T @ W), rtol=1e-10)


def test_newey_west_without_lag_is_whites_sandwich():
    rng = np.random.default_rng(1)
    W, rho = rng.standard_normal((50, 3)), rng.standard_normal(50)
    bread = np.linalg.inv(W.T @ W)
    sandwich = bread @ (W.T * rho**2) @ W @ bread
    R = np.linalg.qr(W)[1]
    np.testing.assert_allclose(newey_west(W, rho, np.arange(50.0), R, lag=0.0), sandwich, rtol=1e-9)


def test_newey_west_sums_the_joints_of_an_instant():
    rng = np.random.default_rng(2)
    W, rho = rng.standard_normal((80, 3)), rng.standard_normal(80)
    R, time = np.linalg.qr(W)[1], np.tile(np.arange(40) * 0.1, 2)
    scores = (W * rho[:, None]).reshape(2, 40, 3).sum(axis=0)
    S = scores.T @ scores
    for k in (1, 2):
        gamma = scores[k:].T @ scores[:-k]
        S = S + (1 - k / 3) * (gamma + gamma.T)
    bread = np.linalg.inv(W.T @ W)
    np.testing.assert_allclose(newey_west(W, rho, time, R, lag=0.2), bread @ S @ bread, rtol=1e-8)


@pytest.mark.parametrize("phi", [0.0, 0.7])
def test_newey_west_matches_the_scatter_of_coloured_noise(phi):
    rng = np.random.default_rng(3)
    found, claimed, naive = [], [], []
    for _ in range(200):
        W, e = system(rng, phi=phi)
        R = np.linalg.qr(W)[1]
        theta = np.linalg.lstsq(W, e)[0]
        found.append(theta)
        claimed.append(np.sqrt(np.diag(newey_west(W, e - W @ theta, np.arange(len(e)) * 0.01, R, lag=0.2))))
        naive.append(np.sqrt(np.diag(formal(R)) * np.mean((e - W @ theta) ** 2)))
    scatter = np.std(found, axis=0)
    assert np.mean(claimed, axis=0) / scatter == pytest.approx([1, 1], abs=0.2)
    if phi:
        assert (np.mean(naive, axis=0) / scatter < 0.6).all()
