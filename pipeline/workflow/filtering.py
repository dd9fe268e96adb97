"""The EKF stage: every case of the experiment with every tuning, through the plant FMU."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, partial
from time import process_time

import numpy as np
import pandas as pd

from pipeline.errors import ConfigError, IdentificationError
from pipeline.identify.discretisation import worst_shift
from pipeline.identify.ekf import Tuning, run_filter
from pipeline.identify.jacobian import everything
from pipeline.identify.tuning import force_noise, position_noise
from pipeline.plant.binding import Binding
from pipeline.plant.plant import open_plant
from pipeline.records import FAILED, OK, Estimate, FilterRun
from pipeline.settings import EkfCase
from pipeline.signals.filters import cutoff_frequency
from pipeline.signals.frames import joint_columns
from pipeline.simulate.sensors import position_variance
from pipeline.workflow.batch import Batch
from pipeline.workflow.differentiating import JacobianChoice, choose_jacobian, points_of
from pipeline.workflow.engine import choose_engine
from pipeline.workflow.session import EngineChoice, Session

FINER = 4
"""Times as many sub-steps as the filter's make the integration that its transition is held against."""


@dataclass(frozen=True)
class Filtered:
    """One run of the filter: its estimate, its signals, the prior chi0 (p,), its tuning and settings.

    engine: what computed it; jacobian: how that is computed; calls: evaluations of the FMU; shift: the worst shift in
    sigma by the transition's own error, where it is known.
    """

    estimate: Estimate
    run: FilterRun
    chi0: np.ndarray
    tuning: str
    settings: dict
    engine: EngineChoice
    jacobian: JacobianChoice
    calls: int
    shift: float | None = None


def run_filters(session: Session, frame: pd.DataFrame, best: Batch) -> dict[str, Filtered]:
    """Run every case on the measured frame; `best` is the recommended WLS variant."""
    chosen = cache(partial(choose, session, best))
    return {
        case.called(tuning): run_case(session, frame, best, case, tuning, chosen(*transition_of(session, case)))
        for case in session.experiment.ekf.case
        for tuning in case.tunings
    }


def choose(
    session: Session, best: Batch, interface: str, method: str, substeps: int
) -> tuple[EngineChoice, JacobianChoice]:
    """The engine and the Jacobian for a transition, each checked on the filtered motion before a filter runs."""
    engine = choose_engine(session, points_of(session, best), interface, method, substeps)
    if engine.reason:
        session.narrate(f"  {transition_text(interface, method, substeps)}: {engine.text}")
    return engine, choose_jacobian(session, best, interface, method, substeps, engine.used)


def run_case(
    session: Session,
    frame: pd.DataFrame,
    best: Batch,
    case: EkfCase,
    tuning: str,
    chosen: tuple[EngineChoice, JacobianChoice] | None = None,
) -> Filtered:
    """Run one case with one tuning ("paper", "known" or "derived"); chosen: what `choose` chose for its transition."""
    ekf, binding = session.experiment.ekf, session.binding
    interface, method, substeps = transition_of(session, case)
    engine, jacobian = chosen or choose(session, best, interface, method, substeps)
    noise = noise_levels(session, frame, best.regression.sigma_rho, case, tuning)
    q = frame[joint_columns("q", binding.n)].to_numpy()
    u = frame[joint_columns("u", binding.n)].to_numpy()
    chi0, P0 = prior(session, case, best.estimate)
    z0 = np.concatenate([start_velocity(session, best), q[0], chi0])
    time, start = frame.index.to_numpy(dtype=float), process_time()
    covariance = "filterpy" if engine.used == "filterpy" else ekf.covariance
    with open_plant(binding, "filter", interface, method, substeps, engine.used) as plant:
        if jacobian.all_columns:
            plant.columns = everything(plant)
        run = run_filter(plant, time, q, u, z0, P0, noise, jacobian.used, covariance)
        calls = plant.calls
    estimate = _estimate(case.called(tuning), binding, run, time, chi0, process_time() - start)
    shift = None
    if run.failed_at is None and interface == "ME" and np.all(noise.q > 0):
        shift = transition_shift(binding, run, u, noise, method, substeps, engine.used)
    settings = {
        "transition": transition_text(interface, method, substeps),
        "interface": interface[:2],
        "engine": engine.text,
        "jacobian": jacobian.text,
        "covariance": covariance,
        "P0": np.diag(P0).tolist(),
        "R": noise.R.tolist(),
        "Q": noise.q.tolist(),
        "process_noise": "on the joint forces" if noise.input_noise else "on the states",
    }
    return Filtered(estimate, run, chi0, tuning, settings, engine, jacobian, calls, shift)


def transition_of(session: Session, case: EkfCase) -> tuple[str, str, int]:
    """Interface, method and sub-steps of a case's transition."""
    ekf = session.experiment.ekf
    method = case.method or ekf.method
    return (
        "ME" if method == "euler" else ekf.interface,
        method,
        case.substeps or ekf.substeps,
    )  # Euler needs derivatives


