"""The run record, assembled from what the stages found. Schema: reports/README.md."""

from __future__ import annotations

from dataclasses import asdict, replace

import msgspec
import numpy as np
import pandas as pd

from pipeline.assess.consistency import Consistency
from pipeline.assess.residuals import residual_tests
from pipeline.assess.wording import figures
from pipeline.config import slug
from pipeline.identify.discretisation import LIMIT
from pipeline.identify.regression import Excitation
from pipeline.records import OK
from pipeline.settings import PublishedTable
from pipeline.signals.frames import joint_columns
from pipeline.workflow.batch import Batch, BatchStage
from pipeline.workflow.estimates import (
    essential_entry,
    estimate_entry,
    filter_signals,
    history_signals,
    regression_signals,
)
from pipeline.workflow.filtering import Filtered
from pipeline.workflow.loop import LoopStage
from pipeline.workflow.session import Session
from pipeline.workflow.validating import ValidationStage


def experiment_entry(session: Session) -> dict:
    """What was run: the record's `experiment`."""
    e, joints = session.experiment, session.binding.joint
    return {
        "name": e.name,
        "title": e.title,
        "kind": "measured" if session.measured else "simulated",
        "seed": e.seed,
        "joints": session.binding.n,
        "joint_names": [j.name for j in joints],
        "position_unit": joints[0].position_unit,
        "force_unit": joints[0].force_unit,
        "configuration": msgspec.to_builtins(e),
    }


def excitation_entry(found: Excitation) -> dict:
    """Condition numbers and singular values of a regression."""
    return {
        "condition_number_W": found.condition_number_W,
        "condition_number_Phi": found.condition_number_Phi,
        "left_out_of_Phi": list(found.left_out_of_Phi),
        "singular_values": found.singular_values,
    }


def loop_entry(session: Session, loop: LoopStage) -> dict:
    """The closed loop at each configuration, f_dyn, and where each variant's filters come from."""
    n, entry = session.binding.n, {"f_dyn": loop.f_dyn, "reason": loop.reason, "filters": loop.filters}
    if not loop.responses:
        return entry
    configurations = [
        {"q": p.q, "u": p.u, "bandwidth": r.bandwidth, "margins": [asdict(m) for m in r.margins]}
        for p, r in zip(loop.plants, loop.responses, strict=True)
    ]
    f = loop.responses[0].f
    drawn = f > 0.01 * loop.f_dyn
    gain = np.array([r.gain[drawn] for r in loop.responses])
    curves = {
        "f": f[drawn],
        "lowest": [gain[:, :, i].min(axis=0) for i in range(n)],
        "highest": [gain[:, :, i].max(axis=0) for i in range(n)],
    }
    return {**entry, "configurations": configurations, "gain": curves}


def reference_entry(session: Session) -> dict:
    """The published results, their tables by column and parameter."""
    published = session.experiment.reference
    reference = msgspec.to_builtins(published)
    reference["tables"] = [_published_table(table) for table in published.tables]
    conditions = {key: v for key, v in reference.items() if key.startswith("condition_number") and v is not None}
    return {**reference, "metrics": conditions}


def _published_table(table: PublishedTable) -> dict:
    columns = {}
    for j, column in enumerate(table.columns):
        values = zip(table.parameters, table.value[j], table.relative_sigma_percent[j], strict=True)
        parameters = {name: {"value": v, "relative_sigma_percent": s} for name, v, s in values}
        columns[column] = {"ours": table.ours[j], "parameters": parameters}
    return {"title": table.title, "estimates": columns}


def batch_entries(session: Session, batch: BatchStage) -> tuple[dict, dict[str, pd.DataFrame]]:
    """The entries and signals of every WLS variant and of RLS."""
    entries, signals = {}, {}
    for name, found in batch.variants.items():
        entries[name] = _batch_entry(session, found)
        if found is batch.recommended:
            entries[name]["essential"] = essential_entry(batch.essential)
        if found.regression is not None:
            signals[slug(name)] = regression_signals(found.regression, found.estimate)
        else:
            entries[name]["signals"] = None
    entries["RLS"] = estimate_entry(session, batch.rls)
    signals["rls"] = history_signals(batch.rls)
    return entries, signals


