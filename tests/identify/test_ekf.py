"""The EKF against the Kalman filter on a linear plant, its two covariance forms, and how it fails."""

import numpy as np
import pytest

from pipeline.identify.covariance_forms import JosephForm, UduForm
from pipeline.identify.ekf import Tuning, run_filter
from tests.identify.plants import LinearPlant

N, DT = 300, 0.01
R, Q_TAU = 1e-4, 0.5
Z0, P0 = np.zeros(3), np.diag([1.0, 1.0, 4.0])


@pytest.fixture
def record():
    rng = np.random.default_rng(3)
    plant, s, load = LinearPlant(DT), np.zeros(2), np.array([0.7])
    time, u, q = np.arange(N) * DT, rng.normal(size=(N, 1)), np.empty((N, 1))
    for k in range(N):
        q[k] = s[1] + np.sqrt(R) * rng.normal()
        s = plant.transition(s, u[k] + np.sqrt(Q_TAU) * rng.normal(size=1), load, 0.0, DT)
    return time, q, u


def kalman(q, u):
    """The Kalman filter of the linear plant, by its textbook formulas."""
    plant = LinearPlant(DT)
    F = np.block([[plant.A, plant.E], [np.zeros((1, 2)), np.eye(1)]])
    B = np.vstack([plant.B, [[0.0]]])
    H, z, P, out = np.array([[0.0, 1.0, 0.0]]), Z0.copy(), P0.copy(), []
    for k in range(N):
        if k:
            z, P = F @ z + B @ u[k - 1], F @ P @ F.T + Q_TAU * B @ B.T
        S = H @ P @ H.T + R
        K = P @ H.T / S
        z, P = z + (K @ (q[k] - H @ z)), (np.eye(3) - K @ H) @ P
        out.append(np.concatenate([z, np.diag(P)]))
    return np.array(out)


TUNING = Tuning(np.array([R]), np.array([Q_TAU]), input_noise=True)


@pytest.mark.parametrize("covariance", ["udu", "joseph"])
@pytest.mark.parametrize("jacobian", ["forward", "central"])
def test_on_a_linear_plant_it_is_the_kalman_filter(record, covariance, jacobian):
    time, q, u = record
    run = run_filter(LinearPlant(DT), time, q, u, Z0, P0, TUNING, jacobian, covariance)
    expected = kalman(q, u)
    assert run.failed_at is None
    # a difference carries round-off into F: a parameter near 0 has a step of 1e-10 (forward) or 1e-8 (central)
    tolerance = 1e-4 if jacobian == "forward" else 1e-6
    assert np.max(np.abs(run.x - expected[:, :3]) / np.sqrt(expected[:, 3:])) < tolerance
    np.testing.assert_allclose(run.P_diag, expected[:, 3:], rtol=tolerance)


def test_noise_levels_that_are_right_give_a_consistent_filter(record):
    time, q, u = record
    run = run_filter(LinearPlant(DT), time, q, u, Z0, P0, TUNING)
    assert 0.8 < run.NIS.mean() < 1.2
    assert abs(run.x[-1, 2] - 0.7) < 4 * np.sqrt(run.P_diag[-1, 2])


@pytest.mark.parametrize("seed", range(5))
def test_forms_agree_when_fed_the_same_linearisations(seed):
    rng = np.random.default_rng(seed)
    H, R_diag = np.hstack([np.zeros((2, 2)), np.eye(2), np.zeros((2, 3))]), np.array([1e-6, 1e-6])
    z, P = rng.normal(size=7), np.diag(10.0 ** rng.uniform(-4, 1, 7))
    forms = [form(z, P, H, R_diag) for form in (UduForm, JosephForm)]
    for _ in range(200):
        F = np.eye(7) + 0.01 * rng.normal(size=(7, 7))
        G, q, y = 0.01 * rng.normal(size=(7, 2)), np.array([1.0, 0.05]), rng.normal(size=2)
        for form in forms:
            form.predict(F @ form.x, F, G, q)
            form.update(y)
    sigma = np.sqrt(forms[0].P_diag)
    assert np.max(np.abs(forms[0].x - forms[1].x) / sigma) < 1e-8
    np.testing.assert_allclose(forms[0].P, forms[1].P, atol=1e-8 * sigma.max() ** 2)


def test_a_failing_plant_stops_the_filter_at_that_sample_and_keeps_the_rest(record):
    time, q, u = record
    whole = run_filter(LinearPlant(DT), time, q, u, Z0, P0, TUNING)
    run = run_filter(LinearPlant(DT, fails_at=1.0), time, q, u, Z0, P0, TUNING)
    assert run.failed_at == 101
    assert run.reason == "linear.fmu: fmi2DoStep returned Error"
    np.testing.assert_array_equal(run.x, whole.x[:101])


def test_a_mass_matrix_that_is_not_positive_stops_the_filter(record):
    time, q, u = record
    plant = LinearPlant(DT)
    plant.B = -plant.B
    run = run_filter(plant, time, q, u, Z0, P0, TUNING)
    assert run.failed_at == 1
    assert "mass matrix lost positive definiteness" in run.reason


def test_an_input_that_is_not_a_number_is_a_failure_not_an_estimate(record):
    time, q, u = record
    q = q.copy()
    q[40] = np.nan
    run = run_filter(LinearPlant(DT), time, q, u, Z0, P0, TUNING)
    assert run.failed_at == 40 and "not finite" in run.reason
