"""What a design is asked for, checked before the search: the table [excitation], the friction, the file to write."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pipeline.errors import ConfigError, DataError
from pipeline.files import check_writable
from pipeline.plant.probing import InverseModel
from pipeline.settings import ExcitationRun, ExcitationSettings
from pipeline.workflow.session import Session

CHECK_RATE = 1000.0  # Hz, of the limits
FEWEST_SEGMENTS = 2
CRAWL = 1e-3  # of the limit of |qd|: as good as at rest, but with friction


def check_output(name: str | None) -> None:
    """Refuse a file that is not CSV or cannot be written before the search, not after it. Raises DataError."""
    if not name:
        return
    if Path(name).suffix.lower() not in ("", ".csv"):
        raise DataError(f"--output {name}: way-points are not written as `{Path(name).suffix}`; name a .csv file")
    try:
        check_writable(Path(name))
    except OSError as error:
        raise DataError(
            f"{name}: cannot be written there ({error.strerror or error}); give --output a file in a folder that "
            "exists and takes it"
        ) from None


def excitation_settings(session: Session) -> ExcitationSettings:
    """The experiment's [excitation], fit to be designed for. Raises ConfigError."""
    name, found = session.experiment.name, session.experiment.excitation
    if found is None:
        raise ConfigError(f"{name}: no [excitation] to design for; add it with the limits q, qd, qdd and tau")
    units = {j.position_unit for j in session.binding.joint}
    if len(units) > 1 or not units <= {"rad", "m"}:
        raise ConfigError(f"{name}: joints in {', '.join(sorted(units))}; way-points are all in rad or all in m")
    return found


def run_settings(name: str, settings: ExcitationSettings, validation: bool) -> ExcitationRun:
    """The segments of the run to design. Raises ConfigError where no design can come of them, or of the grid."""
    run = validation and settings.validation or ExcitationRun(settings.segments, settings.segment)
    where = "excitation.validation" if validation and settings.validation else "excitation"
    if run.segments < FEWEST_SEGMENTS:
        raise ConfigError(
            f"{name}: {where}.segments = {run.segments} leaves nothing to search, all joints move alike; give "
            f"{FEWEST_SEGMENTS} or more, 10 to 20 excite well"
        )
    if not 1.0 / run.segment <= settings.grid <= CHECK_RATE:
        raise ConfigError(
            f"{name}: excitation.grid = {settings.grid:g} Hz with segments of {run.segment:g} s; give from "
            f"{1.0 / run.segment:.3g} Hz (one look per segment) to {CHECK_RATE:g} Hz"
        )
    return run


def check_friction(session: Session, settings: ExcitationSettings, model: InverseModel) -> None:
    """Refuse limits of tau within which a joint cannot set out from q = 0 in either direction. Raises ConfigError."""
    crawl = CRAWL * np.array([settings.qd, np.negative(settings.qd)])
    tau = model.torque(np.zeros_like(crawl), crawl, np.zeros_like(crawl), session.binding.a_priori)
    needed = np.abs(tau).min(axis=0)
    stuck = [
        f"joint {i + 1} needs {needed[i]:.3g} of {limit:g}"
        for i, limit in enumerate(settings.tau)
        if needed[i] >= limit
    ]
    if stuck:
        raise ConfigError(
            f"{session.experiment.name}: excitation.tau does not overcome friction and weight at the start, "
            f"{', '.join(stuck)} {session.binding.joint[0].force_unit}; widen it"
        )
