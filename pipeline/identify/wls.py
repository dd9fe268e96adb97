"""Weighted least squares (Gautier & Poignet 2001, section 2.2)."""

from __future__ import annotations

from collections.abc import Sequence
from time import process_time

import numpy as np
from scipy import linalg

from pipeline.identify.covariance import LAG_SECONDS, formal, newey_west
from pipeline.identify.regression import require_full_rank, weighted
from pipeline.records import Estimate, Regression
from pipeline.signals.correlation import autocorrelation

INDEPENDENT_SECONDS = LAG_SECONDS / 4
"""Rows this far apart hardly share the memory of a 4 Hz parallel filter."""
COLOUR_LIMIT = 0.35
"""Autocorrelation of the residual above which sigma is not trusted: AR(1) noise of 0.35 understates sigma by 1.44."""


def wls(regression: Regression, name: str, units: Sequence[str]) -> Estimate:
    """chi_w = arg min rhoᵀ Gᵀ G rho (Eq. 7) by economy QR of W_w, with standard deviations and cond(W_w).

    units (p,) of the parameters. Covariance: (W_wᵀ W_w)⁻¹ from R where the rows of a joint are INDEPENDENT_SECONDS
    apart or more, else Newey–West. Where the residual is coloured all the same, `sigma_reason` says so.
    Raises IdentificationError naming the parameters that the record does not excite.
    """
    start = process_time()
    W_w, y_w = weighted(regression)
    require_full_rank(W_w, regression.names)
    theta, R = solve(W_w, y_w)
    rho_w = y_w - W_w @ theta
    apart = row_spacing(regression) > 0.99 * INDEPENDENT_SECONDS
    covariance = formal(R) if apart else newey_west(W_w, rho_w, regression.time, R)
    return Estimate(
        name=name,
        method="WLS",
        names=regression.names,
        units=tuple(units),
        theta=theta,
        covariance=covariance,
        sigma_reason=coloured(regression, rho_w),
        elapsed=process_time() - start,
        condition_number=float(np.linalg.cond(R)),
    )


def row_spacing(regression: Regression) -> float:
    """Seconds between neighbouring rows of a joint; inf where there is one row."""
    steps = np.diff(regression.time[regression.joint == regression.joint[0]])
    return float(np.median(steps)) if len(steps) else np.inf


def solve(W_w: np.ndarray, y_w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least squares by economy QR: (theta (p,), R (p, p) upper triangular)."""
    Q, R = linalg.qr(W_w, mode="economic")
    return linalg.solve_triangular(R, Q.T @ y_w), R


def residuals(regression: Regression, theta: np.ndarray) -> np.ndarray:
    """rho = y − W theta (r,) in N·m or N, in the order of the rows."""
    return regression.y - regression.W @ theta


def coloured(regression: Regression, rho: np.ndarray) -> str:
    """Why sigma must not be trusted: the joint whose residual rho (r,) is most coloured; "" where none is.

    Colour that no filter has put there means errors in W (bias) or missing dynamics, and neither is in sigma.
    """
    worst, joint, lag = max(_colour(regression, rho, j) for j in np.unique(regression.joint))
    rows = int(np.sum(regression.joint == joint))
    limit = max(COLOUR_LIMIT, 4.0 / np.sqrt(rows))
    if worst <= limit:
        return ""
    return (
        f"joint {joint + 1}: the residual is coloured, autocorrelation {worst:.2f} at {lag:.2g} s (limit {limit:.2f}): "
        "biased by noise in W or by missing dynamics, which sigma does not know of"
    )


def _colour(regression: Regression, rho: np.ndarray, j: int) -> tuple[float, int, float]:
    rows = regression.joint == j
    time = regression.time[rows]
    step = float(np.median(np.diff(time)))
    lag = 1 if regression.decimation > 1 else max(1, round(INDEPENDENT_SECONDS / step))
    return abs(float(autocorrelation(rho[rows], lag)[-1])), int(j), lag * step
