"""The front end: a Modelica model as rumoca's differential-algebraic equations (DAE), checked to be complete.

rumoca hands its DAE over as plain data. Whatever section of it is neither translated nor empty is refused here, so that
no equation, event, modifier or initial equation can get lost on the way to the FMU.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from shutil import copy
from tempfile import TemporaryDirectory
from typing import Any

from pipeline.errors import ConfigError, ExportError
from pipeline.export.frontend_process import compile_model
from pipeline.export.losses import find_losses
from pipeline.export.plain_words import in_plain_words

SCHEMA = 43

TRANSLATED = {
    "variables", "value_types", "domains", "expressions", "functions", "continuous_equation_operations",
    "initialization_equation_operations", "initial_discrete_values", "discrete_real_equations",
    "discrete_value_owners", "relations", "conditions", "roots", "time_events", "event_actions", "clocks",
}  # fmt: skip
BOOKKEEPING = {"predefined_string_declaration", "flat_type_ids", "value_type_provenance", "clock_ownerships"}
REFUSED = {
    "initial_parameter_values": "a parameter computed by an initial equation (fixed=false)",
    "model_event_transactions": "an algorithm in a when-clause",
    "structured_roots": "an event in an array equation",
    "previous_values": "previous() of the synchronous language elements",
    "terminals": "terminal()",
    "delays": "delay()",
}
KINDS_OF_ENTRIES = {
    "continuous_equation_operations": {"residual", "structured"},
    "initialization_equation_operations": {"residual", "structured"},
    "initial_discrete_values": {"target", "value"},
    "discrete_real_equations": {"residual", "activation"},
    "discrete_value_owners": {"targets", "branches", "structure", "observed"},
    "relations": {"relation"},
    "conditions": {"node"},
    "roots": {"root"},
    "time_events": {"instant", "deadline"},
    "event_actions": {"trigger", "guard", "kind"},
    "clocks": {"kind"},
}
REFUSED_FLAT = {
    "initial_assert_equations": "an assert in the initial equations",
    "initial_algorithms": "an initial algorithm",
}

EXPERIMENT = re.compile(r"\bexperiment\s*\(([^)]*)\)")


@dataclass(frozen=True)
class Source:
    """A model as the front end understood it: its name, the DAE's storage, the flat model and the files read."""

    model: str
    dae: dict[str, Any]
    flat: dict[str, Any]
    files: dict[int, tuple[str, str]]

    def place(self, entry: Any) -> str:
        """`file:line` of an entry that carries a provenance, or "" where the front end gives none."""
        span = find_span(entry)
        if span is None or span["source"] not in self.files:
            return ""
        name, text = self.files[span["source"]]
        line = text.encode()[: span["start"]].count(b"\n") + 1
        return f"{name}:{line}"

    def text(self, entry: Any) -> str:
        """The Modelica text of an entry that carries a provenance, on one line, or ""."""
        span = find_span(entry)
        if span is None or span["source"] not in self.files:
            return ""
        text = self.files[span["source"]][1].encode()[span["start"] : span["end"]]
        return " ".join(text.decode(errors="replace").split())

    def refuse(self, what: str, entry: Any = None) -> ExportError:
        """The error for what cannot be exported, with the place where it stands."""
        place = self.place(entry)
        return ExportError(f"{self.model}: {what}{f' ({place})' if place else ''}")

    def experiment(self) -> dict[str, float]:
        """The numbers of the model's `experiment` annotation (StartTime, StopTime, Tolerance, Interval)."""
        leaf = self.model.rsplit(".", 1)[-1]
        body = re.compile(rf"\b(?:model|block|class)\s+{re.escape(leaf)}\b.*?\bend\s+{re.escape(leaf)}\s*;", re.DOTALL)
        for _, text in self.files.values():
            found = body.search(text)
            annotation = found and EXPERIMENT.search(found.group())
            if annotation:
                pairs = re.findall(r"(\w+)\s*=\s*([-+.\deE]+)", annotation.group(1))
                return {name: float(value) for name, value in pairs}
        return {}


def find_span(entry: Any) -> dict[str, int] | None:
    """The first source span in an entry of the DAE."""
    if isinstance(entry, dict):
        if "span" in entry and isinstance(entry["span"], dict):
            return entry["span"]
        if "source_span" in entry:
            return entry["source_span"]
        children: Any = entry.values()
    elif isinstance(entry, list):
        children = entry
    else:
        return None
    return next((span for child in children if (span := find_span(child)) is not None), None)


class NoSuchModel(ExportError):
    """A name that no class has."""


