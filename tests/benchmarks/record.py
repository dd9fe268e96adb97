"""The record that the benchmarks filter: the shipped experiment's closed loop, with a prior and the tuning `known`."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from pipeline.identify.ekf import Tuning
from pipeline.plant.binding import Binding
from pipeline.plant.steps import floor
from pipeline.signals.frames import joint_columns
from pipeline.simulate.sensors import position_variance
from pipeline.workflow.acquire import acquire
from pipeline.workflow.session import Session, open_session

OFF = 0.05
"""The prior is off the a-priori values by this share, and says so.

Forward differences amplify round-off: with the wide prior of the case "EKF(3) Euler", whose Fv1 ends with 7 % of
sigma, the last bit of z0 alone moves the estimates by 1e-7, as far as two programs may be apart.
"""


@dataclass(frozen=True)
class Record:
    """What a filter gets: time (N,) s, positions q and inputs u (N, n), prior z0 (nx,) and P0 (nx, nx), tuning.

    scale (nx,): typical sizes of z, the floor of the differences' steps.
    """

    time: np.ndarray
    q: np.ndarray
    u: np.ndarray
    z0: np.ndarray
    P0: np.ndarray
    tuning: Tuning
    scale: np.ndarray

    def first(self, samples: int) -> Record:
        """Its first samples."""
        return replace(self, time=self.time[:samples], q=self.q[:samples], u=self.u[:samples])


def prior(binding: Binding, q0: np.ndarray, P0_state, off: float = OFF) -> tuple[np.ndarray, np.ndarray]:
    """z0 (nx,) and P0 (nx, nx): at rest at q0 (n,), the parameters off by this share of their sizes."""
    chi = binding.a_priori
    sigma = off * np.maximum(np.abs(chi), binding.scale)
    return np.concatenate([np.zeros(binding.n), q0, chi + sigma]), np.diag([*P0_state, *sigma**2])


@cache
def session(fmi: str = "2") -> Session:
    """The shipped experiment of the SCARA on FMUs of FMI version "2" or "3"."""
    return open_session("scara", [f"fmi='{fmi}'"])


@cache
def scara() -> Record:
    """The SCARA's identification record, 25 s at 100 Hz."""
    s = session()
    frame, noise, n = acquire(s), s.experiment.simulation, s.binding.n
    q, u = (np.ascontiguousarray(frame[joint_columns(c, n)]) for c in "qu")
    z0, P0 = prior(s.binding, q[0], s.experiment.ekf.P0_state)
    tuning = Tuning(position_variance(noise.sigma_q), np.square(noise.sigma_u), input_noise=True)
    return Record(frame.index.to_numpy(float), q, u, z0, P0, tuning, floor(s.binding, 2 * n)[: len(z0)])
