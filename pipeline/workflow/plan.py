"""What a command would do: the whole configuration and the stages, with what they read and write. Runs nothing."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec
import tomli_w

from pipeline.config import estimate_names, slug
from pipeline.paths import MODELICA, REPORTS, built_fmu
from pipeline.workflow.acquire import data_files
from pipeline.workflow.building import fmu_files, fmu_states
from pipeline.workflow.session import Session

BUILT = {"missing": "to be built", "stale": "out of date, to be built", "fresh": "up to date", "foreign": "as it is"}


def plan(session: Session, command: str, output: str | None = None) -> dict:
    """{"command", "configuration", "stages": [{"name", "inputs", "outputs"}]} of a command with its `--output`."""
    return {
        "command": f"fmuid {command} {session.experiment.name}",
        "configuration": configuration(session),
        "stages": [{"name": name, "inputs": i, "outputs": o} for name, i, o in _stages(session, command, output)],
    }


def plan_text(found: dict) -> str:
    """The plan as a TOML file that an experiment can be run from: the stages are its comments."""
    lines = [f"# {found['command']} would run these stages; nothing has run."]
    for stage in found["stages"]:
        lines.append(f"# {stage['name']}")
        lines += [f"#   reads  {item}" for item in stage["inputs"]]
        lines += [f"#   writes {item}" for item in stage["outputs"]]
    lines.append("# The configuration with every default and override; saved as a .toml file, it runs the same again.")
    return "\n".join(lines) + "\n\n" + tomli_w.dumps(found["configuration"]).rstrip()


def configuration(session: Session) -> dict[str, Any]:
    """The experiment's settings as a table that says the same from any folder: its paths are absolute."""
    e, table = session.experiment, _present(msgspec.to_builtins(session.experiment))
    if e.plant.endswith(".toml"):
        plant = Path(e.plant)
        table["plant"] = str((plant if plant.is_file() else session.folder / plant).absolute())
    if e.controller is not None and e.controller.fmu.endswith(".fmu"):
        table["controller"]["fmu"] = str(session.controller_fmu.absolute())
    if e.data is not None:
        table["data"]["folder"] = str((session.data or session.folder / e.data.folder).absolute())
    if e.simulation is not None:
        for key in ("identification", "validation"):
            table["simulation"][key] = str((session.folder / table["simulation"][key]).absolute())
    return table


def _present(value: Any) -> Any:
    """The value without what is None, which TOML does not know: each such key is absent by default."""
    if isinstance(value, dict):
        return {key: _present(item) for key, item in value.items() if item is not None}
    return [_present(item) for item in value] if isinstance(value, list | tuple) else value


def _stages(session: Session, command: str, output: str | None) -> list[tuple[str, list[str], list[str]]]:
    """(name, inputs, outputs) of each stage of a command, in their order."""
    fmus, data = [str(path) for path in fmu_files(session)], [_there(path) for path in data_files(session)]
    build = ("FMUs", [str(MODELICA)], _fmus(session))
    measured = [] if session.measured else fmus
    if command == "excite":
        return [build, ("search and checks", fmus, [output or "stdout"])]
    if command == "simulate":
        return [build, ("data", [*data, *measured], [output or "stdout"])]
    names = estimate_names(session.experiment)
    batch = len(session.experiment.wls) + 1
    stages = [
        build,
        ("data", [*data, *measured], ["the measured frames of both runs"]),
        ("loop", fmus, ["bandwidth and margins"]),
        ("WLS and RLS", fmus[:1], [", ".join(names[:batch])]),
        ("EKF", fmus[:1], [", ".join(names[batch:]) or "nothing"]),
        ("validation", fmus, ["the verdict"]),
    ]
    if command == "run":
        folder = output or str(REPORTS / f"{slug(session.experiment.name)}-YYYYMMDD-HHMMSS")
        stages.append(("page", ["all of the above"], [f"{folder}/{name}" for name in ("result.json", "index.html")]))
    return stages


def _fmus(session: Session) -> list[str]:
    """The FMUs with what becomes of each before the run."""
    ours = {built_fmu(name, session.experiment.fmi): found for name, found in fmu_states(session).items()}
    return [
        f"{path} ({BUILT[ours[path]]})" if path in ours else _there(path, "as it is") for path in fmu_files(session)
    ]


def _there(path: Path, word: str = "there") -> str:
    return f"{path} ({word if path.is_file() else 'MISSING'})"
