"""Equations: the DAE of a model → sorted CasADi functions of (t, x, u, p, z, r).

t time, x continuous states, u inputs, p parameters (constants, settable ones, calculated ones), z discrete variables,
r the values that relations keep between events. Derivatives and algebraic variables come from the continuous
equations; what happens at an event (a sample instant, a relation that switches, the initialisation) is one function
that gives z and x after it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca

from pipeline.errors import ExportError
from pipeline.export.arrays import Value, elementwise, flatten
from pipeline.export.clocks import read_clocks
from pipeline.export.events import Discrete, Events, conditions, new_events
from pipeline.export.expressions import Expressions, Scope
from pipeline.export.frontend import Source
from pipeline.export.parameters import bind_parameters
from pipeline.export.relations import Relation, read_relation
from pipeline.export.sorting import Equation, solve
from pipeline.export.starts import read_starts
from pipeline.export.units import per_second
from pipeline.export.variables import COORDINATE, KINDS, Entry, Variable, apply_limits, declare

INTERNAL = ("internalStep", "internalOrder")
"""The parameters of Co-Simulation that every integrated model gets beside its own."""


@dataclass(frozen=True)
class Model:
    """A sorted model: its scalar variables by kind, and its expressions.

    derivatives (nx,) and algebraics (ny,) in the order of the variables of these kinds; calculated (nc,) in constants
    and settable parameters; starts: by name, in parameters; events: what happens at an event.
    """

    name: str
    description: str
    variables: dict[str, list[Variable]]
    derivatives: ca.SX
    algebraics: ca.SX
    calculated: ca.SX
    starts: dict[str, ca.SX]
    events: Events
    experiment: dict[str, float]

    def symbols(self, *kinds: str) -> ca.SX:
        """The symbols (n, 1) of these kinds."""
        return column([variable.symbol for kind in kinds for variable in self.variables[kind]])

    def start(self, *kinds: str) -> ca.SX:
        """The start values (n, 1) of these kinds."""
        return column([self.starts[variable.name] for kind in kinds for variable in self.variables[kind]])

    def arguments(self, z: ca.SX | None = None) -> list[ca.SX]:
        """(t, x, u, p, z, r), the arguments of every function of the model."""
        p = self.symbols("constant", "parameter", "calculated")
        z = self.symbols("discrete") if z is None else z
        return [self.events.time, self.symbols("state"), self.symbols("input"), p, z, self.events.r]


def column(items: list[ca.SX]) -> ca.SX:
    """A column (n, 1), also for n = 0."""
    return ca.vertcat(*items) if items else ca.SX(0, 1)


def translate(source: Source, start_values: Mapping[str, float] | None = None) -> Model:
    """The model with its equations sorted; ExportError names what cannot be exported."""
    try:
        model = _translate(source, dict(start_values or {}))
    except ExportError:
        raise
    except (LookupError, TypeError, ValueError, RuntimeError) as error:
        what = " ".join(f"{type(error).__name__} {error}".split())
        raise source.refuse(f"the front end gives it in a form that is not understood: {what}") from error
    _check_closed(source, model)
    return model


def _translate(source: Source, start_values: dict[str, float]) -> Model:
    expressions, entries = Expressions(source), declare(source)
    time = ca.SX.sym("time")
    coordinates = _coordinates(entries, time)
    parameters = bind_parameters(expressions, entries, Scope(coordinates), start_values)
    expressions.known = {s.name: s.start for e in entries for s in e.scalars if s.kind == "constant"}
    for entry in entries:
        apply_limits(expressions, entry, parameters, Scope(coordinates))
    variables = _by_kind(entries)

    events = new_events(source, time)
    coordinates |= conditions(source, events)
    scope = Scope(coordinates, events.symbols)
    continuous = _residuals(expressions, source.dae["continuous_equation_operations"], scope)
    unknown = [variable.symbol for kind in ("derivative", "algebraic") for variable in variables[kind]]
    solution = solve(continuous, unknown, source.model, parameters)
    _solve_events(expressions, entries, parameters, scope, events, continuous, unknown, solution)
    events.clocks = read_clocks(source, parameters)
    initial = _residuals(expressions, source.dae["initialization_equation_operations"], scope)
    starts = read_starts(expressions, entries, scope, initial, unknown, solution)
    n = len(variables["state"])
    model = Model(
        name=source.model,
        description=source.flat["model_description"] or "",
        variables=variables,
        derivatives=column(solution[:n]),
        algebraics=column(solution[n:]),
        calculated=column([parameters.expressions[v.name] for v in variables["calculated"]]),
        starts=starts,
        events=events,
        experiment=source.experiment(),
    )
    mark_tunable(model, parameters.expressions)
    if n or any(relation.instant is None and ca.depends_on(relation.indicator, time) for relation in events.relations):
        taken = {variable.name for members in variables.values() for variable in members}
        for name in INTERNAL:
            if name in taken:
                raise source.refuse(f"a variable named {name} would hide the parameter of Co-Simulation: rename it")
        model.variables["parameter"] += [_internal_step(), _internal_order()]
    return model


def _check_closed(source: Source, model: Model) -> None:
    """Continuous equations may name states, inputs, parameters, discrete variables and time, nothing else."""
    known = {symbol.name() for argument in model.arguments() for symbol in ca.symvar(argument)}
    for kind, values in (("derivative", model.derivatives), ("algebraic", model.algebraics)):
        for variable, value in zip(model.variables[kind], ca.vertsplit(values) if values.numel() else [], strict=True):
            strange = {symbol.name() for symbol in ca.symvar(value)} - known
            if strange:
                what = f"{variable.name} depends on {', '.join(sorted(strange))} outside a when-clause"
                raise source.refuse(f"{what}, which cannot be exported")


def _coordinates(entries: list[Entry], time: ca.SX) -> dict[tuple[str, int], Value]:
    """The value of every coordinate of the DAE; `pre` and derivatives get symbols of their own."""
    coordinates: dict[tuple[str, int], Value] = {("time", 0): time}
    for entry in entries:
        coordinates[COORDINATE[entry.role], entry.i] = entry.value
        if entry.role == "state":
            coordinates["derivative", entry.i] = entry.derivative = _renamed("der({})", entry.value)
            coordinates["pre_state", entry.i] = entry.value
        elif entry.role in ("discrete_real", "discrete_value"):
            coordinates[f"pre_{entry.role}", entry.i] = entry.pre = _renamed("pre({})", entry.value)
    return coordinates


def _renamed(pattern: str, value: Value) -> Value:
    return elementwise(lambda symbol: ca.SX.sym(pattern.format(symbol.name())), value)


def _by_kind(entries: list[Entry]) -> dict[str, list[Variable]]:
    variables: dict[str, list[Variable]] = {kind: [] for kind in KINDS}
    for entry in entries:
        for scalar in entry.scalars:
            variables[scalar.kind].append(scalar)
        if entry.derivative is not None:
            for scalar, symbol in zip(entry.scalars, flatten(entry.derivative), strict=True):
                unit = per_second(scalar.unit) if scalar.unit else None
                description = f"Derivative of {scalar.name}"
                derivative = Variable(symbol.name(), "derivative", symbol, unit=unit, description=description)
                variables["derivative"].append(derivative)
    return variables


def _residuals(expressions: Expressions, operations: list[dict], scope: Scope) -> list[Equation]:
    """The scalar residuals of an equation section, for-families and array equations written out."""
    equations = []
    for entry in operations:
        kind, body = next(iter(entry.items()))
        place = expressions.source.place(entry)
        if kind == "residual":
            items = flatten(expressions.read(body["residual"], scope))
        elif kind == "structured" and body["scalar_view"] == "RowMajorProjection":
            items = [item for node in body["bodies"] for item in flatten(expressions.read(node, scope))]
        elif kind == "structured" and body["scalar_view"] == "BinderSubstitution":
            inner = expressions.iterate(body["domain"], scope)
            items = [item for s in inner for node in body["bodies"] for item in flatten(expressions.read(node, s))]
        else:
            raise expressions.source.refuse(f"an equation of kind {kind} cannot be exported", entry)
        equations += [Equation(item, place) for item in items]
    return equations


def _solve_events(expressions, entries, parameters, scope, events, continuous, unknown, solution) -> None:
    """Fill in the relations and what an event does: all equations hold at once, the active when-clauses with them."""

    def resolve(value: ca.SX, symbols: list[ca.SX], values: list[ca.SX]) -> ca.SX:
        return ca.substitute(value, ca.vertcat(*symbols), ca.vertcat(*values)) if symbols else value

    # between events pre(d) is d; at one, a pass of the iteration starts from the d of the last
    held = {(f"pre_{entry.role}", entry.i): entry.value for entry in entries if entry.pre is not None}
    plain = Scope({**scope.coordinates, **held})
    nominals = {scalar.name: scalar.nominal for entry in entries for scalar in entry.scalars if scalar.nominal}
    for node in events.symbols:
        relation = read_relation(expressions, node, plain, events, nominals)
        truth, indicator = (resolve(value, unknown, solution) for value in (relation.truth, relation.indicator))
        events.relations.append(Relation(truth, indicator, relation.instant))
    discrete = Discrete(expressions, entries, scope, events)
    equations = discrete.read()
    z = [scalar.symbol for entry in entries for scalar in entry.scalars if scalar.kind == "discrete"]
    everything = solve(equations + continuous, z + unknown, expressions.source.model, parameters)
    states = [scalar for entry in entries for scalar in entry.scalars if scalar.kind == "state"]
    after = discrete.actions({scalar.name: scalar.symbol for scalar in states})
    events.z = column(everything[: len(z)])
    events.x = resolve(column([after[scalar.name] for scalar in states]), z + unknown, everything)
    events.violated = resolve(events.violated, z + unknown, everything)
    events.z_pre = column([item for entry in entries if entry.pre is not None for item in flatten(entry.pre)])


def mark_tunable(model: Model, calculated: dict[str, ca.SX]) -> None:
    """A parameter is tunable if a running model reads it; those of start values and sample periods are fixed."""
    running = ca.vertcat(model.derivatives, model.algebraics, model.events.z, model.events.x, model.events.violated)
    running = ca.vertcat(running, *[relation.truth for relation in model.events.relations])
    read = {symbol.name() for symbol in ca.symvar(running)}
    read |= {s.name() for name, value in calculated.items() if name in read for s in ca.symvar(value)}
    periods = {symbol.name() for clock in model.events.clocks for value in clock for symbol in ca.symvar(value)}
    for variable in model.variables["parameter"]:
        variable.tunable = variable.name in read - periods
    tunable = {variable.name for variable in model.variables["parameter"] if variable.tunable}
    for variable in model.variables["calculated"]:
        variable.tunable = any(symbol.name() in tunable for symbol in ca.symvar(calculated[variable.name]))


def _internal_step() -> Variable:
    name = INTERNAL[0]
    return Variable(
        name, "parameter", ca.SX.sym(name), tunable=True, start=2.5e-4, unit="s", minimum=1e-9, quantity="Time",
        description="Longest internal step of Co-Simulation",
    )  # fmt: skip


def _internal_order() -> Variable:
    name = INTERNAL[1]
    return Variable(
        name, "parameter", ca.SX.sym(name), tunable=True, start=4.0, minimum=1.0, maximum=4.0,
        description="Order of Co-Simulation's internal steps: 4 (Runge-Kutta) or 1 (explicit Euler)",
    )  # fmt: skip