def _batch_entry(session: Session, found: Batch) -> dict:
    settings = next(w for w in session.experiment.wls if w.name == found.estimate.name)
    described = {
        "position filter": _filter_text(settings.position),
        "parallel filter": _filter_text(settings.parallel),
        "decimation": f"1 of {settings.decimation}",
        "border": list(settings.border),
        "half-sample alignment": settings.half_sample,
    }
    more: dict = {"settings": described}
    if found.regression is not None:
        unit = session.binding.joint[0].force_unit
        truth = _truth_of(session, found.estimate.names)
        tests = residual_tests(found.regression, found.estimate.theta, unit, truth)
        more |= {
            "condition_number_Phi": found.excitation.condition_number_Phi,
            "tests": {"residual": [t.as_record() for t in tests]},
        }
    return estimate_entry(session, found.estimate, **more)


def _filter_text(settings) -> str:
    if settings.kind == "none":
        return "none"
    if settings.kind == "decimate":
        return "8th-order Chebyshev I, forward and backward"
    direction = "forward and backward" if settings.kind == "zero-phase" else "forward only"
    return f"Butterworth, order {settings.order}, {settings.cutoff:g} Hz, {direction}"


def _truth_of(session: Session, names: tuple[str, ...]) -> np.ndarray | None:
    return None if session.truth is None else session.binding.select(session.truth, names)


def filter_entries(
    session: Session, filters: dict[str, Filtered], tests: dict[str, Consistency]
) -> tuple[dict, dict[str, pd.DataFrame]]:
    """The entries and signals of every filter run; sigma is withheld where its consistency test fails."""
    entries, signals = {}, {}
    for name, found in filters.items():
        test = tests.get(name)
        more = {
            "tuning": found.tuning,
            "settings": found.settings,
            "jacobian": asdict(found.jacobian),
            "fmu_calls": found.calls,
        }
        if test is not None:
            transition = {"worst_shift_sigma": found.shift, "limit": LIMIT}
            more["tests"] = {**test.as_record(), "transition": transition}
        entries[name] = estimate_entry(session, found.estimate, found.chi0, **more)
        signals[slug(name)] = filter_signals(found, session.binding.n)
    return entries, signals


def with_sigma_reason(found: Filtered, test: Consistency | None) -> Filtered:
    """The filter run with the reason why its sigma is withheld, where the test gives one."""
    if found.estimate.status != OK:
        return found
    reasons = [found.jacobian.doubt] if found.jacobian.doubt else []
    if found.shift is not None and found.shift > LIMIT:
        coarse = found.settings["transition"]
        size = f"{figures(found.shift, 2)} sigma (limit {LIMIT:g})"
        reasons.append(f"the errors of the transition by {coarse} may add up to {size}: refine it")
    if test is not None and not test.ok:
        reasons.append(test.sentence)
    return replace(found, estimate=replace(found.estimate, sigma_reason="; ".join(reasons)))


def frame_signals(session: Session, frame: pd.DataFrame, filtered: pd.DataFrame) -> pd.DataFrame:
    """The measured frame beside the filtered position, velocity and acceleration."""
    columns = [c for kind in ("q", "qd", "qdd") for c in joint_columns(kind, session.binding.n)]
    return frame.join(filtered[columns].add_suffix(" [filtered]"))


def prediction_signals(validation: ValidationStage) -> pd.DataFrame:
    """The validation run's forces, measured (filtered) and predicted by each estimate."""
    first = next(iter(validation.predictions.values()))
    columns = {f"tau_{i + 1}": first.measured[:, i] for i in range(first.measured.shape[1])}
    for name, prediction in validation.predictions.items():
        columns |= {f"tau_{i + 1} [{name}]": y for i, y in enumerate(prediction.predicted.T)}
    return pd.DataFrame(columns, index=pd.Index(first.time, name="time"))


def validation_entry(validation: ValidationStage) -> dict:
    """Every relative error by run and signal, in %."""
    return {
        **validation.errors,
        "own_filters": validation.own,
        "noise_floor": validation.noise_floor,
        "closed_loop": validation.closed_loop,
    }
