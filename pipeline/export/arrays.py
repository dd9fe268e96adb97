"""Arrays of CasADi scalars as nested tuples: rank is the depth of nesting, the order is row by row."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import product

import casadi as ca

Value = ca.SX | tuple
Pick = int | list[int] | slice | ca.SX  # a subscript, counted from 0


class Record(tuple):
    """The fields of a record, in the order of their declaration."""


def elementwise(operation: Callable, *values: Value) -> Value:
    """operation(a, b, …) element by element; scalars go with every element."""
    size = {len(value) for value in values if isinstance(value, tuple)}
    if not size:
        return operation(*values)
    (n,) = size
    columns = [value if isinstance(value, tuple) else (value,) * n for value in values]
    kind = next(type(value) for value in values if isinstance(value, tuple))
    return kind(elementwise(operation, *items) for items in zip(*columns, strict=True))


def matmul(left: tuple, right: tuple) -> Value:
    """The product of matrices (n, m) and vectors (m,) in Modelica's sense; two vectors give their scalar product."""
    if not isinstance(left[0], tuple):
        return matmul((left,), right)[0]
    if isinstance(right[0], tuple):
        columns = list(zip(*right, strict=True))
        return tuple(tuple(dot(row, column) for column in columns) for row in left)
    return tuple(dot(row, right) for row in left)


def dot(left: tuple, right: tuple) -> ca.SX:
    """The scalar product of two vectors (n,)."""
    total = ca.SX(0)
    for a, b in zip(left, right, strict=True):
        total = total + a * b
    return total


def stack(values: list[Value], axis: str) -> tuple:
    """Matrices one under the other (axis "1") or side by side ("2"); a scalar is 1 by 1, a vector a column."""
    matrices = [promote(value) for value in values]
    if axis == "1":
        return tuple(row for matrix in matrices for row in matrix)
    return tuple(tuple(item for row in rows for item in row) for rows in zip(*matrices, strict=True))


def promote(value: Value) -> tuple:
    """A scalar or a vector as a matrix."""
    if not isinstance(value, tuple):
        return ((value,),)
    return value if isinstance(value[0], tuple) else tuple((item,) for item in value)


def matrix_power(base: tuple, exponent: int) -> tuple:
    """A square matrix (n, n) times itself; the exponent must not be negative."""
    if exponent < 0:
        raise ValueError(f"a matrix to the power of {exponent}")
    power = unit_matrix(len(base))
    for _ in range(exponent):
        power = matmul(power, base)
    return power


def unit_matrix(n: int) -> tuple:
    """The unit matrix (n, n)."""
    return tuple(tuple(ca.SX(float(i == k)) for k in range(n)) for i in range(n))


def index(value: Value, picks: list[Pick]) -> Value:
    """value[i, :, {j, k}, …]; IndexError where there is no such element.

    An index that is an expression picks when the FMU runs: not a number where there is no such element.
    """
    if not picks:
        return value
    first, rest = picks[0], picks[1:]
    if isinstance(first, ca.SX):
        picked = elementwise(lambda item: ca.SX.nan(), index(value[0], rest))
        for k, item in enumerate(value):
            picked = elementwise(lambda a, b, k=k: ca.if_else(first == k, a, b), index(item, rest), picked)
        return picked
    if isinstance(first, int):
        return index(value[check(first, value)], rest)
    return tuple(index(value[k], rest) for k in positions(first, value))


def update(value: Value, picks: list[Pick], new: Value) -> Value:
    """The array with the element or slice at `picks` replaced."""
    if not picks:
        return new
    first, rest = picks[0], picks[1:]
    if isinstance(first, ca.SX):
        choose = [lambda a, b, k=k: ca.if_else(first == k, a, b) for k in range(len(value))]
        return tuple(elementwise(choose[k], update(item, rest, new), item) for k, item in enumerate(value))
    if isinstance(first, int):
        replaced = {check(first, value): new}
    else:
        replaced = dict(zip(positions(first, value), new, strict=True))
    return tuple(update(item, rest, replaced[k]) if k in replaced else item for k, item in enumerate(value))


def positions(pick: list[int] | slice, value: tuple) -> list[int]:
    """The indices that a slice stands for."""
    return list(range(len(value))) if isinstance(pick, slice) else [check(k, value) for k in pick]


def check(k: int, value: tuple) -> int:
    """The index k itself; IndexError where the array has no such element: -1 is none in Modelica."""
    if not 0 <= k < len(value):
        raise IndexError(f"index {k + 1} of an array of {len(value)}")
    return k


def flatten(value: Value) -> list[ca.SX]:
    """The elements row by row."""
    return [item for part in value for item in flatten(part)] if isinstance(value, tuple) else [value]


def unflatten(items: Iterator, dimensions: list[int]) -> Value:
    """The inverse of flatten: an array of these dimensions from an iterator of its elements."""
    if not dimensions:
        return next(items)
    return tuple(unflatten(items, dimensions[1:]) for _ in range(dimensions[0]))


def subscripts(dimensions: list[int]) -> list[str]:
    """Subscripts [1,1], [1,2], … row by row; one empty for a scalar."""
    if not dimensions:
        return [""]
    return [f"[{','.join(map(str, item))}]" for item in product(*(range(1, n + 1) for n in dimensions))]


def size(value: Value, dimension: int) -> int:
    """The length along a dimension, counted from 1."""
    return len(value) if dimension == 1 else size(value[0], dimension - 1)


def to_int(value: Value) -> int | None:
    """A constant integer, or None where the value is anything else."""
    if isinstance(value, tuple) or not value.is_constant():
        return None
    number = float(value)
    return int(number) if number == int(number) else None
