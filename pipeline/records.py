"""The types that travel between the rooms: arrays with their shapes and units, nothing that computes.

Letters: N samples, n joints, p parameters, r = N·n rows, nx filter states, h hidden plant states.
Joints are numbered from 1 in names and columns (`q_1`), rows of arrays from 0.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

OK, FAILED = "ok", "failed"


@dataclass(frozen=True)
class Trajectory:
    """A sampled motion: t (N,) s; q, qd, qdd (N, n) in rad or m and their derivatives."""

    t: np.ndarray
    q: np.ndarray
    qd: np.ndarray
    qdd: np.ndarray


@dataclass(frozen=True)
class Regression:
    """The overdetermined system y = W chi + rho (Gautier & Poignet 2001, Eq. 4), rows sorted by joint.

    W (r, p); y (r,) N·m or N with y0, the part that is not identified, taken off; time (r,) s and joint (r,)
    of each row (joint 0 … n−1); names (p,); sigma_rho (n,) standard deviation of the residual per joint
    (from the OLS of each joint); decimation: every how-many-th sample was kept.
    """

    W: np.ndarray
    y: np.ndarray
    time: np.ndarray
    joint: np.ndarray
    names: tuple[str, ...]
    sigma_rho: np.ndarray
    decimation: int = 1


@dataclass(frozen=True)
class Estimate:
    """What an estimator found.

    theta (p,) in `units`; covariance (p, p), or None where it was not computed; `status` is "ok" or "failed"
    with its `reason`; `sigma_reason` says why sigma must not be trusted ("" where it may); `held` maps a
    parameter that was not estimated to the reason; elapsed in s of CPU time; history (N, p) and
    history_sigma (N, p) at history_time (N,) s for recursive estimators.
    """

    name: str
    method: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    theta: np.ndarray
    covariance: np.ndarray | None = None
    status: str = OK
    reason: str = ""
    sigma_reason: str = ""
    held: dict[str, str] = field(default_factory=dict)
    elapsed: float = 0.0
    condition_number: float | None = None
    history_time: np.ndarray | None = None
    history: np.ndarray | None = None
    history_sigma: np.ndarray | None = None

    @property
    def sigma(self) -> np.ndarray:
        """Standard deviations (p,); NaN where no covariance is known."""
        if self.covariance is None:
            return np.full(len(self.theta), np.nan)
        return np.sqrt(np.diag(self.covariance))

    @property
    def relative_sigma_percent(self) -> np.ndarray:
        """Relative standard deviations 100 sigma/|theta| (p,) (Eq. 10); inf where theta is 0."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return 100.0 * self.sigma / np.abs(self.theta)


@dataclass(frozen=True)
class FilterRun:
    """One pass of a Kalman filter, up to and without the sample at which it failed, if it failed.

    time (N,) s; x (N, nx) filtered states [qd, q, h, chi]; P_diag (N, nx) diagonal of their covariance; innovation
    (N, n) and S_diag (N, n), its predicted variance; NIS (N,) normalised innovation squared; failed_at: the sample
    of the failure or None, with its reason; P (nx, nx) the last covariance.
    """

    time: np.ndarray
    x: np.ndarray
    P_diag: np.ndarray
    innovation: np.ndarray
    S_diag: np.ndarray
    NIS: np.ndarray
    P: np.ndarray
    failed_at: int | None = None
    reason: str = ""
