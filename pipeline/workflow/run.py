"""A whole experiment: data, WLS, EKF, validation, comparison, record, page. A stage that fails still makes a page."""

from __future__ import annotations

from datetime import UTC, datetime
from itertools import count
from pathlib import Path
from traceback import format_exception

import pandas as pd

from pipeline.assess.comparison import findings
from pipeline.assess.consistency import consistency
from pipeline.assess.verdict import Item, verdict
from pipeline.config import slug
from pipeline.errors import FmuError, FmuidError
from pipeline.paths import REPORTS
from pipeline.plant.probing import InverseModel
from pipeline.report.page import write_page
from pipeline.report.record import SCHEMA, check_target, write_run
from pipeline.workflow import record as entries
from pipeline.workflow.acquire import acquire
from pipeline.workflow.batch import open_inverse_model, reference_excitation, run_batch
from pipeline.workflow.building import prepare
from pipeline.workflow.filtering import run_filters
from pipeline.workflow.judging import judge
from pipeline.workflow.loop import LoopStage, follow_loop
from pipeline.workflow.provenance import plant_entry, provenance
from pipeline.workflow.session import Session
from pipeline.workflow.validating import validate


def run(session: Session, output: str | None = None) -> tuple[Path, dict]:
    """Run the experiment and write its folder: result.json, signals, index.html. Returns the folder and the record.

    A stage that fails is written into the record's `errors`, and what was found before it stays; only an experiment
    whose data cannot be had, or whose filters cannot follow its loop, raises: then there is nothing to report.
    """
    created = datetime.now(UTC)
    folder = Path(output) if output else REPORTS / f"{slug(session.experiment.name)}-{created:%Y%m%d-%H%M%S}"
    check_target(folder)
    prepare(session)
    with session.stage("data"):
        frame, validation_frame = acquire(session), acquire(session, validation=True)
    record, signals = identify(session, frame, validation_frame)
    folder = folder if output else _free(folder)
    record = {"schema": SCHEMA, "run_id": folder.name, "created": created.isoformat(timespec="seconds"), **record}
    with session.stage("page"):
        write_run(folder, record, signals)
        write_page(folder)
    return folder, record


def _free(folder: Path) -> Path:
    """The folder, or the first of `-2`, `-3` … that another run of the same second has not taken."""
    names = (folder.with_name(f"{folder.name}-{i}") if i > 1 else folder for i in count(1))
    return next(name for name in names if not name.exists())


def identify(
    session: Session, frame: pd.DataFrame | None = None, validation_frame: pd.DataFrame | None = None
) -> tuple[dict, dict[str, pd.DataFrame]]:
    """Everything but the writing: the record and its signals."""
    if frame is None:
        prepare(session)
        with session.stage("data"):
            frame, validation_frame = acquire(session), acquire(session, validation=True)
    with session.stage("loop"):
        session, loop = follow_loop(session, frame)
    record = {
        "title": session.experiment.title,
        "experiment": entries.experiment_entry(session),
        "plant": plant_entry(session),
        "reference": entries.reference_entry(session),
        "loop": entries.loop_entry(session, loop),
        "estimates": {},
        "errors": [],
    }
    signals: dict[str, pd.DataFrame] = {"identification": frame}
    items: list[Item] = []
    try:
        with open_inverse_model(session, frame) as model:
            items = _stages(session, loop, model, frame, validation_frame, record, signals)
    except Exception as error:  # whatever stops a stage, what was found before it must reach the page
        record["errors"].append(_error_entry(_running(session), error))
        items.append(Item(f"stage {_running(session)}", None, None, "fail"))
    record["verdict"] = verdict(items)
    record["timing"] = {
        "stages": dict(session.stages),
        "estimates": {name: e["elapsed_s"] for name, e in record["estimates"].items()},
    }
    record["provenance"] = provenance(session)
    record["findings"] = findings(record)
    return record, signals


def _error_entry(stage: str, error: Exception) -> dict:
    """A stage's failure; one that is no FmuidError is a defect of ours, and takes its traceback along."""
    if isinstance(error, FmuidError):
        return {"stage": stage, "message": str(error), "exit_code": error.exit_code}
    message = f"internal error, please report it: {type(error).__name__}: {error}"
    return {"stage": stage, "message": message, "exit_code": 4, "traceback": "".join(format_exception(error))}


STAGES = ("data", "loop", "WLS and RLS", "EKF", "validation")


def _running(session: Session) -> str:
    """The stage that did not end: the first one without a time."""
    return next((name for name in STAGES if name not in session.stages), STAGES[-1])


def _stages(
    session: Session,
    loop: LoopStage,
    model: InverseModel,
    frame: pd.DataFrame,
    validation_frame: pd.DataFrame,
    record: dict,
    signals: dict[str, pd.DataFrame],
) -> list[Item]:
    """Run the stages on the data, filling record and signals as they end; returns the verdict's items."""
    with session.stage("WLS and RLS"):
        batch = run_batch(session, frame, model)
    signals["identification"] = entries.frame_signals(session, frame, batch.recommended.filtered)
    found, tables = entries.batch_entries(session, batch)
    record["estimates"] |= found
    signals |= tables
    record["excitation"] = entries.excitation_entry(batch.recommended.excitation)
    if not session.measured:
        reference = reference_excitation(session, model)
        record["excitation"]["reference"] = None if reference is None else entries.excitation_entry(reference)
    filters, tests = {}, {}
    with session.stage("EKF"):
        if session.experiment.ekf is not None:
            filters = run_filters(session, frame, batch.recommended)
            tests = {name: consistency(f.run) for name, f in filters.items() if f.run.failed_at is None}
            filters = {name: entries.with_sigma_reason(f, tests.get(name)) for name, f in filters.items()}
    found, tables = entries.filter_entries(session, filters, tests)
    record["estimates"] |= found
    signals |= tables
    with session.stage("validation"):
        estimates = {name: b.estimate for name, b in batch.variants.items()}
        estimates |= {name: f.estimate for name, f in filters.items()}
        validation = validate(session, model, batch, estimates, frame, validation_frame)
    record["validation"] = entries.validation_entry(validation)
    if validation.failure:
        record["errors"].append(
            {"stage": "closed loop", "message": validation.failure, "exit_code": FmuError.exit_code}
        )
    signals["validation"] = entries.prediction_signals(validation)
    signals |= {f"closed_loop_{name}": loop for name, loop in validation.loops.items()}
    return judge(session, loop, batch, filters, tests, validation)
