"""Expressions: the front end's expression nodes as CasADi SX, arrays as nested tuples of scalars.

The nodes are a list; a node refers to others by index, and the operands and subscripts of all nodes stand in two
streams, consumed in the order of the nodes (rumoca 0.10.2, crates/rumoca-ir-dae/src/expression/nodes.rs). Booleans and
Integers are numbers. A relation with an event is not evaluated: it is the symbol that holds its value between events.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Any

import casadi as ca

from pipeline.export.arrays import Value, elementwise, flatten, index, matmul, size, stack, to_int
from pipeline.export.frontend import Source

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
# div, mod, rem, floor, ceil and integer step, and Modelica lets them cause events, which nothing here would catch
FUNCTIONS: dict[str, Callable] = {
    "abs": ca.fabs, "sign": ca.sign, "sqrt": ca.sqrt, "sin": ca.sin, "cos": ca.cos, "tan": ca.tan, "asin": ca.asin,
    "acos": ca.acos, "atan": ca.atan, "atan2": ca.atan2, "sinh": ca.sinh, "cosh": ca.cosh, "tanh": ca.tanh,
    "exp": ca.exp, "log": ca.log, "log10": ca.log10,
}  # fmt: skip


@dataclass(frozen=True)
class Scope:
    """What an expression is read in: the variables' values by coordinate (kind, index), relation symbols by node,
    the loop variables of a for-family and, inside a function, its values."""

    coordinates: Mapping[tuple[str, int], Value]
    relations: Mapping[int, ca.SX] = field(default_factory=dict)
    binders: Mapping[tuple[int, int], int] = field(default_factory=dict)
    arguments: Mapping[tuple[str, int], Value] = field(default_factory=dict)


class Expressions:
    """Reads expression nodes of one model in a Scope."""

    def __init__(self, source: Source):
        self.source = source
        arena = source.dae["expressions"]
        self.nodes = [(node, {}) if isinstance(node, str) else next(iter(node.items())) for node in arena["nodes"]]
        self.provenance = arena["provenance"]
        self.operands = self._ranges(arena["operands"], "operand_count")
        self.subscripts = self._ranges(arena["subscripts"], "subscript_count")

    def _ranges(self, stream: list, count: str) -> dict[int, list]:
        ranges, start = {}, 0
        for i, (_, body) in enumerate(self.nodes):
            if isinstance(body, dict) and count in body:
                ranges[i] = stream[start : start + body[count]]
                start += body[count]
        if start != len(stream):
            raise self.source.refuse("the front end's expressions do not add up: install rumoca==0.10.2")
        return ranges

    def refuse(self, what: str, i: int) -> Exception:
        return self.source.refuse(what, self.provenance[i])

    def read(self, i: int, scope: Scope) -> Value:
        """The value of node i: an SX scalar, or nested tuples of them."""
        if i in scope.relations:
            return scope.relations[i]
        kind, body = self.nodes[i]
        reader = getattr(self, f"_read_{kind}", None)
        if reader is None:
            raise self.refuse(f"an expression of kind {kind} cannot be exported", i)
        return reader(i, body, scope)

    def _read_literal(self, i: int, body: dict, scope: Scope) -> Value:
        kind, value = next(iter(body.items()))
        if kind not in ("real", "integer", "boolean", "enumeration"):
            raise self.refuse(f"a literal of type {kind} cannot be exported", i)
        return ca.SX(float(value))

    def _read_coordinate(self, i: int, body: Any, scope: Scope) -> Value:
        kind, key = (body, 0) if isinstance(body, str) else next(iter(body.items()))
        if kind == "binder":
            return ca.SX(scope.binders[key["domain"], key["ordinal"]])
        if kind == "function_parameter":
            return scope.arguments["parameter", key["ordinal"]]
        if (kind, key) not in scope.coordinates:
            raise self.refuse(f"{kind} cannot be exported here", i)
        return scope.coordinates[kind, key]

    def _read_unary(self, i: int, body: dict, scope: Scope) -> Value:
        return elementwise(UNARY[body["operator"]], self.read(body["operand"], scope))

    def _read_binary(self, i: int, body: dict, scope: Scope) -> Value:
        operator = body["operator"].removeprefix("elementwise_")
        left, right = self.read(body["lhs"], scope), self.read(body["rhs"], scope)
        if body["operator"] == "multiply" and isinstance(left, tuple) and isinstance(right, tuple):
            return matmul(left, right)
        if body["operator"] == "power" and isinstance(left, tuple):
            raise self.refuse("a power of a matrix cannot be exported", i)
        return elementwise(BINARY[operator], left, right)

    def _read_conditional(self, i: int, body: dict, scope: Scope) -> Value:
        *pairs, otherwise = self.operands[i]
        value = self.read(otherwise, scope)
        for condition, branch in reversed(list(zip(pairs[::2], pairs[1::2], strict=True))):
            test = self.read(condition, scope)
            value = elementwise(lambda a, b, test=test: ca.if_else(test, a, b), self.read(branch, scope), value)
        return value

    def _read_array(self, i: int, body: dict, scope: Scope) -> Value:
        return tuple(self.read(operand, scope) for operand in self.operands[i])

    def _read_comprehension(self, i: int, body: dict, scope: Scope) -> Value:
        return tuple(self.read(body["body"], inner) for inner in self.iterate(body["domain"], scope))

    def _read_index(self, i: int, body: dict, scope: Scope) -> Value:
        picks: list[int | slice | list[int]] = []
        for subscript in self.subscripts[i]:
            kind = subscript["kind"]
            if kind == "whole":
                picks.append(slice(None))
            elif "index" in kind:
                picks.append(self.integer(kind["index"], scope) - 1)
            else:
                raise self.refuse("an array slice other than `:` cannot be exported", i)
        return index(self.read(body["base"], scope), picks)

    def _read_builtin(self, i: int, body: dict, scope: Scope) -> Value:
        name, operands = body["builtin"], self.operands[i]
        if name in ("zeros", "ones", "fill", "identity"):
            return self._filled(name, operands, scope)
        if name == "size" and len(operands) == 2:
            array = self.read(operands[0], scope)
            return ca.SX(size(array, self.integer(operands[1], scope)))
        values = [self.read(operand, scope) for operand in operands]
        if name in ("no_event", "homotopy"):
            return values[0]
        if name == "smooth":
            return values[1]
        if name in ("min", "max"):
            pick = ca.fmin if name == "min" else ca.fmax
            items = [item for value in values for item in flatten(value)]
            return _fold(pick, items)
        if name == "sum":
            return _fold(lambda a, b: a + b, flatten(values[0]))
        if name == "product":
            return _fold(lambda a, b: a * b, flatten(values[0]))
        if name == "transpose":
            return tuple(zip(*values[0], strict=True))
        if name in ("promoted_cat1", "promoted_cat2"):
            return stack(values, name[-1])
        if name not in FUNCTIONS:
            raise self.refuse(f"the function {name} cannot be exported", i)
        return elementwise(FUNCTIONS[name], *values)

    def _filled(self, name: str, operands: list[int], scope: Scope) -> Value:
        if name == "identity":
            n = self.integer(operands[0], scope)
            return tuple(tuple(ca.SX(float(i == k)) for k in range(n)) for i in range(n))
        value, sizes = (self.read(operands[0], scope), operands[1:]) if name == "fill" else (None, operands)
        value = ca.SX(float(name == "ones")) if value is None else value
        for operand in reversed(sizes):
            value = (value,) * self.integer(operand, scope)
        return value

    def _read_call(self, i: int, body: dict, scope: Scope) -> Value:
        """A function of assignments alone, written out in place."""
        function = self.source.dae["functions"][body["function"]]
        if function["external"] is not None or body["derivative"] is not None:
            raise self.refuse(f"the external function {function['name']} cannot be exported", i)
        arguments = {
            ("parameter", k): self.read(operand, scope) for k, operand in enumerate(self.operands[body["owner"]])
        }
        for statement in function["statements"]:
            if set(statement) - {"provenance"} != {"assignment"}:
                raise self.refuse(f"function {function['name']}: only assignments can be exported", i)
            target, rhs = statement["assignment"]["target"], statement["assignment"]["rhs"]
            arguments["value", target] = self.read(rhs, replace(scope, arguments=arguments, binders={}))
        return arguments["value", body["output"]]

    def _read_function_value(self, i: int, body: dict, scope: Scope) -> Value:
        if ("value", body["value"]) not in scope.arguments:
            raise self.refuse("a function reads a value before it is assigned", i)
        return scope.arguments["value", body["value"]]

    def integer(self, i: int, scope: Scope) -> int:
        """The value of a node that must be known when the FMU is built: an array size or index."""
        value = to_int(self.read(i, scope))
        if value is None:
            raise self.refuse("an array index or size that is not constant cannot be exported", i)
        return value

    def iterate(self, domain: int, scope: Scope) -> list[Scope]:
        """One scope for each instance of a for-family, the last loop variable running fastest."""
        entry = self.source.dae["domains"][domain]
        scopes = [scope] if entry["parent"] is None else self.iterate(entry["parent"], scope)
        binders = entry["domain"]["binders"]
        ranges = [range(b["lower"], b["upper"] + (1 if b["step"] > 0 else -1), b["step"]) for b in binders]
        return [
            replace(outer, binders={**outer.binders, **{(domain, k): value for k, value in enumerate(values)}})
            for outer in scopes
            for values in product(*ranges)
        ]


def _fold(operation: Callable, items: list[ca.SX]) -> ca.SX:
    value = items[0]
    for item in items[1:]:
        value = operation(value, item)
    return value
