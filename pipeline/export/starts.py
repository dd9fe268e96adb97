"""Start values of states and discrete variables: `start=` and initial equations.

One that is a number may be set; the others follow, as expressions of these and of the parameters.
"""

from __future__ import annotations

from math import isfinite

import casadi as ca

from pipeline.export.arrays import flatten
from pipeline.export.expressions import Expressions, Scope
from pipeline.export.sorting import Equation, solve
from pipeline.export.variables import Entry, Variable, number, read_attribute


def read_starts(
    expressions: Expressions,
    entries: list[Entry],
    scope: Scope,
    initial: list[Equation],
    unknown: list[ca.SX],
    solution: list[ca.SX],
) -> dict[str, ca.SX]:
    """Start value of every state, discrete variable and input by name, in parameters and in what has a number.

    `unknown` and `solution`: derivatives and algebraic variables, that initial equations may name. Also sets
    `start` of the scalars whose start value is a number.
    """
    starts: dict[str, ca.SX] = {}
    initial = initial + fixed_algebraics(expressions, entries, scope)
    loose: list[ca.SX] = []  # states that fixed=true does not pin
    for entry in entries:
        if entry.scalars[0].kind not in ("state", "discrete", "input"):
            continue
        fixed = (entry.data["attributes"] or {}).get("fixed") or [False]
        values = read_attribute(expressions, entry, "start", scope) or [ca.SX(0)] * len(entry.scalars)
        for k, (scalar, value) in enumerate(zip(entry.scalars, values, strict=True)):
            starts[scalar.name] = value
            if scalar.kind == "state" and not fixed[k % len(fixed)]:
                loose.append(scalar.symbol)
    for entry in expressions.source.dae["initial_discrete_values"]:
        target = next(e for e in entries if e.i == entry["target"])
        values = flatten(expressions.read(entry["value"], scope))
        starts |= {scalar.name: value for scalar, value in zip(target.scalars, values, strict=True)}
    starts |= solve_initial(expressions, initial, loose, unknown, solution)
    _resolve(expressions, entries, starts)
    return starts


def fixed_algebraics(expressions: Expressions, entries: list[Entry], scope: Scope) -> list[Equation]:
    """fixed=true on what is no state, an output for example, is an initial equation."""
    equations = []
    for entry in entries:
        fixed = (entry.data["attributes"] or {}).get("fixed") or [False]
        if entry.scalars[0].kind == "algebraic" and any(fixed):
            values = read_attribute(expressions, entry, "start", scope) or [ca.SX(0)] * len(entry.scalars)
            place = expressions.source.place(entry.data)
            pairs = enumerate(zip(entry.scalars, values, strict=True))
            equations += [Equation(s.symbol - value, place) for k, (s, value) in pairs if fixed[k % len(fixed)]]
    return equations


def solve_initial(expressions, initial, loose, unknown, solution) -> dict[str, ca.SX]:
    """What the initial equations say of the states without fixed=true."""
    if not initial:
        return {}
    source = expressions.source
    solved = [
        Equation(ca.substitute(equation.residual, ca.vertcat(*unknown), ca.vertcat(*solution)), equation.place)
        for equation in initial
    ]
    named = ca.symvar(ca.vertcat(*[equation.residual for equation in solved]))
    wanted = [symbol for symbol in loose if any(symbol.name() == other.name() for other in named)]
    if len(wanted) != len(solved):
        places = ", ".join(equation.place for equation in solved)
        names = ", ".join(symbol.name() for symbol in wanted) or "none"
        raise source.refuse(f"{len(solved)} initial equations for the start of {names} cannot be exported ({places})")
    values = solve(solved, wanted, f"{source.model}, initial equations")
    return {symbol.name(): value for symbol, value in zip(wanted, values, strict=True)}


def _resolve(expressions: Expressions, entries: list[Entry], starts: dict[str, ca.SX]) -> None:
    """Set the numbers, which may be set through FMI; what names others is resolved into these and parameters."""
    scalars: dict[str, Variable] = {scalar.name: scalar for entry in entries for scalar in entry.scalars}
    for name, value in starts.items():
        scalars[name].start = number(value)
    following = {name for name in starts if scalars[name].start is None}
    for name in starts:
        for _ in range(len(starts)):
            named = [symbol for symbol in ca.symvar(starts[name]) if symbol.name() in following]
            if not named:
                break
            values = ca.vertcat(*[starts[symbol.name()] for symbol in named])
            starts[name] = ca.substitute(starts[name], ca.vertcat(*named), values)
        else:
            raise expressions.source.refuse(f"the start value of {name} depends on itself")
        _check(expressions, scalars, name, starts[name])


def _check(expressions: Expressions, scalars: dict[str, Variable], name: str, value: ca.SX) -> None:
    """Refuse a start value that names what is not known at the start, or is not finite."""
    for symbol in ca.symvar(value):
        kind = scalars[symbol.name()].kind if symbol.name() in scalars else "other"
        if kind not in ("constant", "parameter", "calculated", "state", "discrete"):
            what = f"the start value of {name} depends on {symbol.name()}, which is not a parameter"
            raise expressions.source.refuse(what)
    at = number(value)
    if at is not None and not isfinite(at):
        raise expressions.source.refuse(f"the start value of {name} is {at}: give a finite one")
    if scalars[name].kind == "input" and scalars[name].start is None:
        raise expressions.source.refuse(f"the start value of the input {name} must be a number")