def transition_text(interface: str, method: str, substeps: int) -> str:
    """How a transition is computed, in words."""
    if interface != "ME":
        return f"Co-Simulation, the FMU's own steps{', each after a reset' if interface == 'CS reset' else ''}"
    if method == "euler":
        return "Euler (Eq. 13)"
    return f"RK4, {substeps} sub-step{'' if substeps == 1 else 's'}"


def transition_shift(
    binding: Binding, run: FilterRun, u: np.ndarray, noise: Tuning, method: str, substeps: int, engine: str
) -> float:
    """The worst shift in sigma by the transition's own error: against the same plant in FINER sub-steps by RK4."""
    with (
        open_plant(binding, "filter", "ME", method, substeps, engine) as plant,
        open_plant(binding, "filter", "ME", "rk4", FINER * substeps, engine) as fine,
    ):
        plant.columns = everything(plant)  # here nothing would show that the FMU's word on them is wrong
        return worst_shift(plant, fine, run, u, noise)


def start_velocity(session: Session, best: Batch) -> np.ndarray:
    """qd (n,) where the filter starts: at rest, or as the filtered record begins."""
    if session.experiment.ekf.start_at_rest:
        return np.zeros(session.binding.n)
    return best.filtered[joint_columns("qd", session.binding.n)].iloc[0].to_numpy()


def prior(session: Session, case: EkfCase, best: Estimate) -> tuple[np.ndarray, np.ndarray]:
    """chi0 (p,) and P0 (nx, nx) of a case. IdentificationError where it needs a WLS that held parameters."""
    builds_on_wls = case.wls_factor is not None or case.P0_sigmas is not None
    if builds_on_wls and best.names != session.binding.names:
        raise IdentificationError(f"{case.name}: starts from {best.name}, which did not estimate every parameter")
    chi0 = np.array(case.chi0) if case.wls_factor is None else case.wls_factor * best.theta
    variance = np.array(case.P0_parameters)
    if case.P0_relative is not None:
        variance = (case.P0_relative * chi0) ** 2
    if case.P0_sigmas is not None:
        variance = (case.P0_sigmas * best.sigma) ** 2
    state = case.P0_state or session.experiment.ekf.P0_state
    return chi0, np.diag([*state, *variance])


def noise_levels(session: Session, frame: pd.DataFrame, sigma_rho: np.ndarray, case: EkfCase, tuning: str) -> Tuning:
    """The filter's noise: as the paper printed it, as the simulation made it, or as the data show it."""
    simulation = session.experiment.simulation
    if tuning == "paper":
        return Tuning(np.array(case.R), np.array(case.Q), input_noise=False)
    if tuning == "known":
        sigma_tau = np.array(simulation.sigma_u) * session.binding.gain
        return Tuning(position_variance(simulation.sigma_q, simulation.quantum_q), sigma_tau**2, input_noise=True)
    settings, rate = session.recommended, session.rate
    q = frame[joint_columns("q", session.binding.n)].to_numpy()
    band, parallel = (cutoff_frequency(rate, f, settings.decimation) for f in (settings.position, settings.parallel))
    if band >= 0.5 * rate:
        raise ConfigError(f"{settings.name}: the tuning `derived` needs a position filter with a cut-off; set one")
    sigma_q, sigma_tau = position_noise(q, rate, band), force_noise(sigma_rho, rate, parallel)
    return Tuning(sigma_q**2, sigma_tau**2, input_noise=True)


def _estimate(
    name: str, binding: Binding, run: FilterRun, time: np.ndarray, chi0: np.ndarray, elapsed: float
) -> Estimate:
    failed, ns = run.failed_at is not None, run.x.shape[1] - len(chi0)
    theta = run.x[-1, ns:] if len(run.x) else chi0
    return Estimate(
        name,
        "EKF",
        binding.names,
        binding.units,
        theta,
        None if failed else run.P[ns:, ns:],
        FAILED if failed else OK,
        _why(run, time, binding.names, theta) if failed else "",
        elapsed=elapsed,
        history_time=run.time,
        history=run.x[:, ns:],
        history_sigma=np.sqrt(np.maximum(run.P_diag[:, ns:], 0.0)),
    )


def _why(run: FilterRun, time: np.ndarray, names: tuple[str, ...], theta: np.ndarray) -> str:
    """Where the run stopped, with which parameters, and the plant's or the filter's own reason."""
    values = ", ".join(f"{name} {value:.3g}" for name, value in zip(names, theta, strict=True))
    state = f"with {values}" if theta.any() else "with all parameters 0, so that the plant has no mass"
    return f"stopped at sample {run.failed_at} (t = {time[run.failed_at]:g} s) {state}: {run.reason}"
