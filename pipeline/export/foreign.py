"""Other people's Modelica: the models that a folder or a file holds, and the FMU of one of them."""

from __future__ import annotations

import time
from difflib import get_close_matches
from pathlib import Path

from pipeline.errors import ConfigError
from pipeline.export.build import SUFFIX, VERSIONS, Built, export
from pipeline.export.catalogue import Recipe, identifier
from pipeline.export.classes import find_models
from pipeline.export.frontend import NoSuchModel

SHOWN = 3


def list_models(modelica: Path) -> list[str]:
    """Full names of the models in a package folder, a folder of .mo files, or a .mo file; ConfigError without one."""
    files = sorted(modelica.rglob("*.mo")) if modelica.is_dir() else [modelica]
    try:
        models = find_models({str(file): file.read_text(encoding="utf-8") for file in files})
    except FileNotFoundError as error:
        raise ConfigError(f"{modelica}: no such folder or file; give a folder of .mo files or a .mo file") from error
    except (OSError, UnicodeDecodeError) as error:
        why = error.strerror if isinstance(error, OSError) else "it is not UTF-8"
        raise ConfigError(f"{modelica}: cannot be read ({why}); give a folder of .mo files or a .mo file") from error
    if not models:
        raise ConfigError(f"{modelica}: no model in it; give the folder of a package, or a .mo file")
    return models


def build_foreign(modelica: Path, model: str | None, output: Path | None = None, fmi: str = "2") -> list[Built]:
    """The FMUs of `model`, written to `output` (None: `<model_in_snake_case>.fmu` here); ExportError, ConfigError.

    fmi: "2", "3" or "both": then the FMI 3.0 one stands beside it, `_fmi3` behind its name.
    """
    if output and output.suffix != ".fmu":
        raise ConfigError(f"{output}: an FMU's file name ends in .fmu")
    models = list_models(modelica)
    if model is None:
        raise ConfigError(f"{modelica}: give --model, one of {', '.join(models)}")
    path = output or Path(f"{identifier(model)}.fmu")
    files = {version: path.with_stem(path.stem + SUFFIX[version]) for version in VERSIONS[fmi]}
    if output and len(files) == 1:
        files = {fmi: output}
    started = time.perf_counter()
    try:
        export(modelica, Recipe(model, {}), files)
    except NoSuchModel as error:
        near = get_close_matches(model, models, SHOWN, cutoff=0.5)
        nearest = f"the nearest: {', '.join(near)}; " if near else ""
        raise ConfigError(f"{modelica}: no model {model}; {nearest}there are {', '.join(models)}") from error
    seconds = time.perf_counter() - started
    return [Built(path.stem, file, seconds, False) for file in files.values()]
