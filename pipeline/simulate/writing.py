"""A measured frame written as CSV or Parquet, in full precision, each column headed by its unit: `q_1 [rad]`.

What is written here can be read back as measured data without a mapping.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TextIO

import pandas as pd

from pipeline.errors import DataError
from pipeline.files import replacing


def check_output(path: str | None) -> None:
    """Refuse a file whose suffix is neither `.csv` nor `.parquet` (DataError); without one it is CSV."""
    if path is not None and Path(path).suffix.lower() not in ("", ".csv", ".parquet"):
        raise DataError(f"--output {path}: `{Path(path).suffix}` is not written; name a .csv or a .parquet file")


def write_frame(frame: pd.DataFrame, units: Mapping[str, str], target: str | TextIO) -> None:
    """Write a frame (index `time` s) to a file, whole or not at all, or to a stream, as CSV.

    units: by column, and of `time`. Raises DataError where a file cannot be written; what was there then stays.
    """
    table = frame.reset_index()
    table.columns = [f"{name} [{units[name]}]" if units.get(name) else name for name in table]
    if not isinstance(target, str):
        table.to_csv(target, index=False, lineterminator="\n")
        return
    path = Path(target)
    try:
        with replacing(path) as fresh:
            if path.suffix.lower() == ".parquet":
                table.astype(float).to_parquet(fresh, index=False, write_page_checksum=True)
            else:
                table.to_csv(fresh, index=False, lineterminator="\n")
    except OSError as error:
        raise DataError(f"{path}: cannot be written ({error.strerror or error}); give another --output") from error
