"""Torque prediction on a trajectory that identification has not seen, beside what noise alone would leave."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy import signal

from pipeline.records import Regression
from pipeline.settings import WlsSettings
from pipeline.signals.cutoffs import cutoff_frequency
from pipeline.signals.filters import design
from pipeline.signals.frames import joint_columns


@dataclass(frozen=True)
class Prediction:
    """time (K,) s; measured and predicted (K, n) in N·m or N; errors: % by `tau_1` … and `total`."""

    time: np.ndarray
    measured: np.ndarray
    predicted: np.ndarray
    errors: dict[str, float]


def relative_error(y: np.ndarray, y_hat: np.ndarray) -> float:
    """100 ‖y − ŷ‖/‖y‖ in %; inf where y is zero and ŷ is not."""
    norm = np.linalg.norm(y)
    distance = np.linalg.norm(y - y_hat)
    return float(100.0 * distance / norm) if norm > 0 else float(np.inf if distance > 0 else 0.0)


def predict(validation: Regression, theta: np.ndarray, names: Sequence[str] | None = None) -> Prediction:
    """Predict the filtered torque of a validation regression by ŷ = W theta.

    theta (p,) in the order of validation.names, or of `names`, a subset of them (the others count as zero).
    """
    columns = [validation.names.index(name) for name in names or validation.names]
    n = len(np.unique(validation.joint))
    y_hat = validation.W[:, columns] @ theta
    measured, predicted = validation.y.reshape(n, -1).T, y_hat.reshape(n, -1).T
    return Prediction(validation.time[: len(measured)], measured, predicted, _errors(measured, predicted))


def noise_floor(
    validation: Regression,
    truth: np.ndarray | None,
    frame: pd.DataFrame,
    rate: float,
    settings: WlsSettings,
) -> dict[str, float]:
    """The error in % that noise alone leaves, by `tau_1` … and `total`.

    With the truth (p,) known: the prediction of the true parameters. Else from the torques tau_i of the unfiltered
    `frame` at `rate` [Hz]: their white noise, as far as the parallel filter lets it through; a guess from below, since
    noise in W and slow noise are not in it.
    """
    if truth is not None:
        return predict(validation, truth).errors
    n = len(np.unique(validation.joint))
    tau = frame[joint_columns("tau", n)].to_numpy()
    sigma = white_level(tau, rate, settings) * passed_noise(rate, settings)
    rms = np.sqrt(np.mean(validation.y.reshape(n, -1) ** 2, axis=1))
    floor = {c: float(100.0 * sigma[i] / rms[i]) for i, c in enumerate(joint_columns("tau", n))}
    return {**floor, "total": float(100.0 * np.linalg.norm(sigma) / np.linalg.norm(rms))}


def white_level(x: np.ndarray, rate: float, settings: WlsSettings) -> np.ndarray:
    """Standard deviation (m,) of the white noise that x (N, m) may hold: the lowest spectral density above the filter.

    Lowest of four bands between the parallel filter's cut-off and the Nyquist frequency, each segment's median, so
    that neither motion nor pulses nor a resonance count as noise.
    """
    cutoff = cutoff_frequency(rate, settings.parallel, settings.decimation)
    segment = min(len(x), max(64, int(8 * rate / cutoff)))
    f, density = signal.welch(x, rate, nperseg=segment, axis=0, average="median")
    edges = np.geomspace(min(cutoff, 0.25 * rate), 0.5 * rate, 5)
    bands = [density[(f >= low) & (f < high)].mean(axis=0) for low, high in zip(edges[:-1], edges[1:], strict=True)]
    return np.sqrt(np.min(bands, axis=0) * 0.5 * rate)


def passed_noise(rate: float, settings: WlsSettings) -> float:
    """Gain of white noise's standard deviation through the parallel filter: the root mean square of its response."""
    if settings.parallel.kind == "none":
        return 1.0
    _, h = signal.freqz_sos(design(rate, settings.parallel, settings.decimation), 4096)
    power = np.abs(h) ** 2
    return float(np.sqrt(np.mean(power if settings.parallel.kind == "forward" else power**2)))


def _errors(measured: np.ndarray, predicted: np.ndarray) -> dict[str, float]:
    names = joint_columns("tau", measured.shape[1])
    by_joint = {c: relative_error(measured[:, i], predicted[:, i]) for i, c in enumerate(names)}
    return {**by_joint, "total": relative_error(measured, predicted)}
