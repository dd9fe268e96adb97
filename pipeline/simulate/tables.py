"""Tables of named columns from CSV, Parquet and MAT v5 files. Every refusal is one line: file, column, row.

A row is counted from 1 as the user sees it: the line of a CSV file (line 1 is the header), else the sample.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from pipeline.errors import DataError
from pipeline.simulate.csvfile import read_cells
from pipeline.simulate.headings import split_heading
from pipeline.simulate.matfile import MatError, NotNumbers, read_variables
from pipeline.simulate.parquet import ParquetError, TimeStamps, read_columns


@dataclass(frozen=True)
class Table:
    """Columns by heading as they stand in the file: text cells (CSV), or arrays, TimeStamps, NotNumbers.

    `first_row` is the row number of the first sample, so that messages point into the file; `decimal` the sign of a
    CSV file's numbers.
    """

    path: Path
    columns: Mapping[str, Sequence[str] | np.ndarray | NotNumbers | TimeStamps]
    first_row: int
    decimal: str = "."

    def heading(self, name: str) -> str:
        """The heading that `name` means: the whole of it, or all but its unit. DataError where there is not one."""
        name = " ".join(name.split())
        if name in self.columns:
            return name
        found = [heading for heading in self.columns if split_heading(heading)[0] == name]
        if len(found) > 1:
            raise DataError(f"{self.path}: {_quoted(found)} are all called `{name}`; name one in full")
        if not found:
            raise DataError(f"{self.path}: no column `{name}`; {self._nearest(name)}")
        return found[0]

    def column(self, name: str) -> np.ndarray:
        """The finite numbers of a column (N,) float64; DataError where it is missing, no vector or not all numbers."""
        name = self.heading(name)
        cells = self.columns[name]
        if isinstance(cells, TimeStamps):
            raise DataError(f"{self.path}: column `{name}` holds time stamps; only `time` may, store real numbers")
        if isinstance(cells, NotNumbers):
            raise DataError(f"{self.path}: column `{name}` holds {cells.kind}; store a real vector")
        return self._finite(
            name, self._vector(name, cells) if isinstance(cells, np.ndarray) else self._numbers(name, cells)
        )

    def seconds(self, name: str) -> np.ndarray | None:
        """The time stamps of a column in s (N,), since the first one where they are dates; None where it has none."""
        heading = self.heading(name)
        cells = self.columns[heading]
        return self._finite(heading, cells.seconds) if isinstance(cells, TimeStamps) else None

    def row(self, index: int) -> int:
        """The row in the file of the sample `index` (counted from 0)."""
        return int(index) + self.first_row

    def _finite(self, name: str, values: np.ndarray) -> np.ndarray:
        bad = np.flatnonzero(~np.isfinite(values))
        if bad.size:
            raise DataError(
                f"{self._place(name, bad[0])}: {values[bad[0]]} is not a finite number; repair or cut the data"
            )
        return values

    def _place(self, name: str, index: int) -> str:
        return f"{self.path}: column `{name}`, row {self.row(index)}"

    def _nearest(self, name: str) -> str:
        folded = {
            known.casefold(): heading for heading in self.columns for known in (split_heading(heading)[0], heading)
        }
        near = [folded[match] for match in get_close_matches(name.casefold(), folded, n=3, cutoff=0.4)]
        return (
            f"nearest: {_quoted(list(dict.fromkeys(near)))}" if near else f"it has {_quoted(list(self.columns)[:12])}"
        )

    def _vector(self, name: str, values: np.ndarray) -> np.ndarray:
        if values.ndim != 2 or min(values.shape) != 1:
            shape = "×".join(map(str, values.shape))
            raise DataError(f"{self.path}: column `{name}` is a {shape} array; store a vector (N×1)")
        return values.ravel().astype(float)

    def _numbers(self, name: str, cells: Sequence[str]) -> np.ndarray:
        values = np.empty(len(cells))
        for index, cell in enumerate(cells):
            try:
                values[index] = _number(cell, self.decimal)
            except ValueError:
                shown = cell if len(cell) <= 40 else cell[:37] + "..."
                remedy = self._remedy(cell)
                raise DataError(f"{self._place(name, index)}: {shown!r} is not a number; {remedy}") from None
        return values

    def _remedy(self, cell: str) -> str:
        if any(c.isdigit() for c in cell) and any(sign in cell.strip() for sign in ",.' \u00a0\u202f"):
            return f"the decimal sign here is `{self.decimal}`, and thousands are not separated"
        return "repair or cut the data"


def read_table(
    path: str | os.PathLike, format: str | None = None, delimiter: str | None = None, decimal: str | None = None
) -> Table:
    """Read a "csv", "parquet" or "mat" file (None: by its suffix); DataError where it is missing, empty or of no kind.

    delimiter, decimal: of a CSV file, where they are not to be found from it.
    """
    path = Path(path)
    format = format or path.suffix.lstrip(".").lower()
    if format not in ("csv", "parquet", "mat"):
        raise DataError(f"{path}: format `{format}` is not read; give a .csv, a .parquet or a .mat (v5) file")
    if not path.is_file():
        raise DataError(f"{path}: no such file; correct the path of the data")
    if path.stat().st_size == 0:
        raise DataError(f"{path}: the file is empty; record or export it again")
    if format == "csv":
        return read_csv(path, delimiter, decimal)
    return read_parquet(path) if format == "parquet" else read_mat(path)


def read_csv(path: Path, delimiter: str | None = None, decimal: str | None = None) -> Table:
    """A CSV file with one header row (see csvfile.read_cells)."""
    cells = read_cells(path, delimiter, decimal)
    names = [" ".join(name.split()) for name in cells.rows[0]]
    _check_header(path, names)
    columns = list(zip(*cells.rows[1:], strict=True)) or [()] * len(names)
    return Table(path, dict(zip(names, columns, strict=True)), first_row=2, decimal=cells.decimal)


def read_parquet(path: Path) -> Table:
    """A Parquet file: each column, and the index, a column."""
    try:
        return Table(path, read_columns(path), first_row=1)
    except ParquetError as error:
        raise DataError(f"{path}: {error}; write it again") from None


def read_mat(path: Path) -> Table:
    """A MAT v5 file (MATLAB's -v6 and -v7): each variable a column."""
    try:
        return Table(path, read_variables(path), first_row=1)
    except MatError as error:
        raise DataError(f"{path}: {error}; save it again with MATLAB's `save(..., '-v7')`") from None


def _check_header(path: Path, names: list[str]) -> None:
    if all(_is_number(name) for name in names):
        raise DataError(f"{path}: row 1 holds numbers, not names; add a header row that names the columns")
    for index, name in enumerate(names):
        if not name:
            raise DataError(f"{path}: column {index + 1} has no name in row 1; name it")
        if name in names[:index]:
            raise DataError(f"{path}: column `{name}` stands twice in row 1; rename one")


def _number(cell: str, decimal: str) -> float:
    other = "." if decimal == "," else ","
    if "_" in cell or other in cell:  # Python's float() takes 1_000
        raise ValueError(cell)
    return float(cell.replace(",", "."))


def _is_number(cell: str) -> bool:
    return any(_reads_as(cell, decimal) for decimal in ".,")


def _reads_as(cell: str, decimal: str) -> bool:
    try:
        return not math.isnan(_number(cell, decimal))
    except ValueError:
        return False


def _quoted(names: Sequence[str]) -> str:
    return ", ".join(f"`{name}`" for name in names) or "no column"
