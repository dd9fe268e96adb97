"""Tables of named columns from CSV and MAT v5 files. Every refusal is one line naming file, column and row.

A row is counted from 1 as the user sees it: the line of a CSV file (line 1 is the header), the sample of a MAT vector.
"""

from __future__ import annotations

import csv
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from pipeline.errors import DataError
from pipeline.simulate.matfile import MatError, NotNumbers, read_variables

DELIMITERS = (",", ";", "\t")


@dataclass(frozen=True)
class Table:
    """Columns by name as they stand in the file: text cells (CSV), arrays or NotNumbers (MAT).

    `first_row` is the row number of the first sample, so that messages point into the file.
    """

    path: Path
    columns: Mapping[str, Sequence[str] | np.ndarray | NotNumbers]
    first_row: int

    def column(self, name: str) -> np.ndarray:
        """The finite numbers of a column (N,) float64; DataError where it is missing, no vector or not all numbers."""
        if name not in self.columns:
            raise DataError(f"{self.path}: no column `{name}`; {self._nearest(name)}")
        cells = self.columns[name]
        if isinstance(cells, NotNumbers):
            raise DataError(f"{self.path}: column `{name}` holds {cells.kind}; store a real vector")
        values = self._vector(name, cells) if isinstance(cells, np.ndarray) else self._numbers(name, cells)
        bad = np.flatnonzero(~np.isfinite(values))
        if bad.size:
            raise DataError(
                f"{self._place(name, bad[0])}: {values[bad[0]]} is not a finite number; repair or cut the data"
            )
        return values

    def row(self, index: int) -> int:
        """The row in the file of the sample `index` (counted from 0)."""
        return int(index) + self.first_row

    def _place(self, name: str, index: int) -> str:
        return f"{self.path}: column `{name}`, row {self.row(index)}"

    def _nearest(self, name: str) -> str:
        folded = {known.casefold(): known for known in self.columns}
        near = [folded[match] for match in get_close_matches(name.casefold(), folded, n=3, cutoff=0.4)]
        return f"nearest: {_quoted(near)}" if near else f"it has {_quoted(list(self.columns)[:12])}"

    def _vector(self, name: str, values: np.ndarray) -> np.ndarray:
        if values.ndim != 2 or min(values.shape) != 1:
            shape = "×".join(map(str, values.shape))
            raise DataError(f"{self.path}: column `{name}` is a {shape} array; store a vector (N×1)")
        return values.ravel().astype(float)

    def _numbers(self, name: str, cells: Sequence[str]) -> np.ndarray:
        values = np.empty(len(cells))
        for index, cell in enumerate(cells):
            try:
                values[index] = _number(cell)
            except ValueError:
                shown = cell if len(cell) <= 40 else cell[:37] + "..."
                hint = "; write the decimal point as `.`" if "," in cell else "; repair or cut the data"
                raise DataError(f"{self._place(name, index)}: {shown!r} is not a number{hint}") from None
        return values


def read_table(path: str | os.PathLike, format: str | None = None) -> Table:
    """Read a "csv" or "mat" file (None: by its suffix); DataError where it is missing, empty or of another kind."""
    path = Path(path)
    format = format or path.suffix.lstrip(".").lower()
    readers = {"csv": read_csv, "mat": read_mat}
    if format not in readers:
        raise DataError(f"{path}: format `{format}` is not read; give a .csv or a .mat (v5) file")
    if not path.is_file():
        raise DataError(f"{path}: no such file; correct the path of the data")
    if path.stat().st_size == 0:
        raise DataError(f"{path}: the file is empty; record or export it again")
    return readers[format](path)


def read_csv(path: Path) -> Table:
    """A CSV file with one header row; delimiter `,`, `;` or tab, whichever the header has most; UTF-8."""
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            header = file.readline()
            delimiter = max(DELIMITERS, key=header.count)
            file.seek(0)
            rows = list(csv.reader(file, delimiter=delimiter, strict=True))
    except (UnicodeDecodeError, csv.Error) as error:
        raise DataError(f"{path}: not a CSV file in UTF-8 ({error}); export it again") from None
    while rows and not any(cell.strip() for cell in rows[-1]):
        rows.pop()
    if not rows:
        raise DataError(f"{path}: the file holds no header; its first row must name the columns")
    names = [" ".join(name.split()) for name in rows[0]]
    _check_header(path, names)
    for number, row in enumerate(rows[1:], start=2):
        if len(row) != len(names):
            raise DataError(f"{path}: row {number} has {len(row)} cells, the header {len(names)}; repair the row")
    cells = list(zip(*rows[1:], strict=True)) or [()] * len(names)
    return Table(path, dict(zip(names, cells, strict=True)), first_row=2)


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


def _number(cell: str) -> float:
    if "_" in cell:  # Python's float() takes 1_000
        raise ValueError(cell)
    return float(cell)


def _is_number(cell: str) -> bool:
    try:
        return not math.isnan(_number(cell))
    except ValueError:
        return False


def _quoted(names: Sequence[str]) -> str:
    return ", ".join(f"`{name}`" for name in names) or "no column"
