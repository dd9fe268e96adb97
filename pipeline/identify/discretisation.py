"""How far the transition's own error may shift an estimate: the integration checked against a finer one."""

from __future__ import annotations

import numpy as np

from pipeline.identify.ekf import Tuning
from pipeline.identify.jacobian import linearise
from pipeline.records import FilterRun

LIMIT = 1.0
"""Sigma: beyond it the filter's sigma says nothing about its error."""


def worst_shift(plant, fine, run: FilterRun, u: np.ndarray, tuning: Tuning, stride: int = 10) -> float:
    """Upper bound, in sigma, of what the error of `plant`'s transition adds to any estimate of a run.

    The error e_k of a step against `fine`, the same plant integrated more finely, moves the states as process noise w
    of some size would: w_k = e_k where the states are noisy themselves, and [A G, G] w_k = e_k, noise on the forces of
    this step and the one before, where only they are. At worst all of it adds up: an estimate is linear in the noise,
    so its shift is at most √(Σ w_kᵀ Q⁻¹ w_k) of its sigma (Cauchy–Schwarz; twice the sum, if steps share a force).
    Every stride-th sample stands for its neighbours, at the run's last parameters; u (N, n): the inputs. The bound
    is wide, and tells Euler's step (Eq. 13) from a fair one where NIS and whiteness do not.
    """
    ns, chi = plant.ns, run.x[-1, plant.ns :]
    steps = range(0, len(run.time) - 1, stride)
    squares = []
    for k in steps:
        s, t, dt = run.x[k, :ns], run.time[k], run.time[k + 1] - run.time[k]
        error = plant.transition(s, u[k], chi, t, dt) - fine.transition(s, u[k], chi, t, dt)
        squares.append(np.sum(_as_noise(plant, s, u[k], chi, t, dt, error, tuning) ** 2))
    shared = 2.0 if tuning.input_noise else 1.0
    return float(np.sqrt(shared * np.mean(squares) * (len(run.time) - 1)))


def _as_noise(plant, s, u, chi, t, dt, error: np.ndarray, tuning: Tuning) -> np.ndarray:
    """The process noise, in its standard deviations, that moves the states (ns,) as the error does."""
    sigma = np.sqrt(tuning.q)
    if not tuning.input_noise:
        return error / sigma
    model = linearise(plant, s, chi, u, t, dt, "forward")
    G = model.C / plant.binding.gain * sigma
    return np.linalg.solve(np.hstack([model.A @ G, G]), error)
