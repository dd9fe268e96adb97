"""How far the transition's own error may shift an estimate: the integration checked against a finer one."""

from __future__ import annotations

import numpy as np

from pipeline.identify.ekf import Tuning
from pipeline.records import FilterRun

LIMIT = 1.0
"""Sigma: beyond it the filter's sigma says nothing about its error."""


def worst_shift(plant, fine, run: FilterRun, u: np.ndarray, tuning: Tuning, stride: int = 10) -> float:
    """Upper bound, in sigma, of what the error of `plant`'s transition adds to any estimate of a run.

    The error e_k of a step against `fine`, the same plant integrated more finely, acts like process noise that is not
    white; at worst it all adds up, to √(Σ e_kᵀ Q⁻¹ e_k) (Cauchy–Schwarz in the information metric). Every stride-th
    sample of the run is taken, at its last parameters. u (N, n): the inputs. It is what tells Euler's step (Eq. 13)
    from a fair one where NIS and whiteness do not.
    """
    ns, chi = plant.ns, run.x[-1, plant.ns :]
    squares = []
    for k in range(0, len(run.time) - 1, stride):
        s, t, dt = run.x[k, :ns], run.time[k], run.time[k + 1] - run.time[k]
        exact = fine.transition(s, u[k], chi, t, dt)
        error = plant.transition(s, u[k], chi, t, dt) - exact
        squares.append(np.sum(_in_noise(fine, s, u[k], chi, t, dt, exact, error, tuning) ** 2))
    return float(np.sqrt(np.mean(squares) * (len(run.time) - 1)))


def _in_noise(fine, s, u, chi, t, dt, exact, error, tuning: Tuning) -> np.ndarray:
    """The error of a step (ns,) in units of the process noise's standard deviation."""
    sigma = np.sqrt(tuning.q)
    if not tuning.input_noise:
        return error / sigma
    n = fine.n
    drive = sigma / fine.binding.gain
    moved = [fine.transition(s, u + drive * unit, chi, t, dt) - exact for unit in np.eye(n)]
    return np.linalg.solve(np.column_stack(moved)[:n], error[:n])
