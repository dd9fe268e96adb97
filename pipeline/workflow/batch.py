"""The batch stage: every WLS variant, RLS and the essential parameters, on the regressor probed from the plant FMU."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from time import process_time

import numpy as np
import pandas as pd

from pipeline.errors import IdentificationError
from pipeline.identify.essential import Essential, essential
from pipeline.identify.regression import Excitation, excitation, regression
from pipeline.identify.rls import rls
from pipeline.identify.wls import wls
from pipeline.plant.binding import Binding
from pipeline.plant.plant import open_plant
from pipeline.plant.probing import InverseModel, probe
from pipeline.records import FAILED, Estimate, Regression, Trajectory
from pipeline.settings import WlsSettings
from pipeline.signals.frames import filter_frame, joint_columns
from pipeline.simulate.trajectory import read_waypoints, sample
from pipeline.workflow.engine import regressor_engine
from pipeline.workflow.session import Session

STRIDE = 25
"""Every how-many-th sample the mass matrix is looked at."""


@dataclass(frozen=True)
class Batch:
    """One WLS variant: its estimate, the filtered frame, the regression and its excitation (None where it failed)."""

    estimate: Estimate
    filtered: pd.DataFrame
    regression: Regression | None = None
    excitation: Excitation | None = None


@dataclass(frozen=True)
class BatchStage:
    """All variants by name; the recommended one's RLS and essential parameters, and whether its mass is positive."""

    variants: dict[str, Batch]
    recommended: Batch
    rls: Estimate
    essential: Essential | None
    mass_is_positive: bool


@contextmanager
def open_inverse_model(session: Session, frame: pd.DataFrame) -> Iterator[InverseModel]:
    """The probed inverse model, its structure tested on the filtered motion of the measured frame."""
    n = session.binding.n
    filtered = filter_frame(frame, n, session.rate, session.recommended)
    motion = [filtered[joint_columns(c, n)].to_numpy() for c in ("q", "qd", "qdd")]
    with open_plant(session.binding, "probe", engine=regressor_engine(session, *motion)) as plant:
        yield probe(plant, *motion, seed=session.experiment.seed)


def reference_excitation(session: Session, model: InverseModel) -> Excitation | None:
    """How well the noise-free reference trajectory excites, weighted by the known noise; None where that is 0."""
    settings, binding = session.experiment.simulation, session.binding
    if not all(settings.sigma_u):
        return None
    motion = sample(read_waypoints(session.folder / settings.identification), settings.rate)
    return motion_excitation(model, motion, binding, np.array(settings.sigma_u) * binding.gain)


def motion_excitation(
    model: InverseModel, motion: Trajectory, binding: Binding, sigma_tau: Sequence[float]
) -> Excitation:
    """How well a motion excites, unfiltered, weighted by the noise sigma_tau (n,) of the torque."""
    D, _ = model(motion.q, motion.qd, motion.qdd)
    W = D.transpose(1, 0, 2).reshape(-1, D.shape[2])
    joint, time = np.repeat(np.arange(binding.n), len(D)), np.tile(motion.t, binding.n)
    system = Regression(W, np.zeros(len(W)), time, joint, model.names, np.asarray(sigma_tau))
    return excitation(system, binding.select(binding.a_priori, model.names))


def run_batch(session: Session, frame: pd.DataFrame, model: InverseModel) -> BatchStage:
    """Estimate by every WLS variant, and by RLS on the recommended one. Raises IdentificationError where that fails."""
    variants = {w.name: run_variant(session, frame, model, w) for w in session.experiment.wls}
    best = variants[session.experiment.recommended]
    if best.regression is None:
        raise IdentificationError(best.estimate.reason)
    units = best.estimate.units
    try:
        kept = essential(best.regression, units)
    except IdentificationError:
        kept = None
    q, qd = (best.filtered[joint_columns(c, session.binding.n)].to_numpy()[::STRIDE] for c in ("q", "qd"))
    positive = model.mass_is_positive(q, qd, best.estimate.theta)
    return BatchStage(variants, best, rls(best.regression, units), kept, positive)


def run_variant(session: Session, frame: pd.DataFrame, model: InverseModel, settings: WlsSettings) -> Batch:
    """One WLS variant; one that cannot be solved is reported as failed, with its reason."""
    binding = session.binding
    unit = dict(zip(binding.names, binding.units, strict=True))
    start = process_time()
    filtered = filter_frame(frame, binding.n, session.rate, settings)
    units = tuple(unit[name] for name in model.names)
    try:
        system = regression(filtered, binding.n, session.rate, settings, model, model.names)
        estimate = wls(system, settings.name, units)
    except IdentificationError as error:
        nothing = np.full(len(model.names), np.nan)
        return Batch(Estimate(settings.name, "WLS", model.names, units, nothing, None, FAILED, str(error)), filtered)
    estimate = replace(estimate, held=dict(model.held), elapsed=process_time() - start)
    return Batch(estimate, filtered, system, excitation(system, binding.select(binding.a_priori, model.names)))
