"""Parameters: which can be set, which follow from others, and their start values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isfinite

import casadi as ca

from pipeline.errors import ExportError
from pipeline.export.expressions import Expressions, Scope
from pipeline.export.variables import Entry, Variable, read_attribute


@dataclass
class Parameters(Mapping[str, float]):
    """Start values by name; `expressions` of the calculated parameters in constants and settable parameters."""

    numbers: dict[str, float] = field(default_factory=dict)
    bound: dict[str, float] = field(default_factory=dict)
    expressions: dict[str, ca.SX] = field(default_factory=dict)
    symbols: dict[str, ca.SX] = field(default_factory=dict)

    def __getitem__(self, name: str) -> float:
        return self.numbers[name]

    def __iter__(self):
        return iter(self.numbers)

    def __len__(self) -> int:
        return len(self.numbers)

    def resolve(self, value: ca.SX) -> ca.SX:
        """An expression of parameters in constants and settable parameters alone."""
        known = [s for s in ca.symvar(value) if s.name() in self.expressions]
        if not known:
            return value
        return ca.substitute(value, ca.vertcat(*known), ca.vertcat(*[self.expressions[s.name()] for s in known]))

    def at_binding(self, value: ca.SX) -> float:
        """The number of an expression at the values bound in the Modelica text, whatever start values replace them."""
        return self.evaluate(value, self.bound)

    def evaluate(self, value: ca.SX, numbers: Mapping[str, float] | None = None) -> float:
        """The number of an expression at the start values."""
        numbers = self.numbers if numbers is None else numbers
        symbols = ca.symvar(value)
        if not symbols:
            return float(ca.evalf(value))
        return float(ca.evalf(ca.substitute(value, ca.vertcat(*symbols), ca.DM([numbers[s.name()] for s in symbols]))))


def bind_parameters(
    expressions: Expressions, entries: list[Entry], scope: Scope, start_values: dict[str, float]
) -> Parameters:
    """Read every binding; set `kind` and `start` of the variables. `start_values` replace bindings by numbers."""
    source = expressions.source
    bindings: dict[str, ca.SX] = {}
    scalars: dict[str, tuple[Variable, Entry]] = {}
    replaced: dict[str, ca.SX | None] = {}
    for entry in entries:
        if entry.role not in ("parameter", "constant"):
            continue
        if False in ((entry.data["attributes"] or {}).get("fixed") or []):
            raise source.refuse(f"parameter {entry.data['name']}: fixed=false cannot be exported", entry.data)
        values = read_attribute(expressions, entry, "binding", scope) or [None] * len(entry.scalars)
        for scalar, value in zip(entry.scalars, values, strict=True):
            if settable(scalar, start_values):
                replaced[scalar.name], value = value, ca.SX(start_values.pop(scalar.name))
            if value is None:
                raise source.refuse(f"parameter {scalar.name} has no value: bind it", entry.data)
            bindings[scalar.name], scalars[scalar.name] = value, (scalar, entry)
            if source.flat["variable_final_flags"].get(entry.data["name"]):
                scalar.kind = "constant"
    if start_values:
        names = ", ".join(start_values)
        raise ExportError(f"{source.model}: no parameter to set: {names}; settable: {', '.join(free(scalars))}")
    parameters = _order(expressions, bindings, scalars)
    parameters.bound = parameters.numbers | {
        name: parameters.evaluate(value) for name, value in replaced.items() if value is not None
    }
    return parameters


def settable(scalar: Variable, start_values: Mapping[str, float]) -> bool:
    """True where a start value is given for a parameter that may have one."""
    return scalar.kind == "parameter" and scalar.name in start_values


def free(scalars: Mapping[str, tuple[Variable, Entry]]) -> list[str]:
    """The model's own settable parameters."""
    return [name for name, (scalar, _) in scalars.items() if scalar.kind == "parameter" and "." not in name]


def _order(expressions: Expressions, bindings: dict[str, ca.SX], scalars: dict) -> Parameters:
    parameters = Parameters()
    open_names: set[str] = set()

    def visit(name: str) -> None:
        if name in parameters.numbers:
            return
        scalar, entry = scalars[name]
        if name in open_names:
            raise expressions.source.refuse(f"parameter {name} depends on itself", entry.data)
        open_names.add(name)
        symbols = ca.symvar(bindings[name])
        for symbol in symbols:
            visit(symbol.name())
        value = parameters.resolve(bindings[name])
        parameters.numbers[name] = scalar.start = parameters.evaluate(value)
        if not isfinite(scalar.start):
            raise expressions.source.refuse(f"parameter {name} is {scalar.start}: give a finite value", entry.data)
        parameters.symbols[name] = scalar.symbol
        if any(scalars[symbol.name()][0].kind != "constant" for symbol in ca.symvar(value)):
            if scalar.type != "Real":
                what = f"parameter {name}: a {scalar.type} parameter computed from others cannot be exported"
                raise expressions.source.refuse(what, entry.data)
            scalar.kind, scalar.start = "calculated", None
            parameters.expressions[name] = value

    for name in bindings:
        visit(name)
    return parameters
