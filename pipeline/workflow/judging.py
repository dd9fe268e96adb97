"""The verdict's items: the experiment's limits held against what was found."""

from __future__ import annotations

import numpy as np

from pipeline.assess.consistency import Consistency
from pipeline.assess.verdict import Item, at_least, at_most, holds, within
from pipeline.records import OK, Estimate
from pipeline.workflow.batch import BatchStage
from pipeline.workflow.filtering import Filtered
from pipeline.workflow.loop import LoopStage
from pipeline.workflow.session import Session
from pipeline.workflow.validating import ValidationStage

HOPELESS = 100.0
"""A condition number this many times its limit is no result that could be used with care."""


PHASE_MARGIN = 30.0
"""Degrees below which a loop rings, so that its record holds little else."""


def judge(
    session: Session,
    loop: LoopStage,
    batch: BatchStage,
    filters: dict[str, Filtered],
    tests: dict[str, Consistency],
    validation: ValidationStage | None,
) -> list[Item]:
    """Every check the experiment asks for, in the order of the page."""
    limits, name = session.experiment.limits, session.experiment.recommended
    best = batch.recommended
    items = [holds(f"{name} solved", best.estimate.status == OK)]
    items.append(holds(f"{name} mass matrix positive all along the motion", batch.mass_is_positive))
    phases = [abs(m.phase) for r in loop.responses for m in r.margins if m.phase is not None]
    if phases:
        items.append(at_least("closed loop, smallest phase margin in degrees", min(phases), PHASE_MARGIN, "warn"))
    items.append(holds(f"{name} residual white enough for sigma", not best.estimate.sigma_reason, "warn"))
    excitation = {"W": best.excitation.condition_number_W, "Phi": best.excitation.condition_number_Phi}
    for which, value in excitation.items():
        limit = getattr(limits, f"condition_number_{which}")
        if limit is not None:
            beyond = "fail" if value is None or value > HOPELESS * limit else "warn"
            items.append(at_most(f"{name} condition number of {which}", value, limit, beyond))
    if limits.relative_sigma_percent is not None and not best.estimate.sigma_reason:  # a withheld sigma proves nothing
        worst = float(np.max(best.estimate.relative_sigma_percent))
        items.append(at_most(f"{name} largest relative sigma in %", worst, limits.relative_sigma_percent, "warn"))
    failed = [n for n, f in filters.items() if f.estimate.status != OK and n != _recommended(session)]
    if session.measured:
        items.append(holds("every filter succeeded", not failed, "warn"))
    items += _against_truth(session, {name: best.estimate, **_named(session, filters)})
    items += _consistent(session, filters, tests)
    return items + ([] if validation is None else _validated(session, validation))


def _named(session: Session, filters: dict[str, Filtered]) -> dict[str, Estimate]:
    name = _recommended(session)
    return {name: filters[name].estimate} if name in filters else {}


def _recommended(session: Session) -> str:
    return session.experiment.ekf.recommended if session.experiment.ekf else ""


def _against_truth(session: Session, estimates: dict[str, Estimate]) -> list[Item]:
    limit, truth = session.experiment.limits.truth_sigmas, session.truth
    if limit is None or truth is None:
        return []
    items = []
    for name, e in estimates.items():
        if e.sigma_reason:  # withheld, and warned of where it was withheld
            continue
        true = session.binding.select(truth, e.names)
        value = float(np.max(np.abs(e.theta - true) / e.sigma)) if e.covariance is not None else None
        items.append(at_most(f"{name} largest distance from the truth in sigma", value, limit))
    return items


def _consistent(session: Session, filters: dict[str, Filtered], tests: dict[str, Consistency]) -> list[Item]:
    items = []
    for name, estimate in _named(session, filters).items():
        items.append(holds(f"{name} succeeded", estimate.status == OK))
        if name in tests:
            test = tests[name]
            items.append(within(f"{name} mean NIS", test.NIS_mean, test.low, test.high))
            items.append(holds(f"{name} innovations white", all(w.ok for w in test.whiteness), "warn"))
            items.append(holds(f"{name} sigma may be trusted", not estimate.sigma_reason, "warn"))
    return items


def _validated(session: Session, validation: ValidationStage) -> list[Item]:
    limits, name = session.experiment.limits, session.experiment.recommended
    items = []
    error = validation.errors["validation"][name]["total"]
    items.append(at_most(f"{name} force error on the validation run in %", error, limits.force_error_percent))
    if validation.failure:
        items.append(holds("closed loop simulated", False))
    if validation.noise_floor and limits.above_noise_floor_percent is not None:
        above = 100.0 * (error / validation.noise_floor["total"] - 1.0)
        items.append(at_most(f"{name} force error above the noise floor in %", above, limits.above_noise_floor_percent))
    for signal in ("position", "force"):
        limit = getattr(limits, f"closed_loop_{signal}_percent")
        if limit is not None and validation.closed_loop:
            worst = max(run[signal] for run in validation.closed_loop.values())
            items.append(at_most(f"closed loop, largest {signal} error in %", worst, limit))
    return items
