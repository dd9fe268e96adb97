"""An experiment's TOML file, overridden and checked, as typed settings; mistakes are refused in one line."""

from __future__ import annotations

import copy
import json
import math
import re
import tomllib
from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import msgspec
from msgspec import inspect

from pipeline.errors import ConfigError
from pipeline.paths import EXPERIMENTS
from pipeline.settings import Experiment, Settings

RESERVED_STEMS = (
    "identification",
    "validation",
    "closed_loop_identification",
    "closed_loop_validation",
    "index",
    "result",
)


def slug(name: str) -> str:
    """File name of an estimate: lower case, runs of other characters become one "-"; "EKF(3) known" → "ekf-3-known"."""
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")


def load_experiment(name_or_path: str, overrides: Sequence[str] = (), without: Sequence[str] = ()) -> Experiment:
    """The experiment shipped as `name`, or in the TOML file at a path, with `--set key.path=value` overrides applied.

    without: top-level tables to leave out. Raises ConfigError.
    """
    path = find_experiment(name_or_path)
    table = {"name": path.stem, **read_toml(path)}
    for override in overrides:
        apply_override(table, override)
    for key in without:
        table.pop(key, None)
    experiment = convert(table, Experiment, path.name)
    _check(experiment, path.name)
    return experiment


def find_experiment(name_or_path: str) -> Path:
    """The TOML file of an experiment: a path, or the name of a shipped one."""
    path = Path(name_or_path)
    if path.suffix == ".toml":
        if not path.is_file():
            raise ConfigError(f"{path}: no such experiment file; shipped ones are {', '.join(shipped())}")
        return path
    if name_or_path not in shipped():
        raise ConfigError(
            f"no experiment `{name_or_path}`; shipped ones are {', '.join(shipped())}, or give a path to a .toml file"
        )
    return EXPERIMENTS / f"{name_or_path}.toml"


def shipped() -> list[str]:
    """Names of the experiments that come with the package."""
    return sorted(p.stem for p in EXPERIMENTS.glob("*.toml"))


def read_toml(path: Path) -> dict:
    """The table in a TOML file; ConfigError in one line where it cannot be read."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise ConfigError(f"{path}: no such file") from None
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise ConfigError(f"{path}: not a readable TOML file: {error}") from error


def apply_override(table: dict, override: str) -> None:
    """Apply `key.path=value` to a nested table in place; the value is TOML, or else a string.

    An element of a list is named by its `name` or its index: `ekf.case.0.substeps=8`, `wls.WLS(3).decimation=5`.
    """
    key, equals, text = override.partition("=")
    if not equals or not key.strip():
        raise ConfigError(f"--set {override}: want key=value, for example ekf.substeps=8")
    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        value = text.strip()
    *parents, last = key.strip().split(".")
    node: Any = table
    for part in parents:
        node = _child(node, part, override)
    if not isinstance(node, dict):
        raise ConfigError(f"--set {override}: `{'.'.join(parents)}` has no keys")
    node[last] = value


def _child(node: Any, part: str, override: str) -> Any:
    if isinstance(node, dict):
        return node.setdefault(part, {})
    if isinstance(node, list):
        named = [item for item in node if isinstance(item, dict) and item.get("name") == part]
        if len(named) > 1:
            raise ConfigError(f"--set {override}: {len(named)} are called `{part}`; name one by its index, from 0")
        if named:
            return named[0]
        if part.isdigit() and int(part) < len(node):
            return node[int(part)]
    raise ConfigError(f"--set {override}: nothing is called `{part}` there")


def convert(table: dict, kind: type[Settings], where: str):
    """A table as a settings object of type `kind`; ConfigError names the file, the key and the nearest known key."""
    _refuse_non_finite(table, where)
    try:
        return msgspec.convert(copy.deepcopy(table), kind)
    except msgspec.ValidationError as error:
        raise ConfigError(f"{where}: {_explain(str(error), kind, table)}") from None


def _refuse_non_finite(value: Any, where: str, key: str = "") -> None:
    """TOML knows nan and inf; no setting does."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for name, item in items:
        place = f"{key}[{name}]" if isinstance(value, list) else f"{key}.{name}" if key else str(name)
        _refuse_non_finite(item, where, place)
    if isinstance(value, float) and not math.isfinite(value):
        raise ConfigError(f"{where}: `{key}` is {value}; give a finite number")


def _explain(message: str, kind: type[Settings], table: dict) -> str:
    """msgspec's message, with what would be right there."""
    place = re.search(r"at `\$(.*?)`$", message)
    path = place[1].lstrip(".") if place else ""
    nodes = _nodes_at(kind, path)
    if unknown := re.search(r"unknown field `(.*?)`", message):
        keys = _keys(nodes)
        near = get_close_matches(unknown[1], keys, n=1, cutoff=0.6)
        near = near or get_close_matches(unknown[1], _keys(nodes, deep=True), n=1, cutoff=0.6)
        hint = f"did you mean `{near[0]}`?" if near else f"known are {', '.join(keys)}"
        return f"unknown key `{unknown[1]}`{f' in `{path}`' if path else ''}; {hint}"
    if missing := re.search(r"missing required field `(.*?)`", message):
        return (
            f"`{path}` is missing required field `{missing[1]}`" if path else f"missing required field `{missing[1]}`"
        )
    words = message.replace("`array`", "list").replace("`object`", "table").replace(" - at `$.", " at `")
    allowed = [
        json.dumps(v) for node in nodes if isinstance(node, inspect.LiteralType | inspect.EnumType) for v in node.values
    ]
    if allowed:
        return f"{words}; give one of {', '.join(allowed)}"
    given = _value_at(table, path)
    return words if given is None or len(str(given)) > 60 else f"{words}, which is {json.dumps(given, default=str)}"


