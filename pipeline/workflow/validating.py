"""The validation stage: force prediction on both runs, and the identified model simulated against the measurement."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from pipeline.assess.validation import Prediction, noise_floor, predict, relative_error
from pipeline.errors import ConfigError, FmuError
from pipeline.identify.regression import regression
from pipeline.plant.probing import InverseModel
from pipeline.records import OK, Estimate, Regression
from pipeline.signals.frames import filter_frame, joint_columns
from pipeline.workflow.acquire import run_loop
from pipeline.workflow.batch import BatchStage
from pipeline.workflow.session import Session


@dataclass(frozen=True)
class ValidationStage:
    """Errors in % by run and estimate on the recommended filters, and by run for each WLS variant on its own.

    noise_floor: what noise alone leaves on the validation run; predictions: of the validation run, by estimate;
    closed_loop: errors by run and signal; loops: measured and simulated signals by run; failure: why there are none.
    """

    errors: dict[str, dict[str, dict[str, float]]]
    own: dict[str, dict[str, float]]
    noise_floor: dict[str, float]
    predictions: dict[str, Prediction]
    closed_loop: dict[str, dict[str, float]]
    loops: dict[str, pd.DataFrame]
    failure: str = ""


def validate(
    session: Session,
    model: InverseModel,
    batch: BatchStage,
    estimates: dict[str, Estimate],
    identification: pd.DataFrame,
    validation: pd.DataFrame,
) -> ValidationStage:
    """Predict the forces of both runs by every estimate that has one value per probed parameter."""
    systems = _regressions(session, model, batch, validation)
    system = systems[session.recommended.name]
    usable = {
        name: theta for name, e in estimates.items() if e.status == OK and (theta := _theta(e, model.names)) is not None
    }
    predictions = {name: predict(system, theta) for name, theta in usable.items()}
    errors = {
        "identification": {n: predict(batch.recommended.regression, theta).errors for n, theta in usable.items()},
        "validation": {name: p.errors for name, p in predictions.items()},
    }
    truth = None if session.truth is None else session.binding.select(session.truth, model.names)
    floor = noise_floor(system, truth, validation, session.rate, session.recommended)
    if truth is None and floor["total"] > min(p.errors["total"] for p in predictions.values()):
        floor = {}  # a guess above what is left over is no floor
    loops, failure = {}, ""
    try:
        loops = _closed_loops(session, estimates, identification, validation)
    except FmuError as error:
        failure = f"{error}; the identified parameters may be no robot's"
    closed_loop = {run: _loop_errors(loop, session.binding.n) for run, loop in loops.items()}
    own = _own_errors(batch, systems)
    return ValidationStage(errors, own, floor, predictions, closed_loop, loops, failure)


def _own_errors(batch: BatchStage, systems: dict[str, Regression]) -> dict[str, dict[str, float]]:
    """Total error of each WLS variant, both runs filtered as the variant filters."""
    own = {}
    for name, system in systems.items():
        found = batch.variants[name]
        runs = {"identification": found.regression, "validation": system}
        own[name] = {run: predict(r, found.estimate.theta).errors["total"] for run, r in runs.items()}
    return own


def _regressions(
    session: Session, model: InverseModel, batch: BatchStage, frame: pd.DataFrame
) -> dict[str, Regression]:
    """The frame's regression by each WLS variant that has one of the identification run."""
    n, rate, systems = session.binding.n, session.rate, {}
    for settings in session.experiment.wls:
        if batch.variants[settings.name].regression is not None:
            filtered = filter_frame(frame, n, rate, settings)
            systems[settings.name] = regression(filtered, n, rate, settings, model, model.names)
    return systems


def _theta(estimate: Estimate, names: tuple[str, ...]) -> np.ndarray | None:
    """The estimate's values of the probed parameters (p,), or None where it lacks one."""
    if not set(names) <= set(estimate.names):
        return None
    return np.array([estimate.theta[estimate.names.index(name)] for name in names])


def _closed_loops(
    session: Session, estimates: dict[str, Estimate], identification: pd.DataFrame, validation: pd.DataFrame
) -> dict[str, pd.DataFrame]:
    """Measured and simulated signals of both runs, with the parameters of the estimate that the experiment names."""
    settings = session.experiment.closed_loop
    if settings is None or not session.measured:  # simulated data hold noise that no re-simulation can know
        return {}
    if settings.estimate not in estimates or estimates[settings.estimate].status != OK:
        raise ConfigError(f"closed_loop.estimate: `{settings.estimate}` is no estimate that succeeded; name another")
    estimate = estimates[settings.estimate]
    chi = session.binding.a_priori
    for name, value in zip(estimate.names, estimate.theta, strict=True):
        chi[session.binding.names.index(name)] = value
    runs = {"identification": identification, "validation": validation}
    return {run: _closed_loop(session, frame, chi, settings.border) for run, frame in runs.items()}


def _closed_loop(session: Session, frame: pd.DataFrame, chi: np.ndarray, border: tuple[int, int]) -> pd.DataFrame:
    n = session.binding.n
    filtered = filter_frame(frame, n, session.rate, session.recommended)
    velocity = joint_columns("qd", n)
    simulated = run_loop(session, frame, chi, qd_start=filtered[velocity].iloc[0].to_numpy())
    columns = {}
    for i in range(1, n + 1):
        columns |= {f"q_{i}": frame[f"q_{i}"], f"q_{i} [simulated]": simulated[f"q_true_{i}"]}
        columns |= {f"qd_{i}": filtered[f"qd_{i}"], f"qd_{i} [simulated]": simulated[f"qd_true_{i}"]}
        columns |= {f"tau_{i}": frame[f"tau_{i}"], f"tau_{i} [simulated]": simulated[f"tau_{i}"]}
    return pd.DataFrame(columns).iloc[border[0] : len(frame) - border[1]]


def _loop_errors(loop: pd.DataFrame, n: int) -> dict[str, float]:
    """Relative errors in % of position, velocity and force over all joints."""
    names = {"position": "q", "velocity": "qd", "force": "tau"}
    return {
        what: relative_error(
            loop[joint_columns(c, n)].to_numpy(), loop[[f"{x} [simulated]" for x in joint_columns(c, n)]].to_numpy()
        )
        for what, c in names.items()
    }
