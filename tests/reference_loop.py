"""A closed loop of the SCARA in NumPy, all seeds at once: data for the tests without any FMU.

PD at 100 Hz with a filtered derivative and saturation, held torque, plant by RK4 at 1 ms with tanh friction;
noise on position and torque as in the experiment's two cases ("disturbed" and "clean" loop).
"""

from functools import cache

import numpy as np
import pandas as pd

from pipeline.paths import EXPERIMENTS
from pipeline.settings import Filter, WlsSettings
from pipeline.simulate.trajectory import read_waypoints, sample
from tests.closed_form import TRUTH, acceleration

RATE = 100.0
SIGMA_Q = np.array([1e-3, 1e-3])
SIGMA_TAU = np.array([1.0, 0.05])
KP, KD = np.array([[250.0], [8.0]]), np.array([[45.0], [0.9]])
TAU_MAX = np.array([[40.0], [6.0]])
TF = 0.02
SEEDS = tuple(range(60))
CASES = ("disturbed", "clean")
IDENTIFICATION, VALIDATION = EXPERIMENTS / "scara_identification.csv", EXPERIMENTS / "scara_validation.csv"

# Table 1 of the paper: no filter; forward filters only; zero-phase filters, as they follow the loop, and decimation.
WLS_1 = WlsSettings("WLS(1)", Filter("none"), Filter("none"), 1)
WLS_2 = WlsSettings("WLS(2)", Filter("forward", 10.0), Filter("forward", 4.0), 10, (30, 30))
WLS_3 = WlsSettings("WLS(3)", Filter("zero-phase", 10.6), Filter("zero-phase", 4.25), 10, (30, 30))


def _rk4(q, qd, tau, dt, steps, eps):
    for _ in range(steps):
        k1 = acceleration(q, qd, tau, TRUTH, eps)
        v2 = qd + 0.5 * dt * k1
        k2 = acceleration(q + 0.5 * dt * qd, v2, tau, TRUTH, eps)
        v3 = qd + 0.5 * dt * k2
        k3 = acceleration(q + 0.5 * dt * v2, v3, tau, TRUTH, eps)
        v4 = qd + dt * k3
        k4 = acceleration(q + dt * v3, v4, tau, TRUTH, eps)
        q = q + dt / 6.0 * (qd + 2 * v2 + 2 * v3 + v4)
        qd = qd + dt / 6.0 * (k1 + 2 * k2 + 2 * k3 + k4)
    return q, qd


def noises(N, seeds):
    """Position and torque noise (N, 2, seeds) each, one generator per seed."""
    draws = [np.random.default_rng(seed).standard_normal((N, 2, 2)) for seed in seeds]
    noise = np.stack(draws, axis=-1)
    return noise[:, 0] * SIGMA_Q[:, None], noise[:, 1] * SIGMA_TAU[:, None]


def simulate(trajectory, seeds, disturbed, eps=0.01, scale=1.0):
    """A measured frame per seed; `disturbed` (len(seeds),) booleans; `scale` multiplies the noise (0: none)."""
    N, S = len(trajectory.t), len(seeds)
    v_q, w = (scale * noise for noise in noises(N, seeds))
    in_loop = np.asarray(disturbed, dtype=float)
    q = np.repeat(trajectory.q[0][:, None], S, axis=1)
    qd, v = np.zeros_like(q), np.zeros_like(q)
    seen_before = q + v_q[0] * in_loop
    log = np.empty((4, N, 2, S))
    for k in range(N):
        seen = q + v_q[k] * in_loop
        v = (TF * v + seen - seen_before) / (TF + 1.0 / RATE)
        seen_before = seen
        u = KP * (trajectory.q[k][:, None] - seen) + KD * (trajectory.qd[k][:, None] - v)
        u = np.clip(u, -TAU_MAX, TAU_MAX)
        log[:, k] = q + v_q[k], u + w[k] * (1.0 - in_loop), q, qd
        q, qd = _rk4(q, qd, u + w[k] * in_loop, 1e-3, 10, eps)
    return [_frame(trajectory, log[..., s]) for s in range(S)]


def _frame(trajectory, log):
    columns = {}
    for i in range(2):
        columns |= {f"q_{i + 1}": log[0][:, i], f"u_{i + 1}": log[1][:, i], f"tau_{i + 1}": log[1][:, i]}
        columns |= {f"q_true_{i + 1}": log[2][:, i], f"qd_true_{i + 1}": log[3][:, i]}
    return pd.DataFrame(columns, index=pd.Index(trajectory.t, name="time"))


@cache
def records(case):
    """The identification records of all SEEDS in the noise case "disturbed" or "clean"."""
    return tuple(simulate(sample(read_waypoints(IDENTIFICATION), RATE), SEEDS, [case == "disturbed"] * len(SEEDS)))


@cache
def validation_record(seed=1000):
    """One record of the other trajectory, disturbed loop."""
    return simulate(sample(read_waypoints(VALIDATION), RATE), [seed], [True])[0]
