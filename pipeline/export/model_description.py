"""The model description of an FMU: what FMI 2.0 and 3.0 say alike. Each version has its writer in a file of its own."""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree import ElementTree as ET

import casadi as ca

from pipeline import __version__
from pipeline.export.equations import Model
from pipeline.export.units import parse
from pipeline.export.variables import KINDS, Variable


def begin(model: Model, version: str, token: dict[str, str]) -> ET.Element:
    """The root element: version, name and what else identifies the FMU."""
    return ET.Element(
        "fmiModelDescription",
        fmiVersion=version,
        modelName=model.name.rsplit(".", 1)[-1],
        **token,
        description=model.description,
        generationTool=f"fmuid {__version__}",
        variableNamingConvention="structured",
    )


def to_text(root: ET.Element) -> str:
    """The XML file of an element, indented."""
    ET.indent(root)
    return ET.tostring(root, encoding="utf-8", xml_declaration=True).decode() + "\n"


def listed(model: Model) -> list[Variable]:
    """Every variable, in the order of the value references."""
    return [variable for kind in KINDS for variable in model.variables[kind]]


def add_units(root: ET.Element, variables: list[Variable]) -> None:
    """<UnitDefinitions>, where a variable has a unit."""
    displays: dict[str, set[str]] = {}
    for variable in variables:
        if variable.unit:
            shown = {variable.display_unit} if variable.display_unit else set()
            displays.setdefault(variable.unit, set()).update(shown)
    if not displays:
        return
    definitions = ET.SubElement(root, "UnitDefinitions")
    for name in sorted(displays):
        element, unit = ET.SubElement(definitions, "Unit", name=name), parse(name)
        if unit is None:
            continue
        base = ET.SubElement(element, "BaseUnit", {key: str(value) for key, value in unit.exponents.items()})
        _set_scale(base, unit.factor, unit.offset)
        for display in sorted(displays[name] - {name}):
            shown = parse(display)
            if shown is not None and shown.exponents == unit.exponents:
                factor = unit.factor / shown.factor
                offset = (unit.offset - shown.offset) / shown.factor
                _set_scale(ET.SubElement(element, "DisplayUnit", name=display), factor, offset)


def _set_scale(element: ET.Element, factor: float, offset: float) -> None:
    if factor != 1.0:
        element.set("factor", repr(factor))
    if offset != 0.0:
        element.set("offset", repr(offset))


def add_log_categories(root: ET.Element) -> None:
    """<LogCategories>: the two that the wrapper writes to."""
    categories = ET.SubElement(root, "LogCategories")
    for category in ("logStatusDiscard", "logStatusError"):
        ET.SubElement(categories, "Category", name=category)


def add_experiment(root: ET.Element, experiment: dict[str, float]) -> None:
    """<DefaultExperiment>, where the model has an `experiment` annotation."""
    names = {"StartTime": "startTime", "StopTime": "stopTime", "Tolerance": "tolerance", "Interval": "stepSize"}
    given = {names[key]: repr(value) for key, value in experiment.items() if key in names}
    if given:
        ET.SubElement(root, "DefaultExperiment", given)


def causality(variable: Variable) -> tuple[str, str, str | None]:
    """(causality, variability, initial) of a variable; initial None: not stated."""
    computed = "exact" if variable.start is not None else "calculated"
    place = "output" if variable.output else "local"
    discrete = "continuous" if variable.type == "Real" else "discrete"
    tunable = "tunable" if variable.tunable else "fixed"
    return {
        "constant": (place, "constant", "exact"),
        "parameter": ("parameter", tunable, "exact"),
        "calculated": ("calculatedParameter", tunable, "calculated"),
        "state": (place, "continuous", computed),
        "discrete": (place, "discrete", computed),
        "input": ("input", discrete, None),
        "derivative": (place, "continuous", "calculated"),
        "algebraic": (place, discrete, "calculated"),
    }[variable.kind]


def describe_variable(element: ET.Element, variable: Variable, reference: int) -> str | None:
    """Set name, value reference, description, causality and variability of a variable; its `initial`."""
    place, variability, initial = causality(variable)
    element.set("name", variable.name)
    element.set("valueReference", str(reference))
    if variable.description:
        element.set("description", variable.description)
    element.set("causality", place)
    element.set("variability", variability)
    if initial:
        element.set("initial", initial)
    return initial


