"""Typed settings of an experiment."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Filter:
    """A low-pass filter: Butterworth with `cutoff` [Hz] and `order`, or the usual decimation filter.

    "zero-phase" runs forward and backward, "forward" only forward (it lags), "none" passes the signal through;
    "decimate" is the 8th-order Chebyshev type I filter (0.05 dB, 0.8·Nyquist/decimation), forward and backward.
    """

    kind: Literal["zero-phase", "forward", "none", "decimate"]
    cutoff: float = 0.0
    order: int = 4


@dataclass(frozen=True)
class WlsSettings:
    """How one WLS variant filters: the position, then y and every column of W in parallel, then 1 of `decimation`.

    border: samples cut at the (beginning, end), counted at the original rate; half_sample: align the torque held
    over a sample with the position measured at its end.
    """

    name: str
    position: Filter
    parallel: Filter
    decimation: int = 1
    border: tuple[int, int] = (0, 0)
    half_sample: bool = True
