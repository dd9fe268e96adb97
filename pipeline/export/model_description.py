"""The model description of an FMU (FMI 2.0.5, section 2.2): modelDescription.xml."""

from __future__ import annotations

from xml.etree import ElementTree as ET

import casadi as ca

from pipeline import __version__
from pipeline.export.equations import Model
from pipeline.export.units import parse
from pipeline.export.variables import KINDS, Variable

CAPABILITIES = {
    "canNotUseMemoryManagementFunctions": "true",
    "canGetAndSetFMUstate": "true",
    "canSerializeFMUstate": "true",
}


def describe(model: Model, name: str, guid: str, sources: list[str]) -> str:
    """modelDescription.xml of FMI 2.0 for Model Exchange and Co-Simulation."""
    root = ET.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=model.name.rsplit(".", 1)[-1],
        guid=guid,
        description=model.description,
        generationTool=f"fmuid {__version__}",
        variableNamingConvention="structured",
        numberOfEventIndicators=str(len(model.events.relations)),
    )
    for kind in ("ModelExchange", "CoSimulation"):
        element = ET.SubElement(root, kind, modelIdentifier=name, **CAPABILITIES)
        if kind == "CoSimulation":
            element.set("canHandleVariableCommunicationStepSize", "true")
        files = ET.SubElement(element, "SourceFiles")
        for source in sources:
            ET.SubElement(files, "File", name=source)
    variables = [variable for kind in KINDS for variable in model.variables[kind]]
    _add_units(root, variables)
    categories = ET.SubElement(root, "LogCategories")
    for category in ("logStatusDiscard", "logStatusError"):
        ET.SubElement(categories, "Category", name=category)
    _add_experiment(root, model.experiment)
    _add_variables(root, model, variables)
    _add_structure(root, model, variables)
    ET.indent(root)
    return ET.tostring(root, encoding="utf-8", xml_declaration=True).decode() + "\n"


def _add_units(root: ET.Element, variables: list[Variable]) -> None:
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


def _add_experiment(root: ET.Element, experiment: dict[str, float]) -> None:
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


def _add_variables(root: ET.Element, model: Model, variables: list[Variable]) -> None:
    element = ET.SubElement(root, "ModelVariables")
    restarted = {
        v.name for v, x in zip(model.variables["state"], symbols(model.events.x), strict=True) if not x.is_symbolic()
    }
    first_state = sum(len(model.variables[kind]) for kind in ("constant", "parameter", "calculated")) + 1
    first_derivative = variables.index(model.variables["derivative"][0]) if model.variables["derivative"] else 0
    for i, variable in enumerate(variables):
        place, variability, initial = causality(variable)
        scalar = ET.SubElement(element, "ScalarVariable", name=variable.name, valueReference=str(i))
        if variable.description:
            scalar.set("description", variable.description)
        scalar.set("causality", place)
        scalar.set("variability", variability)
        if initial:
            scalar.set("initial", initial)
        kind = ET.SubElement(scalar, variable.type, type_attributes(variable, initial))
        if variable.name in restarted:
            kind.set("reinit", "true")
        if variable.kind == "derivative":
            kind.set("derivative", str(first_state + i - first_derivative))


def type_attributes(variable: Variable, initial: str | None) -> dict[str, str]:
    """The attributes of <Real>, <Integer> or <Boolean>."""
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


def _add_structure(root: ET.Element, model: Model, variables: list[Variable]) -> None:
    structure = ET.SubElement(root, "ModelStructure")
    position = {variable.name: i + 1 for i, variable in enumerate(variables)}
    solved = solutions(model)
    outputs = [variable for variable in variables if variable.output and variable.kind != "constant"]
    derivatives = model.variables["derivative"]
    following = [v for kind in ("state", "discrete") for v in model.variables[kind] if v.start is None]
    initial = [v for v in outputs if causality(v)[2] == "calculated"]
    initial += model.variables["calculated"] + [v for v in following if v.kind == "state"] + derivatives
    running = {v.name for kind in ("input", "state") for v in model.variables[kind]}
    settable = {v.name for kind in ("constant", "parameter", "input") for v in model.variables[kind]}
    settable |= {v.name for kind in ("state", "discrete") for v in model.variables[kind] if v.start is not None}
    held = dict(zip([s.name() for s in symbols(model.symbols("discrete"))], symbols(model.events.z), strict=True))
    for name, members, known in (("Outputs", outputs, running), ("Derivatives", derivatives, running)):
        group = ET.SubElement(structure, name) if members else None
        for variable in members:
            used = used_names(solved[variable.name])
            used |= {n for name in used & held.keys() for n in used_names(held[name])}
            _add_unknown(group, position, variable.name, used & known)
    group = ET.SubElement(structure, "InitialUnknowns") if initial else None
    starts = model.starts | {
        v.name: e for v, e in zip(model.variables["calculated"], symbols(model.calculated), strict=True)
    }
    for variable in sorted({v.name for v in initial}, key=position.__getitem__):
        _add_unknown(group, position, variable, trace(variable, solved | starts, settable))


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


def trace(name: str, expressions: dict[str, ca.SX], known: set[str]) -> set[str]:
    """The knowns on which a variable depends, through whatever is computed in between."""
    found: set[str] = set()
    open_names, seen = [name], {name}
    while open_names:
        for used in used_names(expressions[open_names.pop()]) - seen:
            seen.add(used)
            if used in known:
                found.add(used)
            elif used in expressions:
                open_names.append(used)
    return found


def _add_unknown(group: ET.Element, position: dict[str, int], name: str, used: set[str]) -> None:
    indices = sorted(position[item] for item in used)
    unknown = ET.SubElement(group, "Unknown", index=str(position[name]))
    unknown.set("dependencies", " ".join(map(str, indices)))
