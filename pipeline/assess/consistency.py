"""Is a Kalman filter consistent with its own covariance: NIS and whiteness of the innovations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

from pipeline.assess.residuals import LAGS, Whiteness, whiteness
from pipeline.records import FilterRun

SPREAD = 0.09
"""Right filters scatter by up to 9 % in the mean NIS of 25 s: innovations at friction reversals are not Gaussian."""


@dataclass(frozen=True)
class Consistency:
    """Mean NIS with its band [low, high], whiteness per joint; ok: trust sigma; sentence: number and reason."""

    NIS_mean: float
    low: float
    high: float
    NIS_ok: bool
    whiteness: tuple[Whiteness, ...]
    ok: bool
    sentence: str

    def as_record(self) -> dict:
        """The `tests` entry of the run record: plain numbers, None for what could not be computed."""
        mean = self.NIS_mean if np.isfinite(self.NIS_mean) else None
        white = [
            {"joint": j + 1, "lag1": _plain(w.lag1), "outside_percent": _plain(w.outside_percent), "ok": w.ok}
            for j, w in enumerate(self.whiteness)
        ]
        return {
            "NIS": {"mean": mean, "low": self.low, "high": self.high, "ok": self.NIS_ok},
            "whiteness": white,
            "sentence": self.sentence,
        }


def nis_band(samples: int, n: int) -> tuple[float, float]:
    """Band of the mean NIS of n outputs: 95 % of chi²(n·samples)/samples, but never tighter than SPREAD."""
    low, high = stats.chi2.ppf([0.025, 0.975], n * samples) / samples
    return float(min(low, n * (1 - SPREAD))), float(max(high, n * (1 + SPREAD)))


def consistency(run: FilterRun) -> Consistency:
    """Test a filter's run: mean NIS = n within its band, and innovations/√S white in every joint.

    NIS alone is not enough: it passes a filter that is biased by a coarse transition (Euler) in half of the cases.
    """
    samples, n = run.innovation.shape
    if samples <= LAGS + 1:
        sentence = f"{samples} samples are too few to test the filter; sigma is withheld"
        white = tuple(whiteness(run.innovation[:, j], f"joint {j + 1}, innovation") for j in range(n))
        return Consistency(float("nan"), *nis_band(max(samples, 1), n), False, white, False, sentence)
    mean = float(np.mean(run.NIS))
    low, high = nis_band(samples, n)
    normalised = run.innovation / np.sqrt(run.S_diag)
    white = tuple(whiteness(normalised[:, j], f"joint {j + 1}, innovation") for j in range(n))
    inside = bool(low <= mean <= high)
    ok = inside and all(w.ok for w in white)
    return Consistency(mean, low, high, inside, white, ok, _sentence(mean, low, high, white, ok))


def _sentence(mean: float, low: float, high: float, white: tuple[Whiteness, ...], ok: bool) -> str:
    band = f"mean NIS {mean:.3g}, band {low:.2f} to {high:.2f}"
    if ok:
        return f"{band}, innovations white: sigma may be trusted"
    reasons = []
    if mean < low:
        reasons.append(f"{band}: the filter assumes more noise than there is, its sigma is too large")
    if mean > high:
        reasons.append(f"{band}: the filter assumes too little noise or its model is wrong, its sigma is too small")
    coloured = [w.sentence for w in white if not w.ok]
    reasons += coloured + ["the model, or the ratio of Q to R, is not what the data show"] * bool(coloured)
    return "; ".join(reasons) + "; sigma is withheld"


def _plain(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
