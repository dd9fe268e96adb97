"""A CSV file as text cells: its encoding, delimiter and decimal sign are found from its rows, or it is refused.

Nothing is guessed: where two readings fit, the refusal names the key that decides (`data.delimiter`, `data.decimal`).
"""

from __future__ import annotations

import codecs
import csv
import io
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from pipeline.errors import DataError

DELIMITERS = {",": "`,`", ";": "`;`", "\t": "tab", " ": "white space"}
MARKS = {codecs.BOM_UTF8: "utf-8", codecs.BOM_UTF16_LE: "utf-16-le", codecs.BOM_UTF16_BE: "utf-16-be"}
GERMAN = set("äöüÄÖÜß§°µ²³·±")  # what makes a file that is no UTF-8 certainly a German Excel's (Windows-1252)
SAMPLE = 200  # rows from which the delimiter is found

# What a cell says of the decimal sign. Three digits behind one sign may as well be a group of thousands.
COMMA = re.compile(r"[+-]?(\d*,\d+|\d+,)([eE][+-]?\d+)?")
POINT = re.compile(r"[+-]?(\d*\.\d+|\d+\.)([eE][+-]?\d+)?")
GROUP = re.compile(r"[+-]?[1-9]\d{0,2}[.,]\d{3}")
INTEGER = re.compile(r"[+-]?\d+([eE][+-]?\d+)?")

QUOTED_WORD = re.compile(r'(?<!\S)(?:"(?:[^"]|"")*"|[^\s"]+)(?!\S)')


@dataclass(frozen=True)
class Cells:
    """The rows of a file as text, the header first; all as long as the header. `decimal` is its decimal sign."""

    rows: list[list[str]]
    decimal: str


def read_cells(path: Path, delimiter: str | None = None, decimal: str | None = None) -> Cells:
    """The cells of a CSV file with one header row; DataError where it has none, is ragged or can be read two ways.

    delimiter (`,` `;` tab or blank, which is any white space) and decimal (`.` `,`): None where they are to be found.
    """
    text = decode(path)
    delimiter = delimiter or find_delimiter(path, text)
    try:
        rows = list(_split(text, delimiter))
    except csv.Error as error:
        raise DataError(
            f"{path}: not a CSV file ({error}); export it again, or name what "
            'divides it by `data.delimiter` (" " for white space)'
        ) from None
    while rows and not any(cell.strip() for cell in rows[-1]):
        rows.pop()
    if not rows:
        raise DataError(f"{path}: the file holds no header; its first row must name the columns")
    for number, row in enumerate(rows[1:], start=2):
        if len(row) != len(rows[0]):
            raise DataError(f"{path}: row {number} has {len(row)} cells, the header {len(rows[0])}; repair the row")
    return Cells(rows, decimal or find_decimal(path, rows[1:], delimiter))


def decode(path: Path) -> str:
    """The text of a file in UTF-8, in UTF-16 with its mark, or certainly in Windows-1252; else DataError."""
    data = path.read_bytes()
    wide = data.startswith((codecs.BOM_UTF32_LE, codecs.BOM_UTF32_BE))
    mark = next((mark for mark in MARKS if data.startswith(mark) and not wide), b"")
    try:
        text = data[len(mark) :].decode(MARKS.get(mark, "utf-8"))
    except UnicodeDecodeError as error:
        text = data.decode("cp1252", errors="replace")
        if mark or not {c for c in text if ord(c) > 127} <= GERMAN:
            raise DataError(f"{path}: not text in UTF-8 ({error}); export it again as UTF-8") from None
    if "\0" in text:
        raise DataError(f"{path}: not text in UTF-8 (it holds NUL bytes); export it again as UTF-8")
    return text


def find_delimiter(path: Path, text: str) -> str:
    """The delimiter that divides the first rows into as many cells as the header, two at least.

    Where several do, the one that leaves nothing but numbers; white space where none does.
    """
    fitting = {d: rows for d in (",", ";", "\t") if (rows := _even_rows(text, d))}
    if not fitting and _even_rows(text, " "):
        return " "
    if len(fitting) > 1:
        numeric = {d: rows for d, rows in fitting.items() if all(_numeric(cell) for row in rows[1:] for cell in row)}
        fitting = numeric if len(numeric) == 1 else fitting
    if len(fitting) > 1:
        raise DataError(
            f"{path}: its rows can be divided at {' or '.join(DELIMITERS[d] for d in fitting)}; "
            "say which by `data.delimiter`"
        )
    header = text.partition("\n")[0]
    return next(iter(fitting), None) or max((",", ";", "\t"), key=header.count)


def find_decimal(path: Path, rows: Sequence[Sequence[str]], delimiter: str) -> str:
    """The decimal sign that the numbers show; `.` where they are all whole. DataError where it stays open."""
    seen = {kind: next(cells, None) for kind, cells in _signs(rows).items()}
    if seen["comma"] and seen["point"]:
        raise DataError(
            f"{path}: {seen['comma']} has a decimal comma, {seen['point']} a decimal point; make them one, or say "
            "which it is by `data.decimal`"
        )
    if seen["comma"] or seen["point"]:
        return "," if seen["comma"] else "."
    group = seen["comma group"] or (seen["point group"] if delimiter != "," else None)
    if group:
        raise DataError(
            f"{path}: {group} may have a decimal sign or a thousands separator; say which by `data.decimal`"
        )
    return "."


def _signs(rows: Sequence[Sequence[str]]) -> dict[str, Iterator[str]]:
    """The cells, with their places, that show a decimal comma or point, or what may be a group of thousands."""

    def cells(sign: str, pattern: re.Pattern, group: bool) -> Iterator[str]:
        for number, row in enumerate(rows, start=2):
            for cell in row:
                if sign in cell and pattern.fullmatch(cell.strip()) and bool(GROUP.fullmatch(cell.strip())) == group:
                    yield f"`{cell.strip()}` in row {number}"

    return {
        "comma": cells(",", COMMA, False),
        "point": cells(".", POINT, False),
        "comma group": cells(",", COMMA, True),
        "point group": cells(".", POINT, True),
    }


def _split(text: str, delimiter: str) -> Iterator[list[str]]:
    lines = io.StringIO(text, newline="")
    if delimiter == " ":
        return (_words(line) for line in lines)
    return csv.reader(lines, delimiter=delimiter, strict=True)


def _words(line: str) -> list[str]:
    """The words of a line, those in quotes (`"q_1 [rad]"`, a quote in them doubled) kept whole. Raises csv.Error."""
    if '"' not in line:
        return line.split()
    if QUOTED_WORD.sub("", line).strip():
        raise csv.Error("a quote inside a word, or one that is not closed")
    return [w[1:-1].replace('""', '"') if w.startswith('"') else w for w in QUOTED_WORD.findall(line)]


def _even_rows(text: str, delimiter: str) -> list[list[str]]:
    """The first rows, where the delimiter divides each into as many cells as the header, two at least; else []."""
    try:
        rows = [row for row in islice(_split(text, delimiter), SAMPLE) if any(cell.strip() for cell in row)]
    except csv.Error:
        return []
    return rows if rows and len(rows[0]) > 1 and {len(row) for row in rows} == {len(rows[0])} else []


def _numeric(cell: str) -> bool:
    cell = cell.strip()
    return any(pattern.fullmatch(cell) for pattern in (INTEGER, POINT, COMMA))
