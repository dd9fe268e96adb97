"""From the measured frame to the filtered frame, and the parallel filter of y and the columns of W."""

from __future__ import annotations

import numpy as np
import pandas as pd

from pipeline.errors import ConfigError, DataError
from pipeline.settings import WlsSettings
from pipeline.signals.derivatives import central_difference
from pipeline.signals.filters import low_pass


def joint_columns(quantity: str, n: int) -> list[str]:
    """Column names of a quantity over the joints: q_1 … q_n."""
    return [f"{quantity}_{i + 1}" for i in range(n)]


def filter_frame(frame: pd.DataFrame, n: int, rate: float, settings: WlsSettings) -> pd.DataFrame:
    """The filtered frame of a measured frame: q_i low-passed, qd_i and qdd_i by central differences, tau_i aligned.

    Units as measured (rad or m, N·m or N), same index; u_i is the raw input. A torque held from t_k on acts on
    average half a sample after q_k: with `half_sample`, tau_i[k] = (tau_i[k−1] + tau_i[k])/2.
    Raises DataError for a missing column or too short a record, ConfigError for a filter that cannot be.
    """
    missing = [c for c in joint_columns("q", n) + joint_columns("tau", n) if c not in frame]
    if missing:
        raise DataError(f"measured frame: column `{missing[0]}` is missing; map it in the experiment file")
    q = low_pass(frame[joint_columns("q", n)].to_numpy(), rate, settings.position, settings.decimation)
    qd = central_difference(q, rate)
    qdd = central_difference(qd, rate)
    tau = frame[joint_columns("tau", n)].to_numpy(dtype=float)
    tau = align_held(tau) if settings.half_sample else tau
    arrays = {"q": q, "qd": qd, "qdd": qdd, "tau": tau}
    columns = {c: x[:, i] for name, x in arrays.items() for i, c in enumerate(joint_columns(name, n))}
    columns |= {c: frame[c].to_numpy() for c in joint_columns("u", n) if c in frame}
    return pd.DataFrame(columns, index=frame.index)


def align_held(u: np.ndarray) -> np.ndarray:
    """(u[k−1] + u[k])/2 along axis 0: the mean of a held input over the two half samples around t_k."""
    before = np.concatenate([u[:1], u[:-1]])
    return 0.5 * (before + u)


def parallel_filter(columns: np.ndarray, rate: float, settings: WlsSettings) -> tuple[np.ndarray, np.ndarray]:
    """Filter every column of (N, m) alike, cut the borders, keep 1 of `decimation`: (rows (K, m), indices (K,)).

    Linear in the columns, so y = W chi still holds behind it (Gautier & Poignet 2001, section 5.1). The borders go
    last: they take the ends of this filter with them, where its odd reflection turns on the noise of one sample.
    Raises ConfigError for a decimation below 1 or a negative border, DataError where the borders leave nothing.
    """
    first, last = settings.border
    if (settings.decimation or 0) < 1 or min(settings.border) < 0:
        raise ConfigError(f"{settings.name}: decimation {settings.decimation}, border {first}, {last}; use ≥ 1, ≥ 0")
    kept = np.arange(first, len(columns) - last, settings.decimation)
    if len(kept) == 0:
        raise DataError(f"{settings.name}: border {first} + {last} leaves none of {len(columns)} samples; cut fewer")
    return low_pass(columns, rate, settings.parallel, settings.decimation)[kept], kept
