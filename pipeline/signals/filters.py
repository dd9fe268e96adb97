"""Low-pass filters of sampled signals, along axis 0: zero-phase, forward-only, and the usual decimation filter."""

from __future__ import annotations

import numpy as np
from scipy import signal

from pipeline.errors import ConfigError, DataError
from pipeline.settings import Filter
from pipeline.signals.cutoffs import CHEBYSHEV_BAND, cutoff_frequency

CHEBYSHEV_ORDER, CHEBYSHEV_RIPPLE_DB = 8, 0.05


def low_pass(x: np.ndarray, rate: float, settings: Filter, decimation: int = 1) -> np.ndarray:
    """Filter the columns of x (N,) or (N, m), sampled at `rate` [Hz].

    Zero-phase filtering runs a Butterworth (or the Chebyshev of "decimate") forward and backward over the record
    extended at both ends by its odd reflection (Gautier & Poignet 2001, section 5.1: filtfilt); "forward" starts
    from the steady state of the first sample.

    Raises ConfigError for a cut-off outside (0, Nyquist) or an unknown kind, DataError for a record shorter than
    the padding or one with values that are not finite.
    """
    x = np.asarray(x, dtype=float)
    if settings.kind == "none":
        return x.copy()
    sos = design(rate, settings, decimation)
    if not np.isfinite(x).all():
        raise DataError("filter: the record holds NaN or inf; clean the data first")
    if settings.kind == "forward":
        return _forward(sos, x)
    padding = padding_length(sos)
    if len(x) <= padding:
        raise DataError(
            f"filter: {len(x)} samples are fewer than the {padding + 1} a {_name(settings, rate, decimation)} needs; "
            "record longer or raise the cut-off"
        )
    return signal.sosfiltfilt(sos, x, axis=0, padtype="odd", padlen=padding)


def design(rate: float, settings: Filter, decimation: int = 1) -> np.ndarray:
    """Second-order sections of the filter; see `low_pass` for the errors."""
    nyquist = 0.5 * rate
    if settings.kind == "decimate":
        if (decimation or 0) < 2:
            raise ConfigError(f"filter: kind 'decimate' with decimation {decimation}; set a decimation of 2 or more")
        band = CHEBYSHEV_BAND / decimation
        return signal.cheby1(CHEBYSHEV_ORDER, CHEBYSHEV_RIPPLE_DB, band, output="sos")
    if settings.kind not in ("zero-phase", "forward"):
        raise ConfigError(f"filter: unknown kind {settings.kind!r}; use zero-phase, forward, none or decimate")
    if settings.order < 1:
        raise ConfigError(f"filter: order {settings.order}; use 1 or more")
    if settings.cutoff is None:
        raise ConfigError("filter: no cut-off; set one, or take it from the closed loop first")
    if not 0.0 < settings.cutoff < nyquist:
        raise ConfigError(
            f"filter: cut-off {settings.cutoff:g} Hz is not between 0 and Nyquist, {nyquist:g} Hz; lower it"
        )
    return signal.butter(settings.order, settings.cutoff / nyquist, output="sos")


def padding_length(sos: np.ndarray) -> int:
    """Samples of odd reflection at each end: three times the filter's taps, SciPy's and Matlab's default."""
    taps = 2 * len(sos) + 1 - min((sos[:, 2] == 0.0).sum(), (sos[:, 5] == 0.0).sum())
    return 3 * int(taps)


def _forward(sos: np.ndarray, x: np.ndarray) -> np.ndarray:
    columns = x.reshape(len(x), -1)
    start = signal.sosfilt_zi(sos)[:, :, None] * columns[0]
    filtered, _ = signal.sosfilt(sos, columns, axis=0, zi=start)
    return filtered.reshape(x.shape)


def _name(settings: Filter, rate: float, decimation: int) -> str:
    return f"{settings.kind} filter at {cutoff_frequency(rate, settings, decimation):g} Hz"
