"""The model description of FMI 2.0 (2.0.5, section 2.2)."""

from __future__ import annotations

from xml.etree import ElementTree as ET

from pipeline.export.equations import Model
from pipeline.export.model_description import (
    add_experiment,
    add_log_categories,
    add_units,
    begin,
    describe_variable,
    listed,
    restarted,
    structure,
    to_text,
    type_attributes,
)

CAPABILITIES = {
    "canNotUseMemoryManagementFunctions": "true",
    "canGetAndSetFMUstate": "true",
    "canSerializeFMUstate": "true",
    "providesDirectionalDerivative": "true",
}


def describe(model: Model, name: str, guid: str, sources: list[str]) -> str:
    """modelDescription.xml for Model Exchange and Co-Simulation; name: the model identifier."""
    root = begin(model, "2.0", {"guid": guid})
    root.set("numberOfEventIndicators", str(len(model.events.relations)))
    for kind in ("ModelExchange", "CoSimulation"):
        element = ET.SubElement(root, kind, modelIdentifier=name, **CAPABILITIES)
        if kind == "CoSimulation":
            element.set("canHandleVariableCommunicationStepSize", "true")
        files = ET.SubElement(element, "SourceFiles")
        for source in sources:
            ET.SubElement(files, "File", name=source)
    add_units(root, listed(model))
    add_log_categories(root)
    add_experiment(root, model.experiment)
    _add_variables(root, model)
    _add_structure(root, model)
    return to_text(root)


def _add_variables(root: ET.Element, model: Model) -> None:
    element, changing = ET.SubElement(root, "ModelVariables"), restarted(model)
    state_of = _states(model)
    for i, variable in enumerate(listed(model)):
        scalar = ET.SubElement(element, "ScalarVariable")
        initial = describe_variable(scalar, variable, i)
        kind = ET.SubElement(scalar, variable.type, type_attributes(variable, initial))
        if variable.name in changing:
            kind.set("reinit", "true")
        if variable.kind == "derivative":
            kind.set("derivative", state_of[variable.name])


def _states(model: Model) -> dict[str, str]:
    """The 1-based index of the state of every derivative."""
    names = [variable.name for variable in listed(model)]
    pairs = zip(model.variables["derivative"], model.variables["state"], strict=True)
    return {derivative.name: str(names.index(state.name) + 1) for derivative, state in pairs}


def _add_structure(root: ET.Element, model: Model) -> None:
    """<ModelStructure>, by 1-based indices; the initial unknowns in their order (2.0.5, section 2.2.8)."""
    known, element = structure(model), ET.SubElement(root, "ModelStructure")
    position = {variable.name: i + 1 for i, variable in enumerate(listed(model))}
    groups = {
        "Outputs": known.outputs,
        "Derivatives": known.derivatives,
        "InitialUnknowns": known.initial,
    }
    for name, unknowns in groups.items():
        group = ET.SubElement(element, name) if unknowns else None
        for unknown, used in unknowns.items():
            indices = sorted(position[item] for item in used if item in position)  # `time` is no variable here
            entry = ET.SubElement(group, "Unknown", index=str(position[unknown]))
            entry.set("dependencies", " ".join(map(str, indices)))
