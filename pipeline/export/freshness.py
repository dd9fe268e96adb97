"""Whether a built FMU is up to date, found cheaply: nothing here imports what builds."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict
from pathlib import Path

from pipeline import __version__
from pipeline.export.archive import read_note
from pipeline.export.catalogue import Recipe
from pipeline.export.compiler import platform

HERE = Path(__file__).resolve().parent
WRAPPER = HERE / "wrapper"
EXPORTER = [*sorted(HERE.glob("*.py")), HERE.parent / "units.py", *sorted(WRAPPER.glob("*.[ch]"))]


def fingerprint(modelica: Path, recipe: Recipe) -> str:
    """A hash of all an FMU is made from but the compiler: sources of model and exporter, recipe, versions."""
    from importlib.metadata import version

    h = hashlib.sha256()
    for root, files in ((modelica, sorted(modelica.rglob("*.mo"))), (HERE.parent, EXPORTER)):
        for file in files:
            h.update(file.relative_to(root).as_posix().encode())
            h.update(file.read_bytes())
    tools = {tool: version(tool) for tool in ("rumoca", "casadi", "fmpy")}
    h.update(json.dumps([asdict(recipe), tools, __version__, platform()], sort_keys=True).encode())
    return h.hexdigest()


def state(path: Path, inputs: str, compiler: str | None) -> str:
    """What an FMU is: "missing"; "foreign", where another hand put or changed it; "stale"; or "fresh".

    Fresh is what was made from these inputs by this compiler; a machine without one (None) takes any compiler's.
    """
    if not path.is_file():
        return "missing"
    note = read_note(path)
    if not note:
        return "foreign"
    same_compiler = compiler is None or note.get("compiler") == compiler
    return "fresh" if same_compiler and note.get("inputs") == inputs else "stale"
