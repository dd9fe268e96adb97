"""Which engine computes: the compiled one where it can be had and does as Python does, else Python, and why."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from pipeline.errors import FmuidError
from pipeline.identify.jacobian import Point, linearise
from pipeline.plant.plant import open_plant
from pipeline.plant.probing import InverseModel
from pipeline.workflow.session import EngineChoice, Session

AGREED = 1e-9
"""Relative: both engines do the same operations in the same order, and have been seen to agree to the last bit."""

POINTS = 3


def choose_engine(
    session: Session, points: Sequence[Point], interface: str, method: str, substeps: int
) -> EngineChoice:
    """The engine for a filter with this transition: f and its derivatives are compared, in every mode there is."""

    def evaluated(engine: str) -> np.ndarray:
        with open_plant(session.binding, "filter", interface, method, substeps, engine) as plant:
            modes = ("forward", "central", "directional")[: 3 if plant.directional else 2]
            return np.array([_columns(plant, p, mode) for p in _some(points) for mode in modes])

    return _chosen(session, evaluated)


def regressor_engine(session: Session, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> str:
    """The engine of the regressor, D and y0 compared at points of a motion q, qd, qdd (N, n)."""

    def probed(engine: str) -> np.ndarray:
        with open_plant(session.binding, "probe", engine=engine) as plant:
            D, y0 = InverseModel(plant)(_some(q), _some(qd), _some(qdd))
        return np.concatenate([D, y0[:, :, None]], axis=2)

    return _told(session, "regressor", probed)


def loop_engine(session: Session, simulated: Callable[[str, int], np.ndarray]) -> str:
    """The engine of the closed loop; simulated(engine, samples): its beginning."""
    return _told(session, "closed loop", lambda engine: simulated(engine, POINTS))


def unavailable(narrate: Callable[[str], None]) -> str:
    """Why there is no compiled engine, or "". narrate: told why the first run takes longer."""
    try:
        from pipeline.plant.kernel import compiles, is_cached

        if not is_cached():
            narrate("  compiling the engine, once: less than a minute …")
        compiles()
    except Exception as error:  # whatever numba or LLVM meets on this machine
        return f"numba cannot be used: {' '.join(str(error).split())[:200] or type(error).__name__}"
    return ""


def _told(session: Session, part: str, compute: Callable[[str], np.ndarray]) -> str:
    """The engine of a part of the session, chosen once; if it is not the one asked for, the user is told."""
    if session.experiment.engine == "filterpy":  # which computes filters only
        return session.engines.setdefault(part, EngineChoice("python")).used
    if part not in session.engines:
        session.engines[part] = choice = _chosen(session, compute)
        if choice.reason:
            session.narrate(f"  {part}: {choice.text}")
    return session.engines[part].used


def _chosen(session: Session, compute: Callable[[str], np.ndarray]) -> EngineChoice:
    """The engine asked for; the compiled one only if compute(engine), by columns, is the same as Python's."""
    if session.experiment.engine != "compiled":
        return EngineChoice(session.experiment.engine)
    reason = unavailable(session.narrate)
    if not reason:
        apart = _apart(compute)
        reason = "" if apart <= AGREED else f"compiled, it is {apart:.1e} off"
    return EngineChoice("python", reason) if reason else EngineChoice("compiled")


def _apart(compute: Callable[[str], np.ndarray]) -> float:
    """How far the engines are apart, relative to the largest entry of each column; inf where only one fails."""
    found = []
    for engine in ("python", "compiled"):
        try:
            found.append(compute(engine))
        except FmuidError:  # whoever uses it will say what is wrong
            found.append(None)
    python, compiled = found
    if python is None or compiled is None:
        return 0.0 if python is compiled else np.inf
    size = np.maximum(np.abs(python).max(axis=-2, keepdims=True), np.finfo(float).tiny)
    return float(np.max(np.abs(compiled - python) / size))


def _some(items: Sequence) -> Sequence:
    """POINTS of them, spread evenly."""
    return items[:: max(1, len(items) // POINTS)][:POINTS]


def _columns(plant, point: Point, mode: str) -> np.ndarray:
    """f and the columns of its Jacobian beside each other (ns, 1 + ns + p + n)."""
    p = point
    model = linearise(plant, p.s, p.chi, p.u, p.t, p.dt, mode)
    return np.hstack([model.f[:, None], model.A, model.B, model.C])