def load(path: Path, model: str) -> Source:
    """Compile `model` to its DAE; ExportError where a part of it cannot be exported, ConfigError where no file is.

    path: a folder with package.mo, a folder of .mo files, or a .mo file, of which nothing beside it is read.
    """
    with TemporaryDirectory(prefix="fmuid-") as alone:
        file = _main_file(path, Path(alone).resolve())
        compiled = compile_model(file, model)
        if "error" in compiled:
            raise _refusal(model, compiled["error"], file)
    return read_compiled(model, compiled["dae"], compiled["flat"], file)


def _refusal(model: str, error: str, file: Path) -> ExportError:
    """The error for what the front end says of a model in `file` or beside it."""
    if error.endswith("could not be compiled because resolve/parse failed"):
        return NoSuchModel(f"{model}: there is no such model")
    root = file.parent.parent if file.name == "package.mo" else file.parent
    texts = {
        str(p.relative_to(root)): p.read_text(encoding="utf-8", errors="replace")
        for p in sorted(file.parent.rglob("*.mo"))
    }
    error = in_plain_words(error.replace(f"{file.parent}/", ""), texts)
    return ExportError(f"{model}: the Modelica front end refuses it: {error}")


def _main_file(path: Path, alone: Path) -> Path:
    """The file to hand to the front end, which reads on its own what stands beside it."""
    if path.is_dir():
        package = path.resolve() / "package.mo"
        files = [package] if package.is_file() else sorted(path.resolve().glob("*.mo"))
        if not files:
            raise ConfigError(f"{path}: no package.mo and no other .mo file in it; give the folder of a package")
        return files[0]
    if path.suffix != ".mo" or not path.is_file():
        raise ConfigError(f"{path}: no such folder or .mo file; give the folder of a package, or a .mo file")
    return Path(copy(path, alone))


def read_compiled(model: str, dae: dict[str, Any], flat: dict[str, Any], file: Path) -> Source:
    """The Source of what the front end compiled from `file`, checked."""
    if dae["schema_version"] != SCHEMA:
        raise ExportError(
            f"{model}: the front end's DAE has schema {dae['schema_version']}, not {SCHEMA}: install rumoca==0.10.2"
        )
    folder = f"{file.parent.parent if file.name == 'package.mo' else file.parent}/"
    files = {key: (name.removeprefix(folder), text) for key, name, text in dae["source_map"]["files"]}
    source = Source(model, dae["storage"], flat, files)
    check_complete(source)
    return source


def check_complete(source: Source) -> None:
    """Refuse every non-empty section that nothing translates, and what the front end is known to lose."""
    for key, value in source.dae.items():
        if key in TRANSLATED | BOOKKEEPING or not value:
            continue
        raise source.refuse(f"{REFUSED.get(key, f'the section {key} of the DAE')} cannot be exported", value)
    for entry in source.dae["conditions"]:  # these shift the numbers of the nodes behind them
        if "quotient_owner" in entry.get("node", ()):
            raise source.refuse("div(), mod() and rem() cannot be exported: write them with floor()", entry)
    for key, kinds in KINDS_OF_ENTRIES.items():
        for entry in source.dae[key]:
            if not set(entry) - {"provenance"} <= kinds:
                raise source.refuse(f"an entry of {key} with {', '.join(sorted(entry))} cannot be exported", entry)
    for key, what in REFUSED_FLAT.items():
        if source.flat[key]:
            raise source.refuse(f"{what} cannot be exported: remove it", source.flat[key])
    for algorithm in source.flat["algorithms"]:
        _check_whens(source, [body for statement in algorithm["statements"] if (body := statement.get("When"))])
    for what, name, line in find_losses(source.model, source.files):
        raise ExportError(f"{source.model}: {what} ({name}:{line})")


def _check_whens(source: Source, whens: list[dict]) -> None:
    """Of several when-statements of an algorithm the last one holds; the DAE does not tell them from elsewhen."""
    seen: set[str] = set()
    for when in whens:
        targets = set(find_targets(when))
        if targets & seen:
            what = f"{', '.join(targets & seen)} is assigned in two when-statements of an algorithm: use elsewhen"
            raise source.refuse(what, when)
        seen |= targets


def find_targets(node: Any) -> Iterator[str]:
    """Names of the variables that are assigned in a part of the flat model."""
    if isinstance(node, dict):
        if "Assignment" in node:
            yield ".".join(part["ident"] for part in node["Assignment"]["comp"]["parts"])
        node = list(node.values())
    if isinstance(node, list):
        for child in node:
            yield from find_targets(child)
