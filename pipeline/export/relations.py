"""Relations that have an event: their truth, the indicator that locates it, and the instant where time alone decides.

The front end owns a relation as a root (located by its indicator), or as a time event: `time >= T`, whose instant is
known beforehand. T is kept as an expression, so that it follows the parameters.

An importer may stop at a root where the indicator is exactly 0, and to FMI (2.0.5 and 3.0.2, section 3.1.1) that is the
domain z <= 0, whatever the relation says there. The indicator is therefore moved away from 0 by a hysteresis, on the
side where the relation stands: at its root lhs − rhs has passed 0, and the relation, which has no hysteresis, switches.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Protocol

import casadi as ca

from pipeline.export.expressions import Expressions, Scope
from pipeline.export.frontend import Source, find_span

RISING = {"greater": 1, "greater_equal": 1, "less": -1, "less_equal": -1}
HYSTERESIS = 1e-12  # in nominal values: above round-off, below any tolerance of an integrator


class Held(Protocol):
    """What is known of a model's relations before they are read: the symbols that hold them, and the time events."""

    time: ca.SX
    symbols: dict[int, ca.SX]
    timed: set[int]


@dataclass(frozen=True)
class Relation:
    """A relation that has an event: its truth; its indicator, lhs − rhs and the hysteresis, never 0 after an event.

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


def name_relations(source: Source, nodes: list[int]) -> list[str]:
    """What messages call the relations: their text and place; a number where several have the same."""
    names: list[str] = []
    for k, node in enumerate(nodes):
        provenance = source.dae["expressions"]["provenance"][node]
        name = f"the relation {source.text(provenance)} ({source.place(provenance)})"
        names.append(f"{name} [{k + 1}]" if name in names else name)
    return names


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


def read_relation(
    expressions: Expressions, node: int, scope: Scope, events: Held, nominals: Mapping[str, float]
) -> Relation:
    """The relation of a node, its operands as they are in `scope`; nominals: of the variables that have one."""
    body = expressions.nodes[node][1]
    lhs, rhs = (expressions.read(body[side], scope) for side in ("lhs", "rhs"))
    difference, time = lhs - rhs, events.time
    side = RISING.get(body["operator"], 0) * (2 * events.symbols[node] - 1)
    indicator = difference + HYSTERESIS * scale(difference, nominals) * side
    slope = ca.jacobian(difference, time)
    if node not in events.timed or not slope.is_constant() or float(slope) == 0:
        return Relation(expressions.read(node, scope), indicator)
    instant = -ca.substitute(difference, time, 0) / slope
    after = time >= instant  # at the instant itself what holds from there on
    rises = RISING[body["operator"]] * float(slope) > 0
    return Relation(after if rises else ca.logic_not(after), indicator, instant)


def scale(value: ca.SX, nominals: Mapping[str, float]) -> float:
    """The largest nominal value of the variables in an expression; 1 where none is given."""
    given = [abs(nominals[symbol.name()]) for symbol in ca.symvar(value) if symbol.name() in nominals]
    return max(given, default=1.0) or 1.0
