"""The model description and the build description of FMI 3.0 (3.0.2, sections 2.4 and 2.5).

Beside the variables of FMI 2.0 there are `time` and one variable for each event indicator, with the value references
that wrapper/model.h gives them.
"""

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
    "canGetAndSetFMUState": "true",
    "canSerializeFMUState": "true",
    "providesDirectionalDerivatives": "true",
    "providesAdjointDerivatives": "true",
}
TYPES = {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean"}


def describe(model: Model, name: str, token: str) -> str:
    """modelDescription.xml for Model Exchange and Co-Simulation; name: the model identifier."""
    root = begin(model, "3.0", {"instantiationToken": token})
    ET.SubElement(root, "ModelExchange", modelIdentifier=name, **CAPABILITIES)
    step = {"canHandleVariableCommunicationStepSize": "true"}
    ET.SubElement(root, "CoSimulation", modelIdentifier=name, **CAPABILITIES, **step)
    add_units(root, listed(model))
    add_log_categories(root)
    add_experiment(root, model.experiment)
    references = value_references(model)
    _add_variables(root, model, references)
    _add_structure(root, model, references)
    return to_text(root)


def describe_build(name: str, sources: list[str]) -> str:
    """sources/buildDescription.xml: the files to compile."""
    root = ET.Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = ET.SubElement(root, "BuildConfiguration", modelIdentifier=name)
    files = ET.SubElement(configuration, "SourceFileSet", language="C11")
    for source in sources:
        ET.SubElement(files, "SourceFile", name=source)
    return to_text(root)


def indicator_names(model: Model) -> list[str]:
    """The names of the event indicators."""
    return [f"'event indicator {i + 1}'" for i in range(len(model.events.relations))]


def value_references(model: Model) -> dict[str, int]:
    """The value reference of every variable, event indicators and time at the end."""
    names = [variable.name for variable in listed(model)] + indicator_names(model) + ["time"]
    return {name: i for i, name in enumerate(names)}


def _add_variables(root: ET.Element, model: Model, references: dict[str, int]) -> None:
    element, changing = ET.SubElement(root, "ModelVariables"), restarted(model)
    derivatives = zip(model.variables["derivative"], model.variables["state"], strict=True)
    state_of = {derivative.name: str(references[state.name]) for derivative, state in derivatives}
    for variable in listed(model):
        item = ET.SubElement(element, TYPES[variable.type])
        initial = describe_variable(item, variable, references[variable.name])
        item.attrib.update(type_attributes(variable, initial))
        if variable.name in changing:
            item.set("reinit", "true")
        if variable.kind == "derivative":
            item.set("derivative", state_of[variable.name])
    for name in indicator_names(model):
        local = {"causality": "local", "variability": "continuous", "initial": "calculated"}
        ET.SubElement(element, "Float64", name=name, valueReference=str(references[name]), **local)
    independent = {"causality": "independent", "variability": "continuous"}
    ET.SubElement(element, "Float64", name="time", valueReference=str(references["time"]), **independent)


def _add_structure(root: ET.Element, model: Model, references: dict[str, int]) -> None:
    """<ModelStructure>, by value references."""
    known, element = structure(model), ET.SubElement(root, "ModelStructure")
    groups = {
        "Output": known.outputs,
        "ContinuousStateDerivative": known.derivatives,
        "InitialUnknown": known.initial,
        "EventIndicator": dict(zip(indicator_names(model), known.indicators, strict=True)),
    }
    for group, unknowns in groups.items():
        for unknown, used in unknowns.items():
            entry = ET.SubElement(element, group, valueReference=str(references[unknown]))
            entry.set("dependencies", " ".join(map(str, sorted(references[item] for item in used))))
