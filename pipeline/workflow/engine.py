"""Which engine computes: the compiled one where it can be had and does as Python does, else Python, and why."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from pipeline.errors import FmuidError
from pipeline.identify.ekf import Tuning, run_filter
from pipeline.identify.jacobian import Point
from pipeline.plant.plant import open_plant
from pipeline.plant.probing import InverseModel
from pipeline.workflow.session import EngineChoice, Session

AGREED = 1e-9
"""Relative: both engines do the same operations in the same order, and have been seen to agree to the last bit."""

POINTS = 3

Outcome = np.ndarray | str
"""Numbers, or the message of the error instead."""


def choose_engine(
    session: Session, points: Sequence[Point], interface: str, method: str, substeps: int
) -> EngineChoice:
    """The engine for a filter with this transition: short filters from some of the points, in every mode there is."""
    covariance = session.experiment.ekf.covariance

    def filtered(engine: str) -> list[Outcome]:
        with open_plant(session.binding, "filter", interface, method, substeps, engine) as plant:
            modes = ("forward", "central", "directional")[: 3 if plant.directional else 2]
            return [_short_filter(plant, point, mode, covariance) for point in _some(points) for mode in modes]

    return _chosen(session, filtered)


def regressor_engine(session: Session, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> str:
    """The engine of the regressor, D and y0 compared at points of a motion q, qd, qdd (N, n)."""

    def probed(engine: str) -> list[Outcome]:
        with open_plant(session.binding, "probe", engine=engine) as plant:
            model = InverseModel(plant)
            return [_outcome(partial(model, q[k : k + 1], qd[k : k + 1], qdd[k : k + 1])) for k in _some(range(len(q)))]

    return _told(session, "regressor", probed)


def loop_engine(session: Session, simulated: Callable[[str, int], np.ndarray]) -> str:
    """The engine of the closed loop; simulated(engine, samples): its beginning."""
    return _told(session, "closed loop", lambda engine: [_outcome(lambda: [simulated(engine, POINTS)])])


def unavailable(narrate: Callable[[str], None]) -> str:
    """Why there is no compiled engine, or "". narrate: told why the first run takes longer."""
    try:
        from pipeline.plant.kernel import compiles

        compiles(lambda: narrate("  compiling the engine for this plant: less than a minute …"))
    except Exception as error:  # whatever numba or LLVM meets on this machine
        return f"numba cannot be used: {_one_line(error)}"
    return ""


def _told(session: Session, part: str, compute: Callable[[str], list[Outcome]]) -> str:
    """The engine of a part of the session, chosen once; if it is not the one asked for, the user is told."""
    if session.experiment.engine == "filterpy":  # which computes filters only
        return session.engines.setdefault(part, EngineChoice("python")).used
    if part not in session.engines:
        session.engines[part] = choice = _chosen(session, compute)
        if choice.reason:
            session.narrate(f"  {part}: {choice.text}")
    return session.engines[part].used


def _chosen(session: Session, compute: Callable[[str], list[Outcome]]) -> EngineChoice:
    """The engine asked for; the compiled one only if compute(engine) gives what Python gives."""
    if session.experiment.engine != "compiled":
        return EngineChoice(session.experiment.engine)
    reason = unavailable(session.narrate)
    if not reason:
        python = compute("python")
        try:
            reason = _difference(python, compute("compiled"))
        except Exception as error:  # whatever numba meets when it compiles
            reason = f"compiled, it fails: {_one_line(error)}"
    return EngineChoice("python", reason) if reason else EngineChoice("compiled")


def _difference(python: list[Outcome], compiled: list[Outcome]) -> str:
    """In words, how the outcomes differ: what failed by its message, the rest entry by entry, relative; or ""."""
    apart = []
    for one, other in zip(python, compiled, strict=True):
        if isinstance(one, str) or isinstance(other, str):
            if str(one) != str(other):
                return f"compiled, it ends otherwise: {other if isinstance(other, str) else 'without an error'}"
        else:
            size = np.maximum(np.abs(one), np.abs(one).max(axis=-1, keepdims=True) * np.finfo(float).eps)
            apart.append(np.max(np.abs(other - one) / np.maximum(size, np.finfo(float).tiny)))
    if not apart:
        return "compiled and Python could not be compared: every evaluation fails"
    worst = float(np.max(apart))  # NaN where one is NaN
    return "" if worst <= AGREED else f"compiled, it is {worst:.1e} off"


def _short_filter(plant, point: Point, mode: str, covariance: str) -> Outcome:
    """Two samples of a filter from a point: estimates, variances, innovations, covariance."""
    b, p, n = plant.binding, point, plant.n
    z0 = np.concatenate([p.s, p.chi])
    P0 = np.diag(np.concatenate([np.full(plant.ns, 1e-2), (0.1 * b.scale) ** 2]))
    q = np.array([p.s[n : 2 * n], p.s[n : 2 * n] + p.dt * p.s[:n]])
    tuning = Tuning(np.full(n, 1e-6), (0.01 * b.u_range * b.gain) ** 2, input_noise=True)
    time = np.array([p.t, p.t + p.dt])
    run = run_filter(plant, time, q, np.array([p.u, p.u]), z0, P0, tuning, mode, covariance)
    if run.failed_at is not None:
        return run.reason
    return np.concatenate([run.x, run.P_diag, run.innovation, run.S_diag, np.resize(run.P, (2, run.P.size))], axis=1)


def _outcome(compute: Callable[[], Sequence[np.ndarray]]) -> Outcome:
    """The numbers, side by side, or the message of the error."""
    try:
        return np.concatenate([np.ravel(values) for values in compute()])
    except FmuidError as error:
        return str(error)


def _some(items: Sequence) -> list:
    """POINTS of them, spread evenly."""
    return list(items[:: max(1, len(items) // POINTS)])[:POINTS]


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())[:200] or type(error).__name__
