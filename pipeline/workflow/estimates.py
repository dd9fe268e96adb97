"""Estimates as the run record holds them, and their signals as tables."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd

from pipeline.config import slug
from pipeline.identify.essential import Essential
from pipeline.identify.wls import residuals
from pipeline.records import OK, Estimate, Regression
from pipeline.workflow.filtering import Filtered
from pipeline.workflow.session import Session


def estimate_entry(session: Session, estimate: Estimate, start: np.ndarray | None = None, **more) -> dict:
    """An estimate as `estimates[name]` of the run record; start (p,): where a filter began; more: further keys."""
    usable = estimate.status == OK
    return {
        "status": estimate.status,
        "reason": estimate.reason,
        "method": estimate.method,
        "elapsed_s": estimate.elapsed,
        "condition_number": estimate.condition_number,
        "sigma_reason": estimate.sigma_reason,
        "held": estimate.held,
        "parameters": {name: _parameter(session, estimate, i, start, usable) for i, name in enumerate(estimate.names)},
        "signals": f"{slug(estimate.name)}.parquet",
        **more,
    }


def _parameter(session: Session, estimate: Estimate, i: int, start: np.ndarray | None, usable: bool) -> dict:
    """One parameter: a failed estimate has no value, one whose sigma is withheld has no sigma."""
    place = session.binding.names.index(estimate.names[i])
    trusted = usable and estimate.covariance is not None and not estimate.sigma_reason
    truth = session.truth
    return {
        "value": float(estimate.theta[i]) if usable else None,
        "sigma": float(estimate.sigma[i]) if trusted else None,
        "relative_sigma_percent": _finite(estimate.relative_sigma_percent[i]) if trusted else None,
        "unit": estimate.units[i],
        "a_priori": float(session.binding.a_priori[place]),
        "truth": None if truth is None else float(truth[place]),
        "start": None if start is None else float(start[i]),
    }


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def essential_entry(found: Essential | None) -> dict | None:
    """The essential parameters of the recommended WLS."""
    if found is None:
        return None
    estimate = found.estimate
    parameters = {
        name: {
            "value": estimate.theta[i],
            "sigma": None if estimate.sigma_reason else estimate.sigma[i],
            "unit": estimate.units[i],
        }
        for i, name in enumerate(estimate.names)
    }
    return {"kept": list(found.kept), "dropped": [list(d) for d in found.dropped], "parameters": parameters}


def regression_signals(regression: Regression, estimate: Estimate) -> pd.DataFrame:
    """Rows of a regression in their order: time [s], joint (1 …), y and the residual y − W theta [N·m or N]."""
    columns = {
        "joint": regression.joint + 1,
        "y": regression.y,
        "residual": residuals(regression, estimate.theta),
    }
    return pd.DataFrame(columns, index=pd.Index(regression.time, name="time"))


def history_signals(estimate: Estimate) -> pd.DataFrame:
    """theta(t) and sigma(t) of a recursive estimator."""
    columns = {f"theta {name}": estimate.history[:, i] for i, name in enumerate(estimate.names)}
    columns |= {f"sigma {name}": estimate.history_sigma[:, i] for i, name in enumerate(estimate.names)}
    return pd.DataFrame(columns, index=pd.Index(estimate.history_time, name="time"))


def filter_signals(filtered: Filtered, n: int) -> pd.DataFrame:
    """States, their sigma, innovations, S and NIS of a filter run, beside its theta(t) and sigma(t)."""
    run = filtered.run
    sigma = np.sqrt(np.maximum(run.P_diag, 0.0))
    columns = {}
    for i in range(n):
        columns |= {f"qd_{i + 1}": run.x[:, i], f"sigma qd_{i + 1}": sigma[:, i]}
        columns |= {f"q_{i + 1}": run.x[:, n + i], f"sigma q_{i + 1}": sigma[:, n + i]}
        columns |= {f"innovation_{i + 1}": run.innovation[:, i], f"S_{i + 1}": run.S_diag[:, i]}
    columns["NIS"] = run.NIS
    return pd.concat(
        [pd.DataFrame(columns, index=pd.Index(run.time, name="time")), history_signals(filtered.estimate)], axis=1
    )
