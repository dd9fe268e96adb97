"""Which engine computes: the compiled one where it can be had and does as Python does, else Python, and why."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.errors import FmuError
from pipeline.identify.jacobian import Point, linearise
from pipeline.plant.plant import open_plant
from pipeline.workflow.session import Session

AGREED = 1e-9
"""Relative: both engines do the same operations in the same order, and have been seen to agree to the last bit."""

POINTS = 2


@dataclass(frozen=True)
class EngineChoice:
    """The engine `used`, "compiled", "python" or "filterpy"; reason: why it is not the one asked for."""

    used: str
    reason: str = ""

    @property
    def text(self) -> str:
        """One line for people."""
        words = {"compiled": "compiled", "python": "Python", "filterpy": "filterpy, in the Joseph form"}
        return f"{words[self.used]} ({self.reason})" if self.reason else words[self.used]


def choose_engine(
    session: Session, points: Sequence[Point], interface: str, method: str, substeps: int
) -> EngineChoice:
    """The engine for a filter with this transition: the compiled one is held against Python at some of the points."""
    wanted = session.experiment.engine
    if wanted != "compiled":
        return EngineChoice(wanted)
    reason = unavailable()
    if not reason:
        apart = _apart(session, points[:: len(points) // POINTS], interface, method, substeps)
        reason = "" if apart <= AGREED else f"compiled, the transition or its Jacobian is {apart:.1e} off"
    return EngineChoice("python", reason) if reason else EngineChoice("compiled")


def engine_of(session: Session) -> str:
    """The engine of regressor and closed loop: the one asked for where it can be had, else "python", which is told."""
    wanted = session.experiment.engine
    reason = unavailable() if wanted == "compiled" else ""
    if reason:
        session.tell_once(f"  regressor and closed loop: {EngineChoice('python', reason).text}")
    return "python" if reason else wanted


def unavailable() -> str:
    """Why there is no compiled engine, or ""."""
    try:
        import pipeline.plant.compiled  # noqa: F401
    except ImportError as error:
        return f"numba cannot be imported: {error}"
    return ""


def _apart(session: Session, points: Sequence[Point], interface: str, method: str, substeps: int) -> float:
    """How far the engines are apart, relative to the largest entry of each column; inf where one fails."""
    found = []
    for engine in ("python", "compiled"):
        try:
            with open_plant(session.binding, "filter", interface, method, substeps, engine) as plant:
                modes = ("forward", "central", "directional")[: 3 if plant.directional else 2]
                found.append(np.array([_columns(plant, p, mode) for p in points for mode in modes]))
        except FmuError:  # the filter will say what is wrong
            found.append(None)
    python, compiled = found
    if python is None or compiled is None:
        return 0.0 if python is compiled else np.inf
    size = np.maximum(np.abs(python).max(axis=1, keepdims=True), np.finfo(float).tiny)
    return float(np.max(np.abs(compiled - python) / size))


def _columns(plant, point: Point, mode: str) -> np.ndarray:
    """f and the columns of its Jacobian beside each other (ns, 1 + ns + p + n)."""
    p = point
    model = linearise(plant, p.s, p.chi, p.u, p.t, p.dt, mode)
    return np.hstack([model.f[:, None], model.A, model.B, model.C])
