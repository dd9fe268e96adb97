"""Small Modelica models for the tests of the exporter, translated or exported from their text."""

from pathlib import Path
from tempfile import mkdtemp

import casadi as ca

from pipeline.export.build import compile_fmus, library_name, write_contents
from pipeline.export.equations import translate
from pipeline.export.frontend import load
from tests.export.driver import Archive


def source_of(folder: Path, text: str, model: str = "M"):
    """The front end's Source of a model in a text, written into a folder of its own."""
    file = folder / f"{model}.mo"
    file.write_text(text)
    return load(file, model)


def model_of(folder: Path, text: str, model: str = "M", **start_values):
    """The sorted equations of a model in a text."""
    return translate(source_of(folder, text, model), start_values)


def write_fmu(model, path: Path, fmi: str = "2") -> Path:
    """The FMU of a sorted model."""
    compile_fmus(write_contents(model, library_name({fmi: path})), {fmi: path})
    return path


def archive_of(folder: Path, text: str, model: str = "M", fmi: str = "2", **start_values) -> Archive:
    """The FMU of a model in a text, unpacked."""
    path = write_fmu(model_of(folder, text, model, **start_values), folder / "fmus" / f"{model}.fmu", fmi)
    return Archive(path, mkdtemp(prefix=f"{model}-", dir=folder))


def integers(instance, *names: str) -> list[int]:
    """Values of Integer variables of an instance."""
    return instance.fmu.getInteger([instance.archive.references[name] for name in names])


def evaluate(model, states=None, **values):
    """Derivatives and algebraic variables by name, at start values where nothing else is given."""
    numbers = {v.name: v.start for kind in ("constant", "parameter", "input") for v in model.variables[kind]} | values
    for variable, value in zip(model.variables["calculated"], ca.vertsplit(model.calculated), strict=True):
        numbers[variable.name] = substitute(value, numbers)
    states_and_discretes = model.variables["state"] + model.variables["discrete"]
    for variable in sorted(states_and_discretes, key=lambda variable: variable.start is None):
        numbers.setdefault(variable.name, substitute(model.starts[variable.name], numbers))
    numbers |= {"time": 0.0} | (states or {})
    names = [v.name for kind in ("derivative", "algebraic") for v in model.variables[kind]]
    expressions = ca.vertsplit(ca.vertcat(model.derivatives, model.algebraics))
    solved = {name: substitute(value, numbers) for name, value in zip(names, expressions, strict=True)}
    return numbers | solved


def substitute(value, numbers):
    symbols = ca.symvar(value)
    if not symbols:
        return float(value)
    return float(ca.substitute(value, ca.vertcat(*symbols), ca.DM([numbers[s.name()] for s in symbols])))
