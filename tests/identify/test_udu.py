"""Bierman–Thornton against the plain formulas, and where the plain formulas fail."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.identify import udu


def system(seed, nx=5, nq=2):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(nx, nx))
    return A @ A.T, rng.normal(size=(nx, nx)), rng.normal(size=(nx, nq)), rng.uniform(0.1, 2, nq), rng.normal(size=nx)


@given(st.integers(0, 10_000), st.integers(1, 12))
def test_factors_give_the_matrix_back(seed, nx):
    P = system(seed, nx)[0]
    U, d = udu.factor(P)
    assert np.all(d >= 0) and np.array_equal(U, np.triu(U)) and np.all(np.diag(U) == 1)
    np.testing.assert_allclose(udu.covariance(U, d), P, rtol=0, atol=1e-9 * np.abs(P).max())


@given(st.integers(0, 10_000), st.integers(1, 12), st.integers(1, 4))
def test_prediction_is_F_P_Ft_plus_Q(seed, nx, nq):
    P, F, G, q, _ = system(seed, nx, nq)
    U, d = udu.predict(*udu.factor(P), F, G, q)
    expected = F @ P @ F.T + (G * q) @ G.T
    np.testing.assert_allclose(udu.covariance(U, d), expected, rtol=0, atol=1e-9 * np.abs(expected).max())
    assert np.all(d >= 0)


@given(st.integers(0, 10_000), st.integers(1, 12), st.floats(1e-3, 1e3))
def test_update_is_the_kalman_update(seed, nx, r):
    P, *_, h = system(seed, nx)
    U, d, K = udu.update(*udu.factor(P), h, r)
    S = h @ P @ h + r
    np.testing.assert_allclose(K, P @ h / S, rtol=0, atol=1e-8 * np.abs(P).max())
    np.testing.assert_allclose(udu.covariance(U, d), P - np.outer(P @ h, P @ h) / S, atol=1e-8 * np.abs(P).max())


def test_indefinite_matrix_is_refused():
    with pytest.raises(np.linalg.LinAlgError, match="not positive semi-definite"):
        udu.factor(np.array([[1.0, 2.0], [2.0, 1.0]]))


@pytest.mark.parametrize(
    ("dtype", "P0", "R"), [(np.float32, 1e5, 1e-6), (np.float64, 1e10, 1e-10)], ids=["float32", "float64"]
)
def test_plain_form_loses_positive_definiteness_and_udu_does_not(dtype, P0, R):
    """A double integrator with a parameter, started from near ignorance with a near-perfect sensor."""
    F = np.array([[1, 0, 0.01], [0.01, 1, 0], [0, 0, 1]], dtype=dtype)
    H = np.array([[0, 1, 0], [0.3, 1, 0.1]], dtype=dtype)
    G, q = np.array([[0.01], [0], [0]], dtype=dtype), np.array([1e-4], dtype=dtype)
    plain = dtype(P0) * np.eye(3, dtype=dtype)
    U, d = udu.factor(plain)
    plain_failed = False
    for _ in range(50):
        plain = F @ plain @ F.T + (G * q) @ G.T
        U, d = udu.predict(U, d, F, G, q)
        for h in H:
            plain = plain - np.outer(plain @ h, h @ plain) / (h @ plain @ h + dtype(R))
            U, d, _ = udu.update(U, d, h, dtype(R))
        plain_failed |= bool(np.linalg.eigvalsh(plain.astype(float)).min() <= 0)
        assert U.dtype == d.dtype == dtype
        assert np.all(d > 0), "UDUᵀ lost positive definiteness"
    assert plain_failed, "the stress case no longer stresses the plain form"
