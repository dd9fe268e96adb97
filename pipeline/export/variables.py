"""The scalar variables of a model, as the FMU shows them: kind, start value, unit and description.

Kinds, in the order in which their values stand in the FMU's memory:
constant     known when the FMU is built (folded into the equations by the front end, so never settable)
parameter    settable
calculated   a parameter computed from others
state, discrete, input
derivative   of a state
algebraic    computed from all of the above; most outputs
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca

from pipeline.export.arrays import Value, elementwise, flatten, subscripts, unflatten
from pipeline.export.expressions import Expressions, Scope
from pipeline.export.frontend import Source

KINDS = ("constant", "parameter", "calculated", "state", "discrete", "input", "derivative", "algebraic")
TYPES = {"real": "Real", "integer": "Integer", "boolean": "Boolean", "enumeration": "Integer"}
KIND_OF_ROLE = {
    "constant": "constant", "parameter": "parameter", "input": "input", "state": "state", "algebraic": "algebraic",
    "output": "algebraic", "discrete_real": "discrete", "discrete_value": "discrete",
}  # fmt: skip
COORDINATE = {role: {"constant": "parameter", "output": "algebraic"}.get(role, role) for role in KIND_OF_ROLE}


@dataclass
class Variable:
    """One scalar. `start` is a number where it is one, else None: then it follows from parameters."""

    name: str
    kind: str
    symbol: ca.SX
    type: str = "Real"
    output: bool = False
    tunable: bool = False
    start: float | None = None
    unit: str | None = None
    display_unit: str | None = None
    quantity: str | None = None
    description: str | None = None
    minimum: float | None = None
    maximum: float | None = None
    nominal: float | None = None


@dataclass
class Entry:
    """A variable as declared: its DAE entry, its scalars, and the dimensions they fill row by row.

    derivative: symbols of a state's derivative; pre: symbols of a discrete variable's value before an event.
    """

    i: int
    role: str
    data: dict[str, Any]
    dimensions: list[int]
    scalars: list[Variable]
    derivative: Value | None = None
    pre: Value | None = None

    @property
    def value(self) -> Value:
        """The variable as a value of expressions."""
        return unflatten(iter([scalar.symbol for scalar in self.scalars]), self.dimensions)


def declare(source: Source) -> list[Entry]:
    """Every variable of the model, names without a dot (the model's own) first."""
    entries = [_declare_one(source, i, data) for i, data in enumerate(source.dae["variables"])]
    return sorted(entries, key=lambda entry: "." in entry.data["name"])


def _declare_one(source: Source, i: int, data: dict[str, Any]) -> Entry:
    name, attributes = data["name"], data["attributes"] or {}
    value_type = source.dae["value_types"][data["value_type"]]
    scalar_type = value_type["scalar"]
    if value_type["record_name"] or not isinstance(scalar_type, str) or scalar_type not in TYPES:
        raise source.refuse(f"variable {name}: its type {scalar_type} cannot be exported", data)
    if data["role"] not in KIND_OF_ROLE:
        raise source.refuse(f"variable {name}: its role {data['role']} cannot be exported", data)
    kind = KIND_OF_ROLE[data["role"]]
    if kind == "parameter" and (TYPES[scalar_type] != "Real" or attributes.get("evaluable")):
        kind = "constant"  # the front end folds it into the equations
    flat = source.flat["variables"].get(name, {})
    shared = {
        "type": TYPES[scalar_type],
        "output": attributes.get("causality") == "output",
        "unit": attributes.get("unit"),
        "display_unit": flat.get("display_unit"),
        "quantity": flat.get("quantity"),
        "description": attributes.get("description"),
    }
    if scalar_type == "enumeration":
        shared |= {"minimum": 1.0, "maximum": literals(source, name)}
    dimensions = value_type["dimensions"]
    names = [name + subscript for subscript in subscripts(dimensions)]
    scalars = [Variable(scalar, kind, ca.SX.sym(scalar), **shared) for scalar in names]
    return Entry(i, data["role"], data, dimensions, scalars)


def literals(source: Source, name: str) -> float | None:
    """How many literals the enumeration has that a variable is of, or None where the front end does not tell."""
    of_type = f"{source.flat['variable_type_names'].get(name)}."
    ordinals = source.flat["enum_literal_ordinals"].items()
    return max((float(k) for literal, k in ordinals if literal.startswith(of_type)), default=None)


def read_attribute(expressions: Expressions, entry: Entry, attribute: str, scope: Scope) -> list[ca.SX] | None:
    """An attribute (binding, start, min …) of every scalar of an entry, or None where it is not given."""
    node = (entry.data["attributes"] or {}).get(attribute)
    if node is None:
        return None
    value = expressions.read(node, scope)
    if isinstance(value, tuple):
        return flatten(value)
    return flatten(elementwise(lambda symbol: value, entry.value))


def number(value: ca.SX) -> float | None:
    """The number an expression is, or None where it holds symbols."""
    return float(value) if value.is_constant() else None


def apply_limits(expressions: Expressions, entry: Entry, values: Mapping[str, float], scope: Scope) -> None:
    """Fill in min, max and nominal, where they are numbers for the parameters' start values."""
    for attribute, target in (("min", "minimum"), ("max", "maximum"), ("nominal", "nominal")):
        limits = read_attribute(expressions, entry, attribute, scope)
        if limits is None:
            continue
        for scalar, limit in zip(entry.scalars, limits, strict=True):
            symbols = ca.symvar(limit)
            numbers = [values.get(symbol.name()) for symbol in symbols]
            if None not in numbers:
                limit = ca.substitute(limit, ca.vertcat(*symbols), ca.DM(numbers)) if symbols else limit
                setattr(scalar, target, float(ca.evalf(limit)))
