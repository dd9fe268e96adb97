"""The transition and its Jacobian: by the FMU's directional derivatives, or by finite differences through the plant.

The time is held for all of it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from pipeline.plant.steps import EPSILON, floor

AGREED = 1e-3
"""Two modes that differ by more, of a column's largest entry, are not derivatives of one thing."""


@dataclass(frozen=True)
class Linearised:
    """s⁺ = f(s, chi, u): f (ns,); A (ns, ns) = ∂f/∂s; B (ns, p) = ∂f/∂chi; C (ns, n) = ∂f/∂u."""

    f: np.ndarray
    A: np.ndarray
    B: np.ndarray
    C: np.ndarray


@dataclass(frozen=True)
class Point:
    """Where a transition is linearised: state s (ns,), parameters chi (p,), input u (n,), time t and step dt in s."""

    s: np.ndarray
    chi: np.ndarray
    u: np.ndarray
    t: float
    dt: float


def linearise(plant, s: np.ndarray, chi: np.ndarray, u: np.ndarray, t: float, dt: float, mode: str) -> Linearised:
    """Linearise the plant's transition over dt (s) at s (ns,), chi (p,), u (n,).

    mode: "forward" or "central" differences, of 1 + m or 1 + 2m transitions, m = ns + p + n; or "directional": the
    FMU's own derivatives, and forward differences by those parameters that are none of its inputs (the standards grant
    parameters as knowns in Initialization Mode only: FMI 2.0.5, §2.2.8).
    """
    ns, p = len(s), len(chi)
    if plant.compiled:
        f, J = plant.linearise(s, u, chi, t, dt, mode)
        return Linearised(f, J[:, :ns], J[:, ns : ns + p], J[:, ns + p :])
    if mode != "directional":
        f = plant.transition(s, u, chi, t, dt)
        J = np.eye(ns, ns + p + len(u))  # the columns that make no difference stay so
        J[:, plant.columns] = _differences(plant, s, chi, u, t, dt, mode, f, plant.columns)
        return Linearised(f, J[:, :ns], J[:, ns : ns + p], J[:, ns + p :])
    known = plant.sensitivity(s, u, chi, t, dt)
    B = np.empty((ns, p))
    B[:, known.fed] = known.B
    rest = np.setdiff1d(np.arange(p), known.fed)
    B[:, rest] = _differences(plant, s, chi, u, t, dt, "forward", known.f, ns + rest)
    return Linearised(known.f, known.A, B, known.C)


def _differences(plant, s, chi, u, t: float, dt: float, mode: str, f: np.ndarray, columns: Iterable[int]) -> np.ndarray:
    """The columns (ns, k) of ∂f/∂[s, chi, u] that are asked for."""
    ns, p = len(s), len(chi)
    point = np.concatenate([s, chi, u])
    step = EPSILON[mode] * np.maximum(np.abs(point), floor(plant.binding, ns))

    def moved(i: int, by: float) -> tuple[np.ndarray, float]:
        there = point.copy()
        there[i] += by
        return plant.transition(there[:ns], there[ns + p :], there[ns : ns + p], t, dt), there[i]

    J = []
    for i in columns:
        ahead, at = moved(i, step[i])
        behind, back = (f, point[i]) if mode == "forward" else moved(i, -step[i])
        J.append((ahead - behind) * (1.0 / (at - back)))  # the step that was taken, not the one asked for
    return np.array(J).reshape(-1, ns).T


def everything(plant) -> np.ndarray:
    """The places of all columns: `plant.columns`, if nothing is believed."""
    return np.arange(plant.ns + len(plant.binding.scale) + plant.n)


def disagreement(plant, points: Iterable[Point], mode: str, other: str) -> float:
    """How far two modes are apart, at worst over points: relative, and by columns; inf where that is no number.

    The other one differences even the columns that make no difference by the FMU's own word.

    State columns are compared as rates (A − I)/dt, since the identity in A would hide the plant; rates below 1 count as
    1. The other columns are relative to their largest entry over all points.
    """
    points = list(points)
    ones = [linearise(plant, p.s, p.chi, p.u, p.t, p.dt, mode) for p in points]
    believed, plant.columns = plant.columns, everything(plant)
    others = [linearise(plant, p.s, p.chi, p.u, p.t, p.dt, other) for p in points]
    plant.columns = believed
    pairs = list(zip(ones, others, strict=True))
    rates = [
        _apart(*((m.A - np.eye(len(m.A))) / p.dt for m in pair), 1.0) for p, pair in zip(points, pairs, strict=True)
    ]
    J, K = (np.vstack([np.hstack([m.B, m.C]) for m in models]) for models in zip(*pairs, strict=True))
    worst = max(*rates, _apart(J, K, 0.0))
    return worst if np.isfinite(worst) else np.inf


def _apart(J: np.ndarray, K: np.ndarray, least: float) -> float:
    """The largest entry of a column of J − K over that of K's, which counts as `least` where it is smaller."""
    apart, size = np.abs(J - K).max(axis=0), np.maximum(np.abs(K).max(axis=0), least)
    with np.errstate(divide="ignore", invalid="ignore"):
        return float(np.max(np.where(apart == 0.0, 0.0, apart / size)))
