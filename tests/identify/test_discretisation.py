"""The bound on what a coarse transition may shift, on a plant whose exact transition is known."""

from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.identify.discretisation import worst_shift
from pipeline.identify.ekf import Tuning, run_filter
from pipeline.records import FilterRun
from tests.identify.plants import LinearPlant


class Pushed(LinearPlant):
    """The linear plant, pushed by a force that its model does not know."""

    def __init__(self, force):
        super().__init__()
        self.force = force

    def transition(self, s, u, chi, t, dt):
        return super().transition(s, u + self.force, chi, t, dt)


def run_of(N):
    x = np.random.default_rng(0).normal(size=(N, 3))
    empty = np.empty((N, 1))
    return FilterRun(np.arange(N) * 0.01, x, x**2, empty, empty, empty[:, 0], np.eye(3))


def test_a_constant_push_of_a_tenth_sigma_adds_up_over_the_record():
    sigma, N = 0.4, 401
    tuning = Tuning(np.array([1.0]), np.array([sigma**2]), input_noise=True)
    shift = worst_shift(Pushed(0.1 * sigma), LinearPlant(), run_of(N), np.zeros((N, 1)), tuning)
    np.testing.assert_allclose(shift, 0.1 * np.sqrt(2 * (N - 1)), rtol=1e-6)


def test_the_same_transition_shifts_nothing():
    tuning = Tuning(np.array([1.0]), np.array([1.0]), input_noise=True)
    assert worst_shift(LinearPlant(), LinearPlant(), run_of(50), np.zeros((50, 1)), tuning) == 0.0


def test_noise_on_the_states_is_the_unit_of_each_state():
    plant, tuning = Pushed(0.5), Tuning(np.array([1.0]), np.array([0.01, 0.02]) ** 2, input_noise=False)
    plant.binding = SimpleNamespace(gain=np.ones(1))
    expected = np.linalg.norm(plant.B[:, 0] * 0.5 / np.array([0.01, 0.02])) * np.sqrt(49)
    np.testing.assert_allclose(worst_shift(plant, LinearPlant(), run_of(50), np.zeros((50, 1)), tuning), expected)


@pytest.mark.parametrize("load", [0.7, 5.0])
def test_no_estimate_is_shifted_beyond_the_bound(load):
    """A constant force through Euler's step, which forgets dt²/2: what really happens to the estimate of the load."""
    exact, euler, N, dt = LinearPlant(), LinearPlant(), 300, 0.01
    euler.A, euler.B, euler.E = (
        np.array([[0.98, 0.0], [dt, 1.0]]),
        np.array([[dt], [0.0]]),
        np.array([[0.3 * dt], [0.0]]),
    )
    exact.E = 0.3 * exact.B
    time, u, q = np.arange(N) * dt, np.full((N, 1), 1.5), np.empty((N, 1))
    s = np.zeros(2)
    for k in range(N):
        q[k] = s[1]
        s = exact.transition(s, u[k], np.array([load]), 0.0, dt)
    tuning = Tuning(np.array([1e-8]), np.array([1e-4]), input_noise=True)
    run = run_filter(euler, time, q, u, np.array([0.0, 0.0, load]), np.diag([1e-6, 1e-6, 4.0]), tuning, "central")
    shifted = abs(run.x[-1, 2] - load) / np.sqrt(run.P_diag[-1, 2])
    bound = worst_shift(euler, exact, run, u, tuning)
    assert 1.0 < shifted <= bound
