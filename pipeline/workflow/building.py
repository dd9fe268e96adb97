"""The FMUs of an experiment; those of ours that are missing or out of date are built before it starts."""

from __future__ import annotations

from pathlib import Path

from pipeline.errors import ConfigError
from pipeline.export.catalogue import recipes
from pipeline.export.compiler import describe_compiler
from pipeline.export.freshness import fingerprint, state
from pipeline.paths import FMUS, MODELICA, built_fmu
from pipeline.plant.binding import check_binding, gains_of_bindings, variants_of_bindings
from pipeline.plant.fmu import Fmu, open_fmu
from pipeline.workflow.acquire import check_file, data_files
from pipeline.workflow.session import Session


def fmu_files(session: Session) -> list[Path]:
    """The FMUs that the experiment runs on: the plant's, and the controller's where there is one."""
    return [path for path in (session.binding.path, session.controller_fmu) if path is not None]


def fmu_states(session: Session) -> dict[str, str]:
    """What those of the experiment's FMUs are that we can build: {name: "missing", "foreign", "stale" or "fresh"}."""
    offered = recipes(MODELICA, gains_of_bindings(), variants_of_bindings())
    files = {built_fmu(name, session.experiment.fmi): name for name in offered}
    compiler = describe_compiler()
    ours = {files[path]: path for path in fmu_files(session) if path in files}
    return {n: state(path, fingerprint(MODELICA, offered[n]), compiler) for n, path in ours.items()}


def prepare(session: Session, runs: tuple[bool, ...] = (False, True)) -> None:
    """Before the runs (True: validation): their data files are there, the FMUs up to date and what the settings say.

    Raises DataError, ExportError, ConfigError, FmuError.
    """
    for validation in runs:
        check_file(session, data_files(session)[validation])
    build_fmus(session)
    check_fmus(session)


def check_fmus(session: Session) -> None:
    """Hold the binding and the controller's ports against the FMUs' descriptions, before a step is simulated.

    Raises ConfigError for a wrong name, causality or unit, FmuError for a file that is no FMU.
    """
    with open_fmu(session.binding.path) as file:
        check_binding(session.binding, file)
    controller = session.experiment.controller
    if controller is None:
        return
    with open_fmu(session.controller_fmu) as file:
        inputs = ("reference", "reference_velocity", "position", "extra")
        for key in (*inputs, "output"):
            for name in getattr(controller, key):
                found, wanted = _variable(file, name, key).causality, "input" if key in inputs else "output"
                if found != wanted:
                    raise ConfigError(
                        f"controller.{key}: `{name}` of {file.path.name} is of causality {found}; name an {wanted}"
                    )
        for key in ("position_start", "velocity_start", "start"):
            for name in getattr(controller, key):
                _variable(file, name, key)


def _variable(file: Fmu, name: str, key: str):
    try:
        return file.variable(name)
    except ConfigError as error:
        raise ConfigError(f"controller.{key}: {error}") from None


def build_fmus(session: Session) -> None:
    """Build what is missing or stale. One that another hand put there is used as it is, and this is said.

    Raises ExportError.
    """
    states = fmu_states(session)
    for name in (name for name, found in states.items() if found == "foreign"):
        session.narrate(f"  {name}.fmu is not as it was built, and used as it is; `fmuid build` makes it anew")
    todo = [name for name, found in states.items() if found in ("missing", "stale")]
    if todo:
        from pipeline.export.build import build

        session.narrate(f"  building {', '.join(todo)}, {' and '.join(sorted({states[n] for n in todo}))} …")
        with session.stage("FMUs"):
            options = {"fmi": session.experiment.fmi, "variants": variants_of_bindings()}
            build(todo, FMUS, gains_of_bindings(), report=lambda t: session.narrate(f"  {t}"), **options)
