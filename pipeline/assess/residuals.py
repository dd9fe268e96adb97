"""Residuals of an identification: are they white, are they Gaussian, how far above the noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

from pipeline.identify.wls import residuals
from pipeline.records import Regression
from pipeline.signals.correlation import autocorrelation

LAGS = 20
SLOW = 0.03
"""Of the Nyquist frequency: where errors of the model gather, since they follow the motion."""
SIGNIFICANCE = 1e-3
"""A white series is called coloured once in a thousand."""
HEAVY_TAILS = 3.0
"""Excess kurtosis above which a residual is worth a second look: friction reversals, spikes."""


@dataclass(frozen=True)
class Whiteness:
    """Is a series white: lag1, % of lags 1 … LAGS outside ±bound (5 % expected), slow_power (1 expected), p, verdict.

    slow_power: power below SLOW over that of white noise; p_value: of the stricter of both tests.
    """

    lag1: float
    outside_percent: float
    bound: float
    slow_power: float
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
    """Test a series (N,) for whiteness in two ways, each at half the significance.

    Ljung & Box (1978): Q = N(N+2) Σ r_l²/(N−l) is chi-square with LAGS degrees. Periodogram: the power below SLOW is
    chi-square too; it sees small errors that follow the motion, such as those of a coarse transition.
    """
    series = np.asarray(series, dtype=float)
    N = len(series)
    if N <= LAGS + 1 or not series.any():
        few = f"{what}: {N} samples are too few to test for whiteness, {LAGS + 2} that are not all 0 are needed"
        return Whiteness(*[float("nan")] * 5, False, few)
    r = autocorrelation(series, LAGS)
    bound = 1.96 / np.sqrt(N)
    outside = 100.0 * float(np.mean(np.abs(r) > bound))
    Q = N * (N + 2) * np.sum(r**2 / (N - np.arange(1, LAGS + 1)))
    slow, p_slow = _slow_power(series)
    p_value = min(1.0, 2.0 * min(float(stats.chi2.sf(Q, LAGS)), p_slow))
    ok = p_value >= SIGNIFICANCE
    told = (
        f"{what}: lag-1 correlation {r[0]:.2f}, {outside:.0f} % of {LAGS} lags outside ±{bound:.3f} (5 % expected), "
        f"slow power {slow:.2f} of white noise's"
    )
    verdict = "white" if ok else f"coloured (p {_chance(p_value)})"
    return Whiteness(float(r[0]), outside, float(bound), slow, p_value, ok, f"{told}: {verdict}")


def _slow_power(series: np.ndarray) -> tuple[float, float]:
    """Power of series (N,) below SLOW over that of white noise of the same rms, and the chance of more."""
    N = len(series)
    kept = 1 + max(1, int(SLOW * N / 2))
    power = np.abs(np.fft.rfft(series)[:kept]) ** 2 / (series @ series)
    # Each frequency has two degrees of freedom, the mean one.
    total, degrees = power[0] + 2.0 * power[1:].sum(), 1 + 2 * (kept - 1)
    return float(total / degrees), float(stats.chi2.sf(total, degrees))


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


def _chance(p_value: float) -> str:
    return "< 1e-12" if p_value < 1e-12 else f"= {p_value:.1g}"
