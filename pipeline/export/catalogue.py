"""Which FMUs a Modelica package offers: every class listed in its FMUs/package.order, named in snake_case."""

from __future__ import annotations

import re
from pathlib import Path

from pipeline.errors import ExportError


def identifier(name: str) -> str:
    """The C name of a class: its last part in snake_case (`ScaraController` → `scara_controller`)."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name.rsplit(".", 1)[-1]).lower()


def exported(modelica: Path) -> dict[str, str]:
    """FMU name → class, for every class of FMUs/package.order."""
    order = modelica / "FMUs" / "package.order"
    if not order.is_file():
        raise ExportError(f"{modelica}: no FMUs/package.order, which lists the classes to export")
    classes = order.read_text(encoding="utf-8").split()
    return {identifier(leaf): f"{modelica.name}.FMUs.{leaf}" for leaf in classes}