def type_attributes(variable: Variable, initial: str | None) -> dict[str, str]:
    """The attributes that depend on the type: unit, limits, start."""
    attributes: dict[str, str] = {}
    if variable.type == "Real":
        shown = variable.display_unit if variable.unit and displayable(variable) else None
        pairs = [("quantity", variable.quantity), ("unit", variable.unit), ("displayUnit", shown)]
        attributes |= {key: value for key, value in pairs if value}
    if variable.type != "Boolean":
        limits = [("min", variable.minimum), ("max", variable.maximum)]
        limits += [("nominal", variable.nominal)] if variable.type == "Real" else []
        attributes |= {key: literal(variable, value) for key, value in limits if value is not None}
    if initial != "calculated":
        attributes["start"] = literal(variable, variable.start or 0.0)
    return attributes


def displayable(variable: Variable) -> bool:
    """A display unit is listed where it measures the same quantity as the unit."""
    unit, shown = parse(variable.unit or ""), parse(variable.display_unit or "")
    return unit is not None and shown is not None and unit.exponents == shown.exponents


def literal(variable: Variable, value: float) -> str:
    """A number as the type writes it."""
    if variable.type == "Boolean":
        return "true" if value else "false"
    return str(int(value)) if variable.type == "Integer" else repr(float(value))


def restarted(model: Model) -> set[str]:
    """The names of the states that an event may change (`reinit`)."""
    after = zip(model.variables["state"], symbols(model.events.x), strict=True)
    return {variable.name for variable, x in after if not x.is_symbolic()}


@dataclass(frozen=True)
class Structure:
    """<ModelStructure>: for every unknown's name the names of the knowns it depends on; `time` may be among them.

    indicators: a set for each event indicator, in their order.
    """

    outputs: dict[str, set[str]]
    derivatives: dict[str, set[str]]
    initial: dict[str, set[str]]
    indicators: list[set[str]]


def structure(model: Model) -> Structure:
    """The true dependencies of outputs, derivatives and indicators, and of what is computed in the initialisation."""
    solved = solutions(model)
    outputs = [variable for variable in listed(model) if variable.output and variable.kind != "constant"]
    derivatives = model.variables["derivative"]
    running = {v.name for kind in ("input", "state") for v in model.variables[kind]} | {"time"}
    held = dict(zip([s.name() for s in symbols(model.symbols("discrete"))], symbols(model.events.z), strict=True))

    def depends(value: ca.SX) -> set[str]:
        return trace(value, held | switches(model), running)

    return Structure(
        outputs={v.name: depends(solved[v.name]) for v in outputs},
        derivatives={v.name: depends(solved[v.name]) for v in derivatives},
        initial=_initial(model, outputs, solved),
        indicators=[depends(relation.indicator) for relation in model.events.relations],
    )


def _initial(model: Model, outputs: list[Variable], solved: dict[str, ca.SX]) -> dict[str, set[str]]:
    following = [v for v in model.variables["state"] if v.start is None]
    wanted = {v.name for v in outputs if causality(v)[2] == "calculated"}
    wanted |= {v.name for v in model.variables["calculated"] + following + model.variables["derivative"]}
    settable = {v.name for kind in ("constant", "parameter", "input") for v in model.variables[kind]} | {"time"}
    settable |= {v.name for kind in ("state", "discrete") for v in model.variables[kind] if v.start is not None}
    calculated = zip(model.variables["calculated"], symbols(model.calculated), strict=True)
    expressions = solved | model.starts | {v.name: e for v, e in calculated} | switches(model)
    names = [variable.name for variable in listed(model) if variable.name in wanted]
    return {name: trace(expressions[name], expressions, settable) for name in names}


def switches(model: Model) -> dict[str, ca.SX]:
    """What decides the value of each relation, by the name of its symbol."""
    events = model.events
    return {r.name(): relation.indicator for r, relation in zip(symbols(events.r), events.relations, strict=True)}


def symbols(vector: ca.SX) -> list[ca.SX]:
    """The elements of a column."""
    return [vector[i] for i in range(vector.numel())]


def solutions(model: Model) -> dict[str, ca.SX]:
    """What every output, derivative and algebraic variable is computed by."""
    named = {v.name: e for v, e in zip(model.variables["algebraic"], symbols(model.algebraics), strict=True)}
    named |= {v.name: e for v, e in zip(model.variables["derivative"], symbols(model.derivatives), strict=True)}
    return named | {v.name: v.symbol for kind in ("state", "discrete") for v in model.variables[kind]}


def used_names(value: ca.SX) -> set[str]:
    """The names of the symbols in an expression."""
    return {symbol.name() for symbol in ca.symvar(value)}


def trace(value: ca.SX, expressions: dict[str, ca.SX], known: set[str]) -> set[str]:
    """The knowns on which a value depends, through whatever is computed in between."""
    seen: set[str] = set()
    open_names = used_names(value)
    while open_names:
        name = open_names.pop()
        seen.add(name)
        if name not in known and name in expressions:
            open_names |= used_names(expressions[name]) - seen
    return seen & known
