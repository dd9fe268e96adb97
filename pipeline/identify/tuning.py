"""Noise levels for the filter where nobody knows them: derived from the data and from the WLS residual."""

from __future__ import annotations

import numpy as np
from scipy.signal import butter, sosfiltfilt


def position_noise(q: np.ndarray, rate: float, cutoff: float) -> np.ndarray:
    """Standard deviation (n,) of the noise on the positions q (N, n), sampled at `rate` (Hz).

    The larger of what an encoder's quantum leaves, quantum/√12, and the residual above `cutoff` (Hz), scaled up to
    the full band as for white noise. Motion must be band-limited below `cutoff`.
    """
    smooth = sosfiltfilt(butter(4, cutoff, fs=rate, output="sos"), q, axis=0)
    edge = min(len(q) // 10, int(2 * rate / cutoff))
    residual = (q - smooth)[edge : len(q) - edge]
    high_pass = residual.std(axis=0) / np.sqrt(1.0 - 2.0 * cutoff / rate)
    return np.maximum(high_pass, quantum(q) / np.sqrt(12.0))


def quantum(q: np.ndarray) -> np.ndarray:
    """The encoder's quantum per column (n,): the step of which all changes are multiples; 0 where there is none."""
    found = np.zeros(q.shape[1])
    for i, column in enumerate(q.T):
        change = np.abs(np.diff(column))
        change = change[change > 0]
        if change.size == 0:
            continue
        step = change.min()
        multiples = change / step
        if np.all(np.abs(multiples - np.round(multiples)) < 1e-3 * np.maximum(multiples, 1.0)) and step > 1e-12:
            found[i] = step
    return found


def force_noise(sigma_rho: np.ndarray, rate: float, parallel_cutoff: float) -> np.ndarray:
    """Standard deviation (n,) of the joint force per sample, from the WLS residual after the parallel filter.

    The filter passes the share 2 f_parallel/rate of white noise: sigma_tau² = sigma_rho² · rate/(2 f_parallel).
    """
    return sigma_rho * np.sqrt(max(1.0, rate / (2.0 * parallel_cutoff)))
