"""Variants: a model with some of its parameters as continuous inputs.

A directional derivative by an input is legal at any time, one by a parameter in the initialisation only (FMI 2.0.5,
section 2.2.8): the variant of a plant is for filters that estimate its parameters.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import casadi as ca

from pipeline.errors import ExportError
from pipeline.export.equations import INTERNAL, Model, column
from pipeline.export.events import Events
from pipeline.export.relations import Relation
from pipeline.export.variables import Variable


def with_inputs(model: Model, names: Sequence[str]) -> Model:
    """The model with the parameters `names` as continuous inputs, which start at the parameters' values.

    What was calculated from them becomes an algebraic variable. Raises ExportError for what is no settable parameter.
    """
    if not names:
        return model
    chosen = [find_parameter(model, name) for name in names]
    known = column([variable.symbol for variable in chosen])
    pairs = list(zip(model.variables["calculated"], ca.vertsplit(model.calculated), strict=True))
    moved = [(variable, value) for variable, value in pairs if ca.depends_on(value, known)]
    kept = [(variable, value) for variable, value in pairs if not ca.depends_on(value, known)]
    symbols, values = column([variable.symbol for variable, _ in moved]), column([value for _, value in moved])

    def resolve(expression: ca.SX) -> ca.SX:
        return ca.substitute(expression, symbols, values) if moved and expression.numel() else expression

    variables = model.variables | {
        "parameter": [variable for variable in model.variables["parameter"] if variable not in chosen],
        "calculated": [variable for variable, _ in kept],
        "input": model.variables["input"] + [replace(v, kind="input", tunable=False) for v in chosen],
        "algebraic": model.variables["algebraic"] + [replace(v, kind="algebraic", tunable=False) for v, _ in moved],
    }
    starts = {name: resolve(value) for name, value in model.starts.items()}
    return replace(
        model,
        variables=variables,
        derivatives=resolve(model.derivatives),
        algebraics=ca.vertcat(resolve(model.algebraics), values),
        calculated=column([value for _, value in kept]),
        starts=starts | {variable.name: ca.SX(variable.start) for variable in chosen},
        events=resolve_events(model.events, resolve),
    )


def find_parameter(model: Model, name: str) -> Variable:
    """The settable parameter of this name, which no sample period follows from."""
    parameters = {variable.name: variable for variable in model.variables["parameter"]}
    if name not in parameters or name in INTERNAL:
        own = ", ".join(other for other in parameters if "." not in other and other not in INTERNAL)
        raise ExportError(f"{model.name}: {name} is no parameter that could become an input; there are {own}")
    if any(ca.depends_on(value, parameters[name].symbol) for clock in model.events.clocks for value in clock):
        raise ExportError(f"{model.name}: a sample period follows from {name}, which cannot become an input")
    return parameters[name]


def resolve_events(events: Events, resolve) -> Events:
    """The events with `resolve` applied to their expressions."""
    return replace(
        events,
        relations=[resolve_relation(relation, resolve) for relation in events.relations],
        z=resolve(events.z),
        x=resolve(events.x),
        violated=resolve(events.violated),
    )


def resolve_relation(relation: Relation, resolve) -> Relation:
    """The relation with `resolve` applied to its expressions."""
    instant = None if relation.instant is None else resolve(relation.instant)
    return replace(relation, truth=resolve(relation.truth), indicator=resolve(relation.indicator), instant=instant)
