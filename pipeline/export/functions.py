"""Functions: written out where they are called, loops unrolled, branches as conditional expressions.

The front end numbers a function's outputs and protected variables, and refers to the latest value of each; it turns
if-statements into groups of conditional assignments, made at once, and refuses while, break and return.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from pipeline.export.arrays import Value

if TYPE_CHECKING:
    from pipeline.export.expressions import Expressions, Scope


def call(expressions: Expressions, i: int, body: dict[str, Any], scope: Scope) -> Value:
    """The output that node i, a call with this body, stands for."""
    function = expressions.source.dae["functions"][body["function"]]
    if function["external"] is not None or body["derivative"] is not None:
        raise expressions.refuse(f"the external function {function['name']} cannot be exported", i)
    if body["function"] in scope.calls:
        raise expressions.refuse(f"the function {function['name']} calls itself: write it as a loop", i)
    operands = enumerate(expressions.operands[body["owner"]])
    arguments = {("parameter", k): expressions.read(operand, scope) for k, operand in operands}
    calls = (*scope.calls, body["function"])
    run(expressions, function, i, replace(scope, arguments=arguments, binders={}, calls=calls))
    return arguments["value", body["output"]]


def run(expressions: Expressions, function: dict[str, Any], i: int, scope: Scope) -> None:
    """Carry out a function's statements: scope.arguments holds its parameters before, its values after."""
    for statement in function["statements"]:
        _run_statement(expressions, function, statement, i, scope)


def _run_statement(expressions, function: dict, statement: dict, i: int, scope: Scope) -> None:
    kind, body = next(item for item in statement.items() if item[0] != "provenance")
    if kind == "assignment":
        _assign(expressions, [body], scope)
    elif kind == "assignment_group":
        _assign(expressions, body["assignments"], scope)
    elif kind == "for":
        for inner in expressions.iterate(body["domain"], scope):
            for one in body["statements"]:
                _run_statement(expressions, function, one, i, inner)
    else:
        raise expressions.refuse(f"function {function['name']}: an {kind} in it cannot be exported: leave it out", i)


def _assign(expressions, assignments: list[dict], scope: Scope) -> None:
    values = [expressions.read(assignment["rhs"], scope) for assignment in assignments]
    for assignment, value in zip(assignments, values, strict=True):
        scope.arguments["value", assignment["target"]] = value
