"""Expressions: the front end's expression nodes as CasADi SX, arrays as nested tuples of scalars.

The nodes are a list; a node refers to others by index, and the operands and subscripts of all nodes stand in two
streams, consumed in the order of the nodes (rumoca 0.10.2, crates/rumoca-ir-dae/src/expression/nodes.rs). Booleans and
Integers are numbers. A relation with an event is not evaluated: it is the symbol that holds its value between events.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import product
from typing import Any

import casadi as ca

from pipeline.export.arrays import (
    Pick,
    Record,
    Value,
    elementwise,
    flatten,
    index,
    matmul,
    matrix_power,
    size,
    to_int,
    unflatten,
    unit_matrix,
    update,
)
from pipeline.export.frontend import Source
from pipeline.export.functions import call
from pipeline.export.operators import ARRAYS, BINARY, FUNCTIONS, STEPS, UNARY
from pipeline.export.scope import Scope

HELD = {"parameter", "discrete_real", "discrete_value", "pre_discrete_real", "pre_discrete_value"}


class Expressions:
    """Reads expression nodes of one model in a Scope."""

    def __init__(self, source: Source):
        self.source = source
        self.known: Mapping[str, float] = {}  # values of constants, once they are bound
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
        if start != len(stream) or len(self.nodes) != len(self.provenance):
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
            return matrix_power(left, self.constant(right, i))
        return elementwise(BINARY[operator], left, right)

    def _read_conditional(self, i: int, body: dict, scope: Scope) -> Value:
        """A branch that is not taken whatever the FMU does is not read: x[i - 1] where i is 1."""
        *pairs, otherwise = self.operands[i]
        taken = []
        for condition, branch in zip(pairs[::2], pairs[1::2], strict=True):
            test = self.read(condition, scope)
            known = self._known_integer(test)
            if known:
                otherwise = branch
                break
            if known is None:
                taken.append((test, self.read(branch, scope)))
        value = self.read(otherwise, scope)
        for test, branch in reversed(taken):
            value = elementwise(lambda a, b, test=test: ca.if_else(test, a, b), branch, value)
        return value

    def _read_array(self, i: int, body: dict, scope: Scope) -> Value:
        return tuple(self.read(operand, scope) for operand in self.operands[i])

    def _read_comprehension(self, i: int, body: dict, scope: Scope) -> Value:
        """An array with a dimension for each iterator, as the front end starts one that is assigned by element."""
        binders = self.source.dae["domains"][body["domain"]]["domain"]["binders"]
        items = (self.read(body["body"], inner) for inner in self.iterate(body["domain"], scope))
        return unflatten(items, [len(steps(binder)) for binder in binders])

    def _read_index(self, i: int, body: dict, scope: Scope) -> Value:
        return index(self.read(body["base"], scope), self._picks(i, scope))

    def _read_array_update(self, i: int, body: dict, scope: Scope) -> Value:
        return update(self.read(body["base"], scope), self._picks(i, scope), self.read(body["value"], scope))

    def _picks(self, i: int, scope: Scope) -> list[Pick]:
        """The subscripts of node i, counted from 0."""
        picks: list[Pick] = []
        for subscript in self.subscripts[i]:
            kind = subscript["kind"]
            if kind == "whole":
                picks.append(slice(None))
            elif "index" in kind:
                value = self.read(kind["index"], scope)
                number = self._known_integer(value)
                picks.append(value - 1 if number is None else number - 1)
            elif "slice" in kind:
                picks.append([self.constant(item, i) - 1 for item in self.read(kind["slice"], scope)])
            else:
                raise self.refuse("this kind of subscript cannot be exported", i)
        return picks

    def _read_range(self, i: int, body: dict, scope: Scope) -> Value:
        step = body["explicit_step_expression"]
        first, last = (self.integer(body[f"{end}_expression"], scope) for end in ("start", "stop"))
        by = 1 if step is None else self.integer(step, scope)
        return tuple(ca.SX(float(k)) for k in range(first, last + (1 if by > 0 else -1), by))

    def _read_builtin(self, i: int, body: dict, scope: Scope) -> Value:
        name, operands = body["builtin"], self.operands[i]
        if name in ("zeros", "ones", "fill", "identity", "linspace"):
            return self._filled(name, operands, scope)
        if name == "size" and len(operands) == 2:
            array = self.read(operands[0], scope)
            return ca.SX(size(array, self.integer(operands[1], scope)))
        if name in ("no_event", "smooth"):
            scope = replace(scope, quiet=True)
        values = [self.read(operand, scope) for operand in operands]
        if name in STEPS:
            self._check_step(name, values, i, scope)
            return elementwise(STEPS[name], *values)
        if name in ARRAYS:
            return ARRAYS[name](*values)
        if name not in FUNCTIONS:
            raise self.refuse(f"the function {name} cannot be exported", i)
        return elementwise(FUNCTIONS[name], *values)

    def _check_step(self, name: str, values: list[Value], i: int, scope: Scope) -> None:
        """A function with steps needs events, unless it is told otherwise or its arguments change at events only."""
        named = {symbol.name() for value in values for item in flatten(value) for symbol in ca.symvar(item)}
        held = {s.name() for (kind, _), v in scope.coordinates.items() if kind in HELD for s in flatten(v)}
        if not scope.quiet and not named <= held:
            raise self.refuse(f"{name}() of what changes between events cannot be exported: put it into noEvent()", i)

    def _filled(self, name: str, operands: list[int], scope: Scope) -> Value:
        if name == "identity":
            return unit_matrix(self.integer(operands[0], scope))
        if name == "linspace":
            first, last = (self.read(operand, scope) for operand in operands[:2])
            n = self.integer(operands[2], scope)
            return tuple(first + (last - first) * k / (n - 1) for k in range(n))
        value, sizes = (self.read(operands[0], scope), operands[1:]) if name == "fill" else (None, operands)
        value = ca.SX(float(name == "ones")) if value is None else value
        for operand in reversed(sizes):
            value = (value,) * self.integer(operand, scope)
        return value

    def _read_call(self, i: int, body: dict, scope: Scope) -> Value:
        return call(self, i, body, scope)

    def _read_record(self, i: int, body: dict, scope: Scope) -> Value:
        return Record(self.read(operand, scope) for operand in self.operands[i])

    def _read_field(self, i: int, body: dict, scope: Scope) -> Value:
        base = self.read(body["base"], scope)
        if not isinstance(base, Record):
            raise self.refuse("a field of an array of records cannot be exported: take one record first", i)
        return base[body["field"]]

    def _read_function_value(self, i: int, body: dict, scope: Scope) -> Value:
        if ("value", body["value"]) not in scope.arguments:
            raise self.refuse("a function reads a value before it is assigned", i)
        return scope.arguments["value", body["value"]]

    def integer(self, i: int, scope: Scope) -> int:
        """The value of a node that must be known when the FMU is built: an array size or index."""
        return self.constant(self.read(i, scope), i)

    def constant(self, value: Value, i: int) -> int:
        """The integer that a value read at node i must be."""
        number = self._known_integer(value)
        if number is None:
            raise self.refuse("an array size or slice that is not constant cannot be exported", i)
        return number

    def _known_integer(self, value: Value) -> int | None:
        symbols = [] if isinstance(value, tuple) else ca.symvar(value)
        numbers = [self.known.get(symbol.name()) for symbol in symbols]
        if symbols and None not in numbers:
            value = ca.substitute(value, ca.vertcat(*symbols), ca.DM(numbers))
        return to_int(value)

    def iterate(self, domain: int, scope: Scope) -> list[Scope]:
        """One scope for each instance of a for-family, within the instance of an outer one if `scope` is in one.

        The last loop variable runs fastest.
        """
        entry = self.source.dae["domains"][domain]
        outside = entry["parent"] is None or (entry["parent"], 0) in scope.binders
        scopes = [scope] if outside else self.iterate(entry["parent"], scope)
        binders = entry["domain"]["binders"]
        return [
            replace(outer, binders={**outer.binders, **{(domain, k): value for k, value in enumerate(values)}})
            for outer in scopes
            for values in product(*map(steps, binders))
        ]


def steps(binder: dict[str, int]) -> range:
    """The values of a loop variable."""
    return range(binder["lower"], binder["upper"] + (1 if binder["step"] > 0 else -1), binder["step"])
