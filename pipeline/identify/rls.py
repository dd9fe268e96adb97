"""Recursive least squares in square-root form: the weighted rows in the order of time, one instant after the other."""

from __future__ import annotations

from collections.abc import Sequence
from time import process_time

import numpy as np
from scipy import linalg

from pipeline.errors import IdentificationError
from pipeline.identify.covariance import formal
from pipeline.identify.regression import require_full_rank, weighted
from pipeline.identify.wls import coloured
from pipeline.records import Estimate, Regression

START_CONDITION = 1e6
"""The square start is extended until cond of its rows, columns scaled to length 1, is below this."""


def rls(regression: Regression, units: Sequence[str], name: str = "RLS") -> Estimate:
    """RLS with the square start (Gautier & Poignet 2001, section 5.1, remarks): at the end = WLS.

    The information [R z], R theta = z, is rotated by QR with the rows of each instant, so nothing is subtracted and
    nothing squared. The first p rows, interleaved by time, give the start; it is extended until their rank is p.
    history (K, p) and history_sigma (K, p) at history_time (K,) s, from the end of the start on.
    Raises IdentificationError naming the parameters that the record does not excite.
    """
    began = process_time()
    W_w, y_w = weighted(regression)
    require_full_rank(W_w, regression.names)
    order = np.lexsort((regression.joint, regression.time))
    rows, time = np.column_stack([W_w, y_w])[order], regression.time[order]
    first = square_start(rows[:, :-1])
    theta, sigma, instants, R = _recursion(rows, time, first)
    return Estimate(
        name=name,
        method="RLS",
        names=regression.names,
        units=tuple(units),
        theta=theta[-1],
        covariance=formal(R),
        sigma_reason=coloured(regression, regression.y - regression.W @ theta[-1]),
        elapsed=process_time() - began,
        condition_number=float(np.linalg.cond(R)),
        history_time=instants,
        history=theta,
        history_sigma=sigma,
    )


def square_start(W: np.ndarray) -> int:
    """How many of the first rows of W (r, p), in the order of time, it takes to determine all p parameters."""
    r, p = W.shape
    lengths = np.linalg.norm(W, axis=0)
    for m in range(p, r + 1):
        if np.linalg.cond(W[:m] / lengths) < START_CONDITION:
            return m
    raise IdentificationError(f"RLS: {r} rows never determine the {p} parameters; use a richer trajectory")


def _recursion(rows: np.ndarray, time: np.ndarray, first: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """(theta (K, p), sigma (K, p), time (K,), R (p, p)) after the start and after each instant that follows."""
    ends = np.append(np.flatnonzero(np.diff(time)) + 1, len(time))
    ends = ends[ends >= first]
    p = rows.shape[1] - 1
    theta, sigma = np.empty((len(ends), p)), np.empty((len(ends), p))
    information, begin = np.empty((0, p + 1)), 0
    for k, end in enumerate(ends):
        information = linalg.qr(np.vstack([information, rows[begin:end]]), mode="r", check_finite=False)[0][: p + 1]
        R_inverse = linalg.solve_triangular(information[:p, :p], np.eye(p), check_finite=False)
        theta[k] = R_inverse @ information[:p, p]
        sigma[k] = np.sqrt(np.einsum("ij,ij->i", R_inverse, R_inverse))
        begin = end
    return theta, sigma, time[ends - 1], information[:p, :p]
