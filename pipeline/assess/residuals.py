"""Residuals of an identification: are they white, are they Gaussian, how far above the noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

from pipeline.identify.wls import residuals
from pipeline.records import Regression
from pipeline.signals.correlation import autocorrelation

LAGS = 20
SIGNIFICANCE = 1e-4
"""Of the Ljung–Box test: a right filter is called coloured once in 10,000 joints; Euler's bias is far below it."""
HEAVY_TAILS = 3.0
"""Excess kurtosis above which a residual is worth a second look: friction reversals, spikes."""


@dataclass(frozen=True)
class Whiteness:
    """Autocorrelation of a series: lag1, % of lags 1 … LAGS outside ±bound (5 % expected), Ljung–Box p, verdict."""

    lag1: float
    outside_percent: float
    bound: float
    p_value: float
    ok: bool
    sentence: str


@dataclass(frozen=True)
class ResidualTest:
    """Residual of one joint (1 …): rms and floor in its unit (floor None: unknown), excess kurtosis, whiteness."""

    joint: int
    rms: float
    floor: float | None
    kurtosis: float
    whiteness: Whiteness
    sentence: str

    def as_record(self) -> dict:
        """The entry of the run record: plain numbers."""
        white = self.whiteness
        return {
            "joint": self.joint,
            "rms": self.rms,
            "floor": self.floor,
            "kurtosis": self.kurtosis,
            "lag1": white.lag1,
            "outside_percent": white.outside_percent,
            "whiteness_ok": white.ok,
            "sentence": self.sentence,
        }


def whiteness(series: np.ndarray, what: str = "residual") -> Whiteness:
    """Test a series (N,) for whiteness (Ljung & Box 1978): Q = N(N+2) Σ r_l²/(N−l) is chi-square with LAGS degrees."""
    N = len(series)
    if N <= LAGS + 1:
        few = f"{what}: {N} samples are too few to test for whiteness, {LAGS + 2} are needed"
        return Whiteness(float("nan"), float("nan"), float("nan"), float("nan"), False, few)
    r = autocorrelation(series, LAGS)
    bound = 1.96 / np.sqrt(N)
    outside = 100.0 * float(np.mean(np.abs(r) > bound))
    Q = N * (N + 2) * np.sum(r**2 / (N - np.arange(1, LAGS + 1)))
    p_value = float(stats.chi2.sf(Q, LAGS))
    ok = p_value >= SIGNIFICANCE
    told = f"lag-1 correlation {r[0]:.2f}, {outside:.0f} % of {LAGS} lags outside ±{bound:.3f} (5 % expected)"
    verdict = "white" if ok else f"coloured (Ljung–Box p {_p(p_value)}): something in the motion is not modelled"
    return Whiteness(float(r[0]), outside, float(bound), p_value, ok, f"{what}: {told}: {verdict}")


def residual_test(rho: np.ndarray, joint: int, unit: str = "", floor: float | None = None) -> ResidualTest:
    """Test the residual rho (N,) of joint 1 …, in `unit`, against the rms that noise alone would leave, if known."""
    rms = float(np.sqrt(np.mean(np.square(rho))))
    kurtosis = float(stats.kurtosis(rho)) if np.ptp(rho) > 0 else 0.0
    white = whiteness(rho, f"joint {joint}, residual")
    above = f", {rms / floor:.2f} times the noise floor of {floor:.3g}" if floor else ""
    tails = f"; heavy tails (excess kurtosis {kurtosis:.1f}): look for spikes" if kurtosis > HEAVY_TAILS else ""
    sentence = f"{white.sentence}; rms {rms:.3g} {unit}".rstrip() + above + tails
    return ResidualTest(joint, rms, floor, kurtosis, white, sentence)


def residual_tests(
    regression: Regression, theta: np.ndarray, unit: str = "", truth: np.ndarray | None = None
) -> tuple[ResidualTest, ...]:
    """The residual of every joint at theta (p,); the floor is the rms that the true parameters leave, where known."""
    rho = residuals(regression, theta)
    noise = None if truth is None else residuals(regression, truth)
    joints = np.unique(regression.joint)
    rows = [regression.joint == j for j in joints]
    floors = [None if noise is None else float(np.sqrt(np.mean(noise[r] ** 2))) for r in rows]
    return tuple(residual_test(rho[r], int(j) + 1, unit, f) for r, j, f in zip(rows, joints, floors, strict=True))


def _p(value: float) -> str:
    return "< 1e-4" if value < SIGNIFICANCE else f"{value:.2g}"
