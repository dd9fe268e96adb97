"""Other people's Modelica: the models that a folder or a file holds, and the FMU of one of them."""

from __future__ import annotations

import time
from difflib import get_close_matches
from pathlib import Path

from pipeline.errors import ExportError
from pipeline.export.build import SUFFIX, VERSIONS, Built, export
from pipeline.export.catalogue import Recipe, identifier
from pipeline.export.classes import find_models

SHOWN = 12


def list_models(modelica: Path) -> list[str]:
    """Full names of the models in a package folder, a folder of .mo files, or a .mo file; ExportError without one."""
    files = sorted(modelica.rglob("*.mo")) if modelica.is_dir() else [modelica]
    try:
        models = find_models({str(file): file.read_text(encoding="utf-8") for file in files})
    except (OSError, UnicodeDecodeError) as error:
        raise ExportError(f"{modelica}: cannot be read ({error}); give a folder of .mo files or a .mo file") from error
    if not models:
        raise ExportError(f"{modelica}: no model in it; give the folder of a package, or a .mo file")
    return models


def build_foreign(modelica: Path, model: str | None, output: Path | None = None, fmi: str = "2") -> list[Built]:
    """The FMUs of `model`, written to `output` (None: `<model_in_snake_case>.fmu` here); ExportError.

    fmi: "2", "3" or "both": then the FMI 3.0 one stands beside it, `_fmi3` behind its name.
    """
    models = list_models(modelica)
    if model is None:
        raise ExportError(f"{modelica}: give --model, one of {some(models)}")
    path = output or Path(f"{identifier(model)}.fmu")
    if path.suffix != ".fmu":
        raise ExportError(f"{path}: an FMU's file name ends in .fmu")
    files = {version: path.with_stem(path.stem + SUFFIX[version]) for version in VERSIONS[fmi]}
    if output and len(files) == 1:
        files = {fmi: output}
    started = time.perf_counter()
    try:
        export(modelica, Recipe(model, {}), files)
    except ExportError as error:
        if model in models or "front end refuses" not in str(error):
            raise
        near = get_close_matches(model, models, SHOWN, cutoff=0.4) or models
        raise ExportError(f"{modelica}: no model {model}; there are {some(near)}") from error
    seconds = time.perf_counter() - started
    return [Built(path.stem, file, seconds, False) for file in files.values()]


def some(names: list[str]) -> str:
    """The names, a dozen at most."""
    more = len(names) - SHOWN
    return ", ".join(names[:SHOWN]) + (f" and {more} more" if more > 0 else "")
