"""Measured data: columns of a file, mapped and converted to the measured frame, with time stamps that were checked."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isclose

import numpy as np
import pandas as pd

from pipeline.errors import ConfigError, DataError
from pipeline.simulate.headings import is_unit, split_heading
from pipeline.simulate.parquet import TimeStamps
from pipeline.simulate.tables import Table, read_table
from pipeline.units import conversion, parse

FRAME_COLUMN = re.compile(r"(q|qr|qdr|u|tau|pulse)_[1-9]\d*")
RATE_TOLERANCE = 1e-3  # of the mean sample rate: ten times what two clocks differ by


@dataclass(frozen=True)
class ColumnSettings:
    """Where a column of the frame comes from: value [to_unit] = scale · value of `source` [unit], converted, + offset.

    `unit` may be left to the heading in the file (`angle [deg]`); `scale` is without unit (a sign, a gear ratio);
    `offset` is in `to_unit`.
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
    units: Mapping[str, str] | None = None,
    delimiter: str | None = None,
    decimal: str | None = None,
) -> pd.DataFrame:
    """The measured frame of a CSV, Parquet or MAT v5 file: index `time` [s], the other columns as mapped.

    columns: by the frame's name (`time`, `q_1`, `u_1`, …); rate [Hz]: what the experiment expects; units: the frame's
    columns that need no mapping where the file has a heading of that name and a unit, and their units in the frame.
    Raises ConfigError for a wrong mapping, DataError in one line that names file, column and row for wrong data.
    """
    _check_names(columns)
    table = read_table(path, format, delimiter, decimal)
    columns = {**columns, **_unmapped(table, columns, units or {})}
    _check_complete(table, columns, units or {})
    values = {name: _read_column(table, name, settings) for name, settings in columns.items()}
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


def _check_names(columns: Mapping[str, ColumnSettings]) -> None:
    for name in columns:
        if name != "time" and not FRAME_COLUMN.fullmatch(name):
            raise ConfigError(
                f"data column `{name}` is read by nothing; use time, q_1, u_1, tau_1, qr_1, qdr_1 or pulse_1"
            )


def _unmapped(
    table: Table, columns: Mapping[str, ColumnSettings], units: Mapping[str, str]
) -> dict[str, ColumnSettings]:
    """The columns that the file itself names and gives a unit; a force and a command are one quantity: one is taken."""
    offered = {name for name, unit in map(split_heading, table.columns) if unit}
    if isinstance(table.columns.get("time"), TimeStamps):
        offered.add("time")
    found: dict[str, ColumnSettings] = {}
    for name in units:
        if name not in offered or name in columns:
            continue
        quantity, _, joint = name.rpartition("_")
        twin = {"u": f"tau_{joint}", "tau": f"u_{joint}"}.get(quantity)
        if twin not in columns and twin not in found:
            found[name] = ColumnSettings(name, "", units[name])
    return found


def _check_complete(table: Table, columns: Mapping[str, ColumnSettings], units: Mapping[str, str]) -> None:
    positions = [name for name in units if name.startswith("q_")] or ["q_1"]
    for name in ("time", *positions):
        if name not in columns:
            raise ConfigError(
                f"data column `{name}` is not mapped, and {table.path.name} has no column `{name} [unit]`; say in "
                "[data.columns] which column of the file it is"
            )


def _read_column(table: Table, name: str, settings: ColumnSettings) -> np.ndarray:
    unit = column_unit(table, name, settings)
    try:
        factor = conversion(unit, settings.to_unit)
    except ConfigError as error:
        raise DataError(f"{table.path}: column `{settings.source}`: {error}") from None
    stamps = table.seconds(settings.source) if name == "time" else None
    values = table.column(settings.source) if stamps is None else stamps
    return settings.scale * factor * values + settings.offset


def column_unit(table: Table, name: str, settings: ColumnSettings) -> str:
    """The unit of a column: of its heading or of the mapping; DataError where there is none, or two that differ."""
    heading = table.heading(settings.source)
    found, given, place = split_heading(heading)[1], settings.unit, f"{table.path}: column `{heading}`"
    if name == "time" and isinstance(table.columns[heading], TimeStamps):
        if given not in ("", "s"):
            raise DataError(f"{place} holds time stamps, `data.columns.time` says `{given}`; leave out its unit")
        return "s"
    if not found and not given:
        raise DataError(
            f"{place} has no unit; write `{heading} [unit]` in the file, or a unit in `data.columns.{name}`"
        )
    if not given or not found or not is_unit(found) or not is_unit(given):
        return given or found
    here, there = parse(found), parse(given)
    if here.exponents != there.exponents or here.offset != there.offset or not isclose(here.factor, there.factor):
        raise DataError(f"{place} is in `{found}`, `data.columns.{name}` says `{given}`; make them one")
    return given


def _check_lengths(table: Table, columns: Mapping[str, ColumnSettings], values: Mapping[str, np.ndarray]) -> None:
    expected = len(values["time"])
    for name, column in values.items():
        if len(column) != expected:
            raise DataError(
                f"{table.path}: column `{columns[name].source}` has {len(column)} samples, "
                f"`{columns['time'].source}` {expected}; store vectors of one length"
            )
