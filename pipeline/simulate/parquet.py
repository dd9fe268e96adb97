"""Columns of a Parquet file, its index among them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
from pandas.api import types

from pipeline.simulate.matfile import NotNumbers


class ParquetError(ValueError):
    """A file that is no readable Parquet; the message says why, without the file's name."""


@dataclass(frozen=True)
class TimeStamps:
    """A column of dates or durations: `seconds` (N,), of dates since the first one."""

    seconds: np.ndarray


def read_columns(path: Path) -> dict[str, np.ndarray | NotNumbers | TimeStamps]:
    """The file's columns by name, (N, 1) where they are numbers; raises ParquetError."""
    try:
        frame = pd.read_parquet(path, engine="pyarrow", page_checksum_verification=True)
    except (pa.ArrowException, OSError, ValueError, TypeError, LookupError) as error:
        raise ParquetError(f"not a readable Parquet file ({' '.join(str(error).split())[:160]})") from None
    if not isinstance(frame.index, pd.RangeIndex) or frame.index.name is not None:
        frame.index = frame.index.set_names([name or "index" for name in frame.index.names])
        frame = frame.reset_index(allow_duplicates=True)
    names = [" ".join(str(name).split()) for name in frame.columns]
    for name in names:
        if names.count(name) > 1:
            raise ParquetError(f"the column `{name}` stands in it twice")
    return {name: _values(frame.iloc[:, i]) for i, name in enumerate(names)}


def _values(column: pd.Series) -> np.ndarray | NotNumbers | TimeStamps:
    if types.is_datetime64_any_dtype(column) and len(column):
        return TimeStamps((column - column.iloc[0]).dt.total_seconds().to_numpy(float))
    if types.is_timedelta64_dtype(column):
        return TimeStamps(column.dt.total_seconds().to_numpy(float))
    if types.is_bool_dtype(column):
        return NotNumbers("truth values")
    if types.is_numeric_dtype(column) and not types.is_complex_dtype(column):
        return column.to_numpy(float, na_value=np.nan).reshape(-1, 1)
    return NotNumbers("text" if types.is_string_dtype(column) else f"values of the kind {column.dtype}")
