"""Sample instants: the periodic clocks of a model, their periods kept as parameters.

The front end folds `sample(start, period)` to numbers. The parameters behind them are looked up in the flat model, so
that a sample period set before the initialisation is obeyed.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Iterator
from typing import Any

import casadi as ca

from pipeline.export.frontend import Source
from pipeline.export.parameters import Parameters

OPERATORS = {"Add": operator.add, "Sub": operator.sub, "Mul": operator.mul, "Div": operator.truediv}


def read_clocks(source: Source, parameters: Parameters) -> list[tuple[ca.SX, ca.SX]]:
    """(period, phase) of every clock in s, as expressions of constants and settable parameters."""
    places = [source.flat[key] for key in ("when_chains", "equations", "algorithms", "variables")]
    samples = [_arguments(source, call, parameters) for call in find_samples(places)]
    return [_match(source, entry, samples, parameters) for entry in source.dae["clocks"]]


def find_samples(node: Any) -> Iterator[dict]:
    """Every call of sample() in a part of the flat model."""
    if isinstance(node, dict):
        call = node.get("BuiltinCall")
        if call is not None and call["function"] == "Sample":
            yield call
        for child in node.values():
            yield from find_samples(child)
    elif isinstance(node, list):
        for child in node:
            yield from find_samples(child)


def _arguments(source: Source, call: dict, parameters: Parameters) -> tuple[ca.SX, ca.SX]:
    start, period = (_read(source, argument, parameters) for argument in call["args"])
    return period, start


def _read(source: Source, argument: dict, parameters: Parameters) -> ca.SX:
    """An argument of sample(), as the flat model has it: numbers, parameters, + - * / of them."""
    kind, body = next(iter(argument.items()))
    if kind == "Literal":
        return ca.SX(float(next(iter(body["value"].values()))))
    if kind == "Binary" and body["op"] in OPERATORS:
        return OPERATORS[body["op"]](*(_read(source, body[side], parameters) for side in ("lhs", "rhs")))
    if kind == "Unary" and body["op"] == "Minus":
        return -_read(source, body["rhs"], parameters)
    name = body["name"]["name"] if kind == "VarRef" else None
    if name not in parameters.symbols:
        raise source.refuse("sample() of other than numbers, parameters and + - * / cannot be exported", body)
    return parameters.resolve(parameters.symbols[name])


def _match(source: Source, entry: dict, samples: list, parameters: Parameters) -> tuple[ca.SX, ca.SX]:
    """The sample() call behind a clock: the one with its numbers."""
    schedule = entry["kind"].get("periodic")
    if schedule is None or schedule["anchor"] != "absolute":
        raise source.refuse("a clock other than sample(start, period) cannot be exported", entry)
    wanted = [_rational(schedule["lattice"][key]) for key in ("period", "phase")]
    matches = [
        sample
        for sample in samples
        if all(
            math.isclose(parameters.at_binding(v), w, rel_tol=1e-9, abs_tol=1e-15)
            for v, w in zip(sample, wanted, strict=True)
        )
    ]
    if not matches:
        raise source.refuse(f"a clock with period {wanted[0]:g} s has no sample() in the model", entry)
    first = matches[0]
    for other in matches[1:]:
        if not all(ca.is_equal(a, b, 9) for a, b in zip(first, other, strict=True)):
            what = f"two sample periods of {wanted[0]:g} s come from different parameters: give both one parameter"
            raise source.refuse(what, entry)
    return first


def _rational(value: dict[str, int]) -> float:
    return value["num"] / value["den"]
