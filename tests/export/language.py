"""Small Modelica models for the tests of the exporter, translated or exported from their text."""

from pathlib import Path

from pipeline.export.build import write_fmu
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


def archive_of(folder: Path, text: str, model: str = "M", **start_values) -> Archive:
    """The FMU of a model in a text, unpacked."""
    return Archive(write_fmu(model_of(folder, text, model, **start_values), folder / "fmus" / f"{model}.fmu"))


def integers(instance, *names: str) -> list[int]:
    """Values of Integer variables of an instance."""
    return instance.fmu.getInteger([instance.archive.references[name] for name in names])