def _value_at(table: Any, path: str) -> Any:
    """What stands at a path such as `ekf.case[0].method`; None where that cannot be followed."""
    for name, index in re.findall(r"([^.\[\]]+)(?![^\[]*\])|\[(\d+)\]", path):
        try:
            table = table[int(index)] if index else table[name]
        except (LookupError, TypeError):
            return None
    return table


def _nodes_at(kind: type[Settings], path: str) -> list[inspect.Type]:
    """The types that may stand at a path such as `ekf.case[0].method`; alternatives side by side."""
    nodes = _alternatives(inspect.type_info(kind))
    for name, _ in re.findall(r"([^.\[\]]+)(?![^\[]*\])|(\[[^\]]*\])", path):
        nodes = [part for node in nodes for child in _children(node, name) for part in _alternatives(child)]
    return nodes


def _alternatives(node: inspect.Type) -> list[inspect.Type]:
    return list(node.types) if isinstance(node, inspect.UnionType) else [node]


def _children(node: inspect.Type, name: str) -> list[inspect.Type]:
    """The types below a type: of the field `name`, or of the items of a list or table where it is ""."""
    if isinstance(node, inspect.StructType):
        return [field.type for field in node.fields if name in ("*", field.encode_name)]
    items = [getattr(node, key) for key in ("item_type", "value_type") if hasattr(node, key)]
    return [*items, *getattr(node, "item_types", ())] if name in ("", "*") else []


def _keys(nodes: Sequence[inspect.Type], deep: bool = False) -> list[str]:
    """The keys known at these types; deep: and everywhere below."""
    names: dict[str, None] = {}
    while nodes:
        names |= {f.encode_name: None for node in nodes if isinstance(node, inspect.StructType) for f in node.fields}
        children = [part for node in nodes for child in _children(node, "*") for part in _alternatives(child)]
        nodes = children if deep else []
    return list(names)


def _check(experiment: Experiment, where: str) -> None:
    """What types alone cannot say; ConfigError."""
    names = [w.name for w in experiment.wls]
    _check_names(experiment, where)
    if experiment.controller is None and (experiment.simulation or experiment.closed_loop):
        raise ConfigError(f"{where}: a simulated loop needs [controller]; add it")
    for table in experiment.reference.tables:
        rows = (*table.value, *table.relative_sigma_percent)
        columns = {len(table.columns), len(table.ours), len(table.value), len(table.relative_sigma_percent)}
        if len(columns) != 1 or any(len(row) != len(table.parameters) for row in rows):
            raise ConfigError(f"{where}: table `{table.title}`: give one entry per column and per parameter everywhere")
    if experiment.recommended not in names:
        raise ConfigError(f"{where}: recommended `{experiment.recommended}` is none of the WLS variants {names}")
    if experiment.simulation is None and experiment.data is None:
        raise ConfigError(f"{where}: no data: give [simulation] or [data]")
    data = experiment.data
    if data is not None and data.validation == data.identification:
        raise ConfigError(f"{where}: data.validation is the identification record itself; give another motion")
    for case in experiment.ekf.case if experiment.ekf else ():
        if bool(case.chi0) == (case.wls_factor is not None):
            raise ConfigError(f"{where}: {case.name}: give exactly one of chi0 and wls_factor")
        if [bool(case.P0_parameters), case.P0_relative is not None, case.P0_sigmas is not None].count(True) != 1:
            raise ConfigError(f"{where}: {case.name}: give exactly one of P0_parameters, P0_relative and P0_sigmas")
        if "paper" in case.tunings and not (case.R and case.Q):
            raise ConfigError(f"{where}: {case.name}: the tuning `paper` needs R and Q")
        if "known" in case.tunings and experiment.data is not None:
            raise ConfigError(f"{where}: {case.name}: the tuning `known` needs simulated data; use `derived`")


def estimate_names(experiment: Experiment) -> list[str]:
    """Names of every estimate the experiment will make, in their order."""
    filters = experiment.ekf.case if experiment.ekf else ()
    return [w.name for w in experiment.wls] + ["RLS"] + [case.called(t) for case in filters for t in case.tunings]


def _check_names(experiment: Experiment, where: str) -> None:
    """Every estimate has a name, and a file name, of its own; every name that is referred to exists."""
    names = estimate_names(experiment)
    stems = [slug(name) for name in names]
    for name, stem in zip(names, stems, strict=True):
        if not stem or stem in RESERVED_STEMS:
            raise ConfigError(
                f"{where}: an estimate cannot be called `{name}`; use letters and digits, no reserved word"
            )
        if stems.count(stem) > 1:
            raise ConfigError(f"{where}: two estimates are called `{name}`, or nearly; rename one")
    wanted = {"ekf.recommended": experiment.ekf.recommended if experiment.ekf and experiment.ekf.case else ""}
    wanted["closed_loop.estimate"] = experiment.closed_loop.estimate if experiment.closed_loop else ""
    for key, name in wanted.items():
        if name and name not in names:
            near = get_close_matches(name, names, n=1, cutoff=0.0)
            raise ConfigError(f"{where}: {key} = `{name}` is no estimate of this experiment; nearest: `{near[0]}`")
