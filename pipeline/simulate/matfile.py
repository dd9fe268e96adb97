"""Numeric variables of a MAT v5 file (MATLAB's -v6 and -v7), read with every length checked.

SciPy's reader crashes the process on a damaged file; this one raises. Format: The MathWorks, "MAT-File Format",
chapter 1: a 128-byte header, then data elements, each a tag (type, length) and its data, padded to 8 bytes.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

MATRIX, COMPRESSED = 14, 15
STORAGE = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
NUMERIC_CLASSES = range(6, 16)
KINDS = {1: "cells", 2: "a structure", 3: "an object", 4: "text", 5: "a sparse matrix", 16: "a function"}
COMPLEX = 0x0800


class MatError(ValueError):
    """A file that is not MAT v5, or is damaged; the message says how, without the file's name."""


@dataclass(frozen=True)
class NotNumbers:
    """A variable that is no array of real numbers; `kind` says what it is."""

    kind: str


def read_variables(path: Path) -> dict[str, np.ndarray | NotNumbers]:
    """The file's variables by name, in their shapes; raises MatError."""
    data = path.read_bytes()
    order = _byte_order(data)
    variables: dict[str, np.ndarray | NotNumbers] = {}
    for kind, content in _elements(memoryview(data)[128:], order):
        if kind == COMPRESSED:
            try:
                inner = memoryview(zlib.decompress(content))
            except zlib.error as error:
                raise MatError(f"damaged: {error}") from None
            kind, content = next(_elements(inner, order), (0, inner))
        if kind == MATRIX:
            name, value = _matrix(content, order)
            if name in variables:
                raise MatError(f"the variable `{name}` stands in it twice")
            if name:
                variables[name] = value
    return variables


def _byte_order(data: bytes) -> str:
    if data.startswith((b"MATLAB 7.3 MAT-file", b"\x89HDF\r\n")):
        raise MatError("a MAT v7.3 (HDF5) file")
    mark = data[124:128]
    if mark == b"\x00\x01IM":
        return "<"
    if mark == b"\x01\x00MI":
        return ">"
    raise MatError("not a MAT v5 file")


def _elements(data: memoryview, order: str) -> Iterator[tuple[int, memoryview]]:
    """(type, content) of each data element; a tag with a length in its upper half holds its data itself."""
    at = 0
    while at < len(data):
        if at + 8 > len(data):
            raise MatError("damaged: it ends within a tag")
        kind, length = struct.unpack_from(order + "II", data, at)
        begin = at + 8
        if kind >> 16:
            kind, length, begin = kind & 0xFFFF, kind >> 16, at + 4
            if length > 4:
                raise MatError("damaged: a short element that is too long")
        if begin + length > len(data):
            raise MatError("damaged: it ends within a variable")
        yield kind, data[begin : begin + length]
        at = begin + length if kind == COMPRESSED else (begin + length + 7) // 8 * 8


def _matrix(content: memoryview, order: str) -> tuple[str, np.ndarray | NotNumbers]:
    parts = _elements(content, order)
    flags = _numbers(next(parts, None), order)
    if len(flags) == 0:
        raise MatError("damaged: a variable without its class")
    number_class = int(flags[0]) & 0xFF
    if number_class not in (*NUMERIC_CLASSES, *KINDS):
        return "", NotNumbers("something unknown")
    shape, letters = _numbers(next(parts, None), order), _numbers(next(parts, None), order)
    name = letters.astype("u1").tobytes().decode("latin-1")
    if name and not (name.isascii() and name.isidentifier()):
        raise MatError("damaged: a variable whose name is none")
    if number_class in KINDS:
        return name, NotNumbers(KINDS[number_class])
    if int(flags[0]) & COMPLEX:
        return name, NotNumbers("complex numbers")
    values = _numbers(next(parts, None), order)
    if np.any(shape < 0) or np.prod(shape, dtype=float) != len(values):
        raise MatError(f"damaged: `{name}` has {len(values)} numbers for the shape {'×'.join(map(str, shape))}")
    return name, values.reshape([int(n) for n in shape], order="F")


def _numbers(element: tuple[int, memoryview] | None, order: str) -> np.ndarray:
    kind, content = element or (0, b"")
    if kind not in STORAGE:
        raise MatError("damaged: a variable with a part missing")
    dtype = np.dtype(order + STORAGE[kind])
    if len(content) % dtype.itemsize:
        raise MatError("damaged: a part of a variable is cut")
    return np.frombuffer(content, dtype)
