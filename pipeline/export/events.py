"""Events: sample instants, relations that switch, the initialisation; and what they do to z and x.

A when-clause acts where its trigger rises and its guard holds. Of several clauses for one variable the first acts.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import casadi as ca

from pipeline.export.arrays import flatten
from pipeline.export.expressions import Expressions, Scope
from pipeline.export.frontend import Source
from pipeline.export.relations import Relation, find_relations, name_relations
from pipeline.export.sorting import Equation
from pipeline.export.variables import Entry


@dataclass
class Events:
    """r (nr,) relations held between events, r_pre before the event, flags (1 + clocks): initialisation, samples.

    z_pre (nz,) are the discrete variables before the event; z and x are their values and the states after it.
    clocks: (period, phase) of each, as expressions of parameters; violated: one per assert, with its message.
    """

    time: ca.SX
    r: ca.SX
    r_pre: ca.SX
    flags: ca.SX
    symbols: dict[int, ca.SX]
    timed: set[int]
    relations: list[Relation] = field(default_factory=list)
    clocks: list[tuple[ca.SX, ca.SX]] = field(default_factory=list)
    z_pre: ca.SX = field(default_factory=lambda: ca.SX(0, 1))
    z: ca.SX = field(default_factory=lambda: ca.SX(0, 1))
    x: ca.SX = field(default_factory=lambda: ca.SX(0, 1))
    violated: ca.SX = field(default_factory=lambda: ca.SX(0, 1))
    messages: list[str] = field(default_factory=list)


def new_events(source: Source, time: ca.SX) -> Events:
    """The symbols of a model's events: one per relation that has one, and one per clock."""
    nodes, timed = find_relations(source)
    names = name_relations(source, nodes)
    r = ca.vertcat(ca.SX(0, 1), *[ca.SX.sym(name) for name in names])
    return Events(
        time=time,
        r=r,
        r_pre=ca.vertcat(ca.SX(0, 1), *[ca.SX.sym(f"pre({name})") for name in names]),
        flags=ca.vertcat(ca.SX.sym("initial()"), *[ca.SX.sym("sample()") for _ in source.dae["clocks"]]),
        symbols={node: r[k] for k, node in enumerate(nodes)},
        timed=timed,
    )


def conditions(source: Source, events: Events) -> dict[tuple[str, int], ca.SX]:
    """The coordinates that initial() and sample() are, by themselves, in an expression."""
    found = {}
    for c, entry in enumerate(source.dae["conditions"]):
        if entry["node"] == "initial":
            found["condition", c] = events.flags[0]
        elif isinstance(entry["node"], dict) and "clock" in entry["node"]:
            found["condition", c] = events.flags[1 + entry["node"]["clock"]]
    return found


