"""Which FMUs a Modelica package offers: every class listed in its FMUs/package.order, named in snake_case; variants of
these, whose parameters are continuous inputs; and, when they are asked for by name, the classes of its Benchmarks.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from pipeline.errors import ExportError


def identifier(name: str) -> str:
    """The C name of a class: its last part in snake_case (`ScaraController` → `scara_controller`)."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name.rsplit(".", 1)[-1]).lower()


def exported(modelica: Path) -> dict[str, str]:
    """FMU name → class, for every class of FMUs/package.order."""
    if not (modelica / "FMUs" / "package.order").is_file():
        raise ExportError(f"{modelica}: no FMUs/package.order, which lists the classes to export")
    return listed(modelica, "FMUs")


def benchmarks(modelica: Path) -> dict[str, str]:
    """FMU name → class, for every class of Benchmarks/package.order: these are built by name only."""
    return listed(modelica, "Benchmarks") if (modelica / "Benchmarks" / "package.order").is_file() else {}


def listed(modelica: Path, package: str) -> dict[str, str]:
    """FMU name → class, for every class of a package's package.order."""
    classes = (modelica / package / "package.order").read_text(encoding="utf-8").split()
    return {identifier(leaf): f"{modelica.name}.{package}.{leaf}" for leaf in classes}


@dataclass(frozen=True)
class Recipe:
    """What an FMU is made of: its class, values of parameters, names of the parameters that become inputs."""

    model: str
    starts: Mapping[str, float]
    inputs: tuple[str, ...] = ()


def recipes(
    modelica: Path,
    start_values: Mapping[str, Mapping[str, float]] | None = None,
    variants: Mapping[str, tuple[str, tuple[str, ...]]] | None = None,
) -> dict[str, Recipe]:
    """FMU name → recipe, for every class of FMUs/package.order, every variant {name: (FMU, parameters)} of one and
    every benchmark.

    start_values: {FMU name: {parameter: value}}; those of an FMU hold for its variants too. Raises ExportError.
    """
    classes, start_values = exported(modelica), start_values or {}
    found = {name: Recipe(model, dict(start_values.get(name, {}))) for name, model in classes.items()}
    for name, (base, inputs) in (variants or {}).items():
        if base not in classes or name in classes:
            raise ExportError(f"{name}: no variant of {base} can have this name; there are {', '.join(classes)}")
        starts = {**start_values.get(base, {}), **start_values.get(name, {})}
        found[name] = Recipe(classes[base], starts, tuple(inputs))
    return found | {name: Recipe(model, {}) for name, model in benchmarks(modelica).items()}
