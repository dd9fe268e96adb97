"""Relations that have an event: their truth, the indicator that locates it, and the instant where time alone decides.

The front end owns a relation as a root (located by its indicator), or as a time event: `time >= T`, whose instant is
known beforehand. T is kept as an expression, so that it follows the parameters.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import casadi as ca

from pipeline.export.expressions import Expressions, Scope
from pipeline.export.frontend import Source, find_span

RISING = {"greater": 1, "greater_equal": 1, "less": -1, "less_equal": -1}


@dataclass(frozen=True)
class Relation:
    """A relation that has an event: its truth and its indicator (lhs − rhs), whose sign changes where it switches.

    instant: for a time event when that is, in s.
    """

    truth: ca.SX
    indicator: ca.SX
    instant: ca.SX | None = None


def find_relations(source: Source) -> tuple[list[int], set[int]]:
    """The expression nodes of the relations that have an event, and those of them that are time events."""
    expressions, relations = source.dae["expressions"], source.dae["relations"]
    roots = [relations[entry["root"]["relation"]]["relation"]["expression"] for entry in source.dae["roots"]]
    rooted = {node for node in roots if "binary" in expressions["nodes"][node]}  # floor() sees to itself
    timed = {node for entry in source.dae["time_events"] for node in _at_place(source, expressions, entry)}
    return sorted(rooted | timed), timed - rooted


def _at_place(source: Source, expressions: dict, entry: dict) -> Iterator[int]:
    """The relations that stand where a time event stands: the front end tells no more of it."""
    wanted, found = find_span(entry), False
    for i, node in enumerate(expressions["nodes"]):
        binary = node.get("binary") if isinstance(node, dict) else None
        if binary and binary["operator"] in RISING and find_span(expressions["provenance"][i]) == wanted:
            found = True
            yield i
    if not found:
        raise source.refuse("a time event without a relation cannot be exported", entry)


def read_relation(expressions: Expressions, node: int, scope: Scope, timed: bool, time: ca.SX) -> Relation:
    """The relation of a node, its operands as they are in `scope`."""
    body = expressions.nodes[node][1]
    lhs, rhs = (expressions.read(body[side], scope) for side in ("lhs", "rhs"))
    indicator = lhs - rhs
    slope = ca.jacobian(indicator, time)
    if not timed or not slope.is_constant() or float(slope) == 0:
        return Relation(expressions.read(node, scope), indicator)
    instant = -ca.substitute(indicator, time, 0) / slope
    after = time >= instant  # at the instant itself what holds from there on
    rises = RISING[body["operator"]] * float(slope) > 0
    return Relation(after if rises else ca.logic_not(after), indicator, instant)
