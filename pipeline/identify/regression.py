"""The overdetermined system y = W chi + rho of a filtered record, and what its excitation is worth."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy import linalg

from pipeline.errors import DataError, IdentificationError
from pipeline.records import Regression
from pipeline.settings import WlsSettings
from pipeline.signals.frames import joint_columns, parallel_filter

InverseModel = Callable[[np.ndarray, np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]
"""(q, qd, qdd), each (N, n) -> D (N, n, p), y0 (N, n) with tau = D chi + y0."""

RANK_TOLERANCE = 1e-10
"""Relative to the largest singular value, columns scaled to length 1: measured records never come near it."""


@dataclass(frozen=True)
class Excitation:
    """How well a regression is excited (section 2.2): cond(W_w), cond(Phi) and its omissions, singular values of W_w.

    condition_number_Phi is None where no a-priori value but 0 is known; left_out_of_Phi names the columns with 0.
    """

    condition_number_W: float
    condition_number_Phi: float | None
    left_out_of_Phi: tuple[str, ...]
    singular_values: np.ndarray


def regression(
    filtered: pd.DataFrame,
    n: int,
    rate: float,
    settings: WlsSettings,
    inverse_model: InverseModel,
    names: Sequence[str],
) -> Regression:
    """Assemble y = W chi + rho (Eq. 4), rows sorted by joint, y and every column of W filtered in parallel.

    filtered: q_i, qd_i, qdd_i, tau_i (N rows at `rate` Hz) from `filter_frame`; y0 is taken off y.
    Raises IdentificationError for fewer rows than parameters or a joint without torque.
    """
    q, qd, qdd, tau = (filtered[joint_columns(c, n)].to_numpy() for c in ("q", "qd", "qdd", "tau"))
    D, y0 = inverse_model(q, qd, qdd)
    if D.shape != (len(q), n, len(names)):
        raise DataError(f"inverse model: D has shape {D.shape}, {(len(q), n, len(names))} is needed; check the names")
    stacked = np.concatenate([D, (tau - y0)[:, :, None]], axis=2).reshape(len(q), -1)
    kept_rows, kept = parallel_filter(stacked, rate, settings)
    by_joint = kept_rows.reshape(len(kept), n, -1).transpose(1, 0, 2).reshape(n * len(kept), -1)
    W, y = by_joint[:, :-1], by_joint[:, -1]
    joint = np.repeat(np.arange(n), len(kept))
    time = np.tile(filtered.index.to_numpy(dtype=float)[kept], n)
    return Regression(W, y, time, joint, tuple(names), ols_sigma_rho(W, y, joint), settings.decimation)


def ols_sigma_rho(W: np.ndarray, y: np.ndarray, joint: np.ndarray) -> np.ndarray:
    """sigma_rho (n,) with sigma² = ‖rho^j‖²_min/(r^j − p^j), by OLS of each joint (between Eq. 6 and 7).

    Economy QR of W^j without computing a solution; p^j, the minimum parameters of joint j, is the rank of W^j.
    """
    return np.array([_joint_sigma(W[joint == j], y[joint == j], j) for j in np.unique(joint)])


def _joint_sigma(W: np.ndarray, y: np.ndarray, j: int) -> float:
    lengths = np.linalg.norm(W, axis=0)
    seen = lengths > RANK_TOLERANCE * lengths.max(initial=0.0)  # a probed zero may be rounding
    W = W[:, seen] / lengths[seen]
    Q, R, _ = linalg.qr(W, mode="economic", pivoting=True)
    diagonal = np.abs(np.diag(R))
    rank = int(np.sum(diagonal > RANK_TOLERANCE * diagonal.max(initial=0.0)))
    if len(y) <= rank:
        raise IdentificationError(f"joint {j + 1}: {len(y)} rows for {rank} parameters; record longer or decimate less")
    if not y.any():
        raise IdentificationError(f"joint {j + 1}: the torque is 0 throughout; check its column and the drive gain")
    rho = y - Q[:, :rank] @ (Q[:, :rank].T @ y)
    # Without noise the residual is rounding: a weight needs a number above zero.
    rounding = np.finfo(float).eps * np.linalg.norm(y)
    return float(max(np.linalg.norm(rho), rounding) / np.sqrt(len(y) - rank))


def weighted(regression: Regression) -> tuple[np.ndarray, np.ndarray]:
    """W_w (r, p) and y_w (r,) = G W, G y with G = diag(1/sigma_rho of the row's joint) (Eq. 8); no units."""
    s = 1.0 / regression.sigma_rho[regression.joint]
    return regression.W * s[:, None], regression.y * s


def subset(regression: Regression, names: Sequence[str]) -> Regression:
    """The regression with the columns `names` only, the others held at zero; sigma_rho is computed again."""
    columns = [regression.names.index(name) for name in names]
    W = regression.W[:, columns]
    sigma_rho = ols_sigma_rho(W, regression.y, regression.joint)
    r = regression
    return Regression(W, r.y, r.time, r.joint, tuple(names), sigma_rho, r.decimation)


def require_full_rank(W_w: np.ndarray, names: Sequence[str]) -> None:
    """Raise IdentificationError naming the parameters that the record does not excite, or not apart from each other."""
    lengths = np.linalg.norm(W_w, axis=0)
    silent = [name for name, length in zip(names, lengths, strict=True) if length == 0.0]
    if silent:
        raise IdentificationError(
            f"not excited: {', '.join(silent)} (a column of zeros in W); use a richer trajectory or hold the parameter"
        )
    if len(W_w) < len(names):
        raise IdentificationError(f"{len(W_w)} rows for {len(names)} parameters; record longer or decimate less")
    _, s, Vt = linalg.svd(W_w / lengths, full_matrices=False)
    null = Vt[s <= RANK_TOLERANCE * s[0]]
    if len(null):
        involved = [name for name, v in zip(names, np.abs(null).max(axis=0), strict=True) if v > 1e-6]
        raise IdentificationError(
            f"not identifiable apart: {', '.join(involved)} (rank {len(names) - len(null)} of {len(names)}); "
            "use a richer trajectory, group or hold them"
        )


def condition_Phi(W_w: np.ndarray, a_priori: np.ndarray, names: Sequence[str]) -> tuple[float | None, tuple[str, ...]]:
    """cond(Phi), Phi = W_w diag(a_priori) (Eq. 9), and the names left out: an a-priori 0 would make it infinite."""
    a_priori = np.asarray(a_priori, dtype=float)
    known = a_priori != 0.0
    left_out = tuple(name for name, k in zip(names, known, strict=True) if not k)
    if not known.any():
        return None, left_out
    return float(np.linalg.cond(W_w[:, known] * a_priori[known])), left_out


def excitation(regression: Regression, a_priori: np.ndarray) -> Excitation:
    """Both condition numbers and the singular values of W_w; a_priori (p,) in the parameters' units."""
    W_w, _ = weighted(regression)
    singular_values = linalg.svd(W_w, compute_uv=False)
    with np.errstate(divide="ignore"):
        condition_W = float(singular_values[0] / singular_values[-1])
    condition, left_out = condition_Phi(W_w, a_priori, regression.names)
    return Excitation(condition_W, condition, left_out, singular_values)
