"""Measured data: columns of a file, mapped and converted to the measured frame, with time stamps that were checked."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from pipeline.errors import ConfigError, DataError
from pipeline.simulate.tables import Table, read_table
from pipeline.units import conversion

FRAME_COLUMN = re.compile(r"(q|qr|qdr|u|tau|pulse)_[1-9]\d*")
RATE_TOLERANCE = 1e-3  # of the mean sample rate: ten times what two clocks differ by


@dataclass(frozen=True)
class ColumnSettings:
    """Where a column of the frame comes from: value [to_unit] = scale · value of `source` [unit], converted, + offset.

    `scale` is without unit (a sign, a gear ratio); `offset` is in `to_unit`.
    """

    source: str
    unit: str
    to_unit: str
    scale: float = 1.0
    offset: float = 0.0


def read_measured(
    path: str | os.PathLike,
    columns: Mapping[str, ColumnSettings],
    rate: float,
    min_samples: int = 2,
    format: str | None = None,
) -> pd.DataFrame:
    """The measured frame of a CSV or MAT v5 file: index `time` [s], the other columns as mapped.

    columns: by the frame's name (`time`, `q_1`, `u_1`, …); rate [Hz]: what the experiment expects.
    Raises ConfigError for a wrong mapping, DataError in one line that names file, column and row for wrong data.
    """
    _check_mapping(columns)
    table = read_table(path, format)
    values = {name: _read_column(table, settings) for name, settings in columns.items()}
    _check_lengths(table, columns, values)
    time = values.pop("time")
    check_time(time, rate, table, columns["time"].source, min_samples)
    return pd.DataFrame(values, index=pd.Index(time, name="time"))


def with_force(frame: pd.DataFrame, gain: Sequence[float]) -> pd.DataFrame:
    """The frame with tau_i = gain_i · u_i, or with u_i = tau_i / gain_i where only the force was measured.

    gain (n,): N or N·m per unit of the plant's input. Raises DataError where joint i has neither column, or both.
    """
    frame = frame.copy()
    for i, g in enumerate(gain, start=1):
        if f"u_{i}" in frame and f"tau_{i}" in frame:
            raise DataError(f"joint {i}: both `u_{i}` and `tau_{i}` are mapped, but tau = gain·u; map one of them")
        if f"u_{i}" in frame:
            frame[f"tau_{i}"] = g * frame[f"u_{i}"]
        elif f"tau_{i}" in frame:
            frame[f"u_{i}"] = frame[f"tau_{i}"] / g
        else:
            raise DataError(f"joint {i}: neither `u_{i}` nor `tau_{i}` is mapped; map one of them")
    return frame


def check_time(time: np.ndarray, rate: float, table: Table, column: str, min_samples: int = 2) -> None:
    """Refuse time stamps (N,) [s] that repeat, go back, jump, have another rate [Hz] or are too few (DataError)."""
    if len(time) < max(min_samples, 2):
        raise DataError(f"{table.path}: {len(time)} samples, the experiment needs {max(min_samples, 2)}; record longer")
    steps, place = np.diff(time) * rate, f"{table.path}: column `{column}`"
    backwards = np.flatnonzero(steps <= 0.0)
    if backwards.size:
        k = backwards[0]
        verb = "repeats" if steps[k] == 0.0 else "goes back behind"
        raise DataError(
            f"{place}, row {table.row(k + 1)}: the time {time[k + 1]:.9g} s {verb} {time[k]:.9g} s; "
            "repair or cut the data"
        )
    if not 0.5 < np.median(steps) < 1.5:
        raise DataError(f"{place}: {_rate_differs(rate / np.median(steps), rate)}")
    jumps = np.flatnonzero((steps > 1.5) | (steps < 0.5))
    if jumps.size:
        k = jumps[0]
        raise DataError(
            f"{place}, row {table.row(k + 1)}: the time jumps from {time[k]:.9g} to {time[k + 1]:.9g} s, "
            f"{steps[k]:.3g} samples of {rate:g} Hz; repair or cut the data"
        )
    if abs(np.mean(steps) - 1.0) > RATE_TOLERANCE:
        raise DataError(f"{place}: {_rate_differs(rate / np.mean(steps), rate)}")


def _rate_differs(found: float, wanted: float) -> str:
    return f"sampled at {found:.6g} Hz, the experiment says {wanted:g} Hz; correct the rate or the unit of the time"


def _check_mapping(columns: Mapping[str, ColumnSettings]) -> None:
    for name in columns:
        if name != "time" and not FRAME_COLUMN.fullmatch(name):
            raise ConfigError(
                f"data column `{name}` is read by nothing; use time, q_1, u_1, tau_1, qr_1, qdr_1 or pulse_1"
            )
    for name in ("time", "q_1"):
        if name not in columns:
            raise ConfigError(f"data column `{name}` is not mapped; say which column of the file it is")


def _read_column(table: Table, settings: ColumnSettings) -> np.ndarray:
    try:
        factor = conversion(settings.unit, settings.to_unit)
    except ConfigError as error:
        raise DataError(f"{table.path}: column `{settings.source}`: {error}") from None
    return settings.scale * factor * table.column(settings.source) + settings.offset


def _check_lengths(table: Table, columns: Mapping[str, ColumnSettings], values: Mapping[str, np.ndarray]) -> None:
    expected = len(values["time"])
    for name, column in values.items():
        if len(column) != expected:
            raise DataError(
                f"{table.path}: column `{columns[name].source}` has {len(column)} samples, "
                f"`{columns['time'].source}` {expected}; store vectors of one length"
            )