class Discrete:
    """Reads the discrete part of a model into its Events."""

    def __init__(self, expressions: Expressions, entries: list[Entry], scope: Scope, events: Events):
        self.source, self.expressions, self.scope, self.events = expressions.source, expressions, scope, events
        self.entries = {entry.i: entry for entry in entries}
        self.rooted = {node: k for k, node in enumerate(events.symbols)}
        self.pre = {
            scalar.name: symbol
            for entry in entries
            if entry.pre is not None
            for scalar, symbol in zip(entry.scalars, flatten(entry.pre), strict=True)
        }
        # what is known of the time before the event: the relations that have one, and the discrete variables
        before = {(entry.role, entry.i): entry.pre for entry in entries if entry.pre is not None}
        parameters = [s for e in entries for s in e.scalars if s.kind in ("constant", "parameter", "calculated")]
        self.scope_pre = Scope({**scope.coordinates, **before})
        self.known_before = {symbol.name() for symbol in ca.symvar(events.r_pre)}
        self.known_before |= {symbol.name() for symbol in self.pre.values()}
        self.known_before |= {scalar.name for scalar in parameters}

    # --- conditions ------------------------------------------------------------------------------------------------

    def level(self, c: int) -> ca.SX:
        """Condition c at the event."""
        return self._level(c, self.events.r, self.events.flags, self.scope)

    def _level(self, c: int, r: ca.SX, flags: ca.SX, scope: Scope) -> ca.SX:
        node = self.source.dae["conditions"][c]["node"]
        kind, body = (node, None) if isinstance(node, str) else next(iter(node.items()))
        if kind == "initial":
            return flags[0]
        if kind == "always":
            return ca.SX(1)
        if kind == "clock":
            return flags[1 + body]
        if kind == "relation":
            node = self.source.dae["relations"][body]["relation"]["expression"]
            return r[self.rooted[node]] if node in self.rooted else self.expressions.read(node, scope)
        if kind == "discrete":
            return self.expressions.read(body, scope)
        if kind == "not":
            return ca.logic_not(self._level(body, r, flags, scope))
        if kind in ("and", "or", "any_rise"):
            operation = ca.logic_and if kind == "and" else ca.logic_or
            return operation(*(self._level(body[side], r, flags, scope) for side in ("lhs", "rhs")))
        raise self.source.refuse(f"a condition of kind {kind} cannot be exported", self.source.dae["conditions"][c])

    def rises(self, c: int) -> ca.SX:
        """Condition c becomes true at this event; at the initialisation none does but initial()."""
        entry = self.source.dae["conditions"][c]
        node = entry["node"]
        if isinstance(node, dict) and "any_rise" in node:
            return ca.logic_or(self.rises(node["any_rise"]["lhs"]), self.rises(node["any_rise"]["rhs"]))
        before = self._level(c, self.events.r_pre, ca.SX.zeros(self.events.flags.shape), self.scope_pre)
        if {symbol.name() for symbol in ca.symvar(before)} - self.known_before:
            raise self.source.refuse("a when-clause on this condition cannot be exported", entry)
        risen = ca.logic_and(self.level(c), ca.logic_not(before))
        return risen if node == "initial" else ca.logic_and(risen, ca.logic_not(self.events.flags[0]))

    def active(self, activation: Any) -> ca.SX | None:
        """When a clause acts; None: always."""
        if activation == "always":
            return None
        when = activation["when"]
        return ca.logic_and(self.rises(when["trigger"]), self.level(when["guard"]))

    # --- assignments -----------------------------------------------------------------------------------------------

    def read(self) -> list[Equation]:
        """One equation for every discrete variable: the first clause that acts, else its value before."""
        clauses: dict[str, dict[str, tuple[ca.SX | None, ca.SX, str]]] = {}  # by variable and activation
        for entry in self.source.dae["discrete_real_equations"]:
            self._read_real(entry, clauses)
        for entry in self.source.dae["discrete_value_owners"]:
            self._read_value(entry, clauses)
        scalars = [s for entry in self.entries.values() for s in entry.scalars if s.kind == "discrete"]
        equations = []
        for scalar in scalars:
            value, place = self.pre[scalar.name], ""
            for active, rhs, place in reversed(clauses.pop(scalar.name, {}).values()):  # noqa: B007
                value = rhs if active is None else ca.if_else(active, rhs, value)
            equations.append(Equation(scalar.symbol - value, place))
        if clauses:
            raise self.source.refuse(f"an assignment to {', '.join(clauses)} in a when-clause cannot be exported")
        return equations

    def _read_real(self, entry: dict, clauses: dict) -> None:
        kind, body = self.expressions.nodes[entry["residual"]]
        if kind != "binary" or body["operator"] != "subtract":
            raise self.source.refuse("an equation in a when-clause must be `variable = expression`", entry)
        targets = flatten(self.expressions.read(body["lhs"], self.scope))
        values = flatten(self.expressions.read(body["rhs"], self.scope))
        active, place = self.active(entry["activation"]), self.source.place(entry)
        for target, value in zip(targets, values, strict=True):
            if not target.is_symbolic():
                raise self.source.refuse("an equation in a when-clause must be `variable = expression`", entry)
            # an algorithm may assign twice in one clause: the last assignment holds
            clauses.setdefault(target.name(), {})[str(entry["activation"])] = (active, value, place)

    def _read_value(self, entry: dict, clauses: dict) -> None:
        if entry["structure"] is not None:
            raise self.source.refuse("an array of discrete values cannot be exported", entry)
        for branch in entry["branches"]:
            active, place = self.active(branch["activation"]), self.source.place(entry)
            for target, value in zip(entry["targets"], branch["values"], strict=True):
                if set(value) - {"provenance"} != {"value"}:
                    raise self.source.refuse("this assignment of a discrete value cannot be exported", entry)
                items = flatten(self.expressions.read(value["value"], self.scope))
                for scalar, item in zip(self.entries[target].scalars, items, strict=True):
                    clauses.setdefault(scalar.name, {})[str(branch["activation"])] = (active, item, place)

    def actions(self, states: dict[str, ca.SX]) -> dict[str, ca.SX]:
        """States after reinit(); asserts are collected on the way."""
        after, violated = dict(states), []
        for entry in self.source.dae["event_actions"]:
            kind, body = next(iter(entry["kind"].items()))
            guard = self.level(entry["guard"])
            if kind == "reinitialize":
                active = ca.logic_and(self.rises(entry["trigger"]), guard)
                values = flatten(self.expressions.read(body["value"], self.scope))
                for scalar, value in zip(self.entries[body["state"]].scalars, values, strict=True):
                    after[scalar.name] = ca.if_else(active, value, after[scalar.name])
            elif kind == "assert":
                violated.append(guard)
                self.events.messages.append(self._message(body["message"], entry))
            elif kind != "warning":  # which has no influence on the model (language specification 3.6, section 8.3.7)
                raise self.source.refuse(f"{kind} cannot be exported", entry)
        self.events.violated = ca.vertcat(*violated) if violated else ca.SX(0, 1)
        return after

    def _message(self, node: int, entry: dict) -> str:
        kind, body = self.expressions.nodes[node]
        text = body["string"] if kind == "literal" and "string" in body else "assertion violated"
        return f"{text} ({self.source.place(entry)})"
