"""Modelica's operators and built-in functions on CasADi scalars, and on arrays of them."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca

from pipeline.export.arrays import Value, elementwise, flatten, matmul, stack

BINARY: dict[str, Callable] = {
    "add": lambda a, b: a + b,
    "subtract": lambda a, b: a - b,
    "multiply": lambda a, b: a * b,
    "divide": lambda a, b: a / b,
    "power": lambda a, b: a**b,
    "equal": lambda a, b: a == b,
    "not_equal": lambda a, b: a != b,
    "less": lambda a, b: a < b,
    "less_equal": lambda a, b: a <= b,
    "greater": lambda a, b: a > b,
    "greater_equal": lambda a, b: a >= b,
    "and": ca.logic_and,
    "or": ca.logic_or,
}
UNARY: dict[str, Callable] = {"plus": lambda a: a, "negate": lambda a: -a, "not": ca.logic_not}
FUNCTIONS: dict[str, Callable] = {
    "abs": ca.fabs, "sign": ca.sign, "sqrt": ca.sqrt, "sin": ca.sin, "cos": ca.cos, "tan": ca.tan, "asin": ca.asin,
    "acos": ca.acos, "atan": ca.atan, "atan2": ca.atan2, "sinh": ca.sinh, "cosh": ca.cosh, "tanh": ca.tanh,
    "exp": ca.exp, "log": ca.log, "log10": ca.log10,
}  # fmt: skip
# These have steps, and Modelica lets them cause events (Modelica language specification 3.6, section 3.7.2).
STEPS: dict[str, Callable] = {"floor": ca.floor, "ceil": ca.ceil, "integer": ca.floor}


def fold(operation: Callable, *values: Value, start: float | None = None) -> Value:
    """An operation over all elements; `start` is the result of none."""
    items = [item for value in values for item in flatten(value)]
    total = ca.SX(start) if start is not None else items.pop(0)
    for item in items:
        total = operation(total, item)
    return total


def cross(a: tuple, b: tuple) -> tuple:
    """The vector product of two vectors (3,)."""
    return matmul(skew(a), b)


def skew(a: tuple) -> tuple:
    """The matrix (3, 3) that gives the vector product with a (3,)."""
    zero = ca.SX(0)
    return ((zero, -a[2], a[1]), (a[2], zero, -a[0]), (-a[1], a[0], zero))


def diagonal(a: tuple) -> tuple:
    """The matrix (n, n) with a (n,) on its diagonal."""
    return tuple(tuple(a[i] if i == k else ca.SX(0) for k in range(len(a))) for i in range(len(a)))


def transpose(a: tuple) -> tuple:
    """The matrix (m, n) of a matrix (n, m)."""
    return tuple(zip(*a, strict=True))


ARRAYS: dict[str, Callable[..., Value]] = {
    "no_event": lambda a: a,
    "homotopy": lambda actual, simplified: actual,
    "smooth": lambda order, a: a,
    "min": lambda *values: fold(ca.fmin, *values),
    "max": lambda *values: fold(ca.fmax, *values),
    "sum": lambda a: fold(lambda x, y: x + y, a, start=0),
    "product": lambda a: fold(lambda x, y: x * y, a, start=1),
    "transpose": transpose,
    "promoted_cat1": lambda *values: stack(list(values), "1"),
    "promoted_cat2": lambda *values: stack(list(values), "2"),
    "cross": cross,
    "skew": skew,
    "diagonal": diagonal,
    "outer_product": lambda a, b: tuple(elementwise(lambda x, y: x * y, x, b) for x in a),
    "vector": lambda a: tuple(flatten(a)),
}
