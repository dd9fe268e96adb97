"""How well a way-point trajectory excites a plant: the log-determinant of its relative information, and its gradient.

The information of chi relative to its size is S Wᵀ Σ⁻¹ W S, S = diag(scale), W the rows D(q, qd, qdd) of all samples.
Its log-determinant (D-optimality) grows as the volume of the confidence ellipsoid shrinks. S shifts it by a constant.

Way-points enter q, qd, qdd linearly (quintic Hermite polynomials), and [D y0] = M(q) qdd + h(q, qd). With M, h and
their differences by q and qd at the points of a coarse grid, the chain rule gives the whole gradient: its cost does
not depend on the number of way-points. Limits and caps enter as squared hinges, weighted by `rho`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from pipeline.errors import IdentificationError
from pipeline.simulate.trajectory import Limits, Waypoints, evaluate

STEP = 1e-6
"""Of the limit of |q|: the difference by q."""
KINEMATIC_POINTS = 50
"""Points per segment where |q|, |qd|, |qdd| are held; they need no plant."""
SINGULAR = 1e-12
"""The share of the best excited parameter below which one counts as not excited."""


class Affine(Protocol):
    """A plant's inverse model in parts: [D y0] (N, n, p + 1) = mass(q) qdd + rest(q, qd, mass(q))."""

    def mass(self, q: np.ndarray) -> np.ndarray: ...

    def rest(self, q: np.ndarray, qd: np.ndarray, mass: np.ndarray) -> np.ndarray: ...


@dataclass(frozen=True)
class Task:
    """What is asked of a trajectory through K way-points at t (K,) s, at rest at both ends, starting from q = 0.

    limits (n,) of |q|, |qd|, |qdd|, |tau|; margin (4, n), the share of them to use; slow (n,), in qd's unit: D is taken
    as linear in qd between knots this far apart, so that sgn(qd) has a slope to follow, and what is slower counts for
    less; chi (p,) a-priori values; scale (p,) their sizes, none 0; sigma (n,) of the torque per sample; rate of the
    samples and of the grid that stands for them, Hz; caps on both condition numbers; names (p,) for messages.
    """

    t: np.ndarray
    limits: Limits
    margin: np.ndarray
    slow: np.ndarray
    chi: np.ndarray
    scale: np.ndarray
    sigma: np.ndarray
    rate: float
    grid: float
    cap_W: float = np.inf
    cap_Phi: float = np.inf
    names: tuple[str, ...] = ()


@dataclass(frozen=True)
class Expansion:
    """[D y0] (N, n, p + 1) and its derivatives by q_j, qd_j, qdd_j (N, n, p + 1, n)."""

    D: np.ndarray
    by_q: np.ndarray
    by_qd: np.ndarray
    by_qdd: np.ndarray


class Objective:
    """The function to minimise over x (m,), the motion in coordinates where a unit step is a unit change of it.

    The change is the root mean square of q, qd, qdd as shares of their limits: without it the descent needs ten times
    the steps.
    """

    def __init__(self, model: Affine, task: Task):
        K, duration = len(task.t), task.t[-1] - task.t[0]
        bounds = np.array([task.limits.q, task.limits.qd, task.limits.qdd, task.limits.tau], float)
        self.model, self.task = model, task
        self._limits, self._tau_limit = bounds[:3] * task.margin[:3], bounds[3] * task.margin[3]
        self._steps = STEP * bounds[0], np.asarray(task.slow), positions_that_matter(model, bounds)
        self._free = np.r_[1:K, K + 1 : 2 * K - 1, 2 * K + 1 : 3 * K - 1]
        points = int(np.ceil(duration * task.grid))
        self._weight = task.rate * duration / points / np.square(task.sigma)
        self._grid = self._basis((np.arange(points) + 0.5) / points)
        self._held = self._basis(np.linspace(0.0, 1.0, KINEMATIC_POINTS * (K - 1) + 1))
        self._values = np.stack([_whitening(self._held, limits) for limits in bounds[:3].T])

    def __call__(self, x: np.ndarray, rho: float) -> tuple[float, np.ndarray]:
        """The objective at x (m,) and its gradient (m,): −log det + rho · (hinges of limits and caps)²."""
        values = self._of(x)
        motion, held = self._grid @ values, self._held @ values
        found = expand(self.model, *motion, *self._steps)
        value, by_D = self._of_regressor(found.D, rho)
        by_motion = [np.einsum("gic,gicj->gj", by_D, d) for d in (found.by_q, found.by_qd, found.by_qdd)]
        share = rho * motion.shape[1] / held.shape[1]
        excess, slope = hinge(held, self._limits[:, None])
        by_values = np.einsum("kgm,kgj->mj", self._grid, by_motion)
        by_values += share * np.einsum("kgm,kgj->mj", self._held, slope)
        return value + share * excess, np.einsum("jmy,mj->jy", self._values, by_values).ravel()

    def start(self, rng: np.random.Generator) -> np.ndarray:
        """A random motion x (m,), as large as the limits of q, qd, qdd let it be."""
        x = rng.standard_normal(self._values.shape[0] * self._values.shape[2])
        return x / np.max(np.abs(self._held @ self._of(x)) / self._limits[:, None])

    def waypoints(self, x: np.ndarray, unit: str = "rad") -> Waypoints:
        """The way-points of the motion x (m,)."""
        n = len(self._values)
        every = np.zeros((3 * len(self.task.t), n))
        every[self._free] = self._of(x)
        return Waypoints(self.task.t, *np.split(every, 3), unit)

    def _of(self, x: np.ndarray) -> np.ndarray:
        """The free values of the way-points, a column per joint, of the motion x (m,)."""
        return np.einsum("jmy,jy->mj", self._values, x.reshape(len(self._values), -1))

    def _basis(self, share: np.ndarray) -> np.ndarray:
        """q, qd, qdd (3, N, m) at a share (N,) of the duration per unit of each free value: evaluation is linear."""
        t = self.task.t
        motion = evaluate(Waypoints(t, *np.split(np.eye(3 * len(t)), 3)), t[0] + share * (t[-1] - t[0]))
        return np.stack([motion.q, motion.qd, motion.qdd])[:, :, self._free]

    def _of_regressor(self, D: np.ndarray, rho: float) -> tuple[float, np.ndarray]:
        """Everything that depends on [D y0] (N, n, p + 1): value, and derivative by it."""
        task, by_D = self.task, np.zeros_like(D)
        value, by_D[..., :-1] = criterion(D[..., :-1], self._weight, task, rho)
        chi = np.append(task.chi, 1.0)
        excess, slope = hinge(D @ chi, self._tau_limit)
        return value + rho * excess, by_D + rho * slope[..., None] * chi


def _whitening(basis: np.ndarray, limits: np.ndarray) -> np.ndarray:
    """Values of way-points (m, m) per coordinate in which the motion's shares of its limits (3,) are white."""
    shares = (basis / limits[:, None, None]).reshape(-1, basis.shape[2])
    return np.linalg.inv(np.linalg.qr(shares, mode="r")) * np.sqrt(len(shares))


def expand(
    model: Affine,
    q: np.ndarray,
    qd: np.ndarray,
    qdd: np.ndarray,
    step: np.ndarray,
    cell: np.ndarray,
    positions: Sequence[int],
) -> Expansion:
    """[D y0] and its derivatives at q, qd, qdd (N, n): by steps (n,) in the `positions`, linear in cells (n,) of qd."""
    n = q.shape[1]
    knot = (np.floor(qd / cell - 0.5) + 0.5) * cell

    def at(q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        M = model.mass(q)
        base = model.rest(q, knot, M)
        slopes = [(model.rest(q, knot + only(cell, j), M) - base) / cell[j] for j in range(n)]
        by_qd = np.stack(slopes, axis=-1)
        D = base + np.einsum("gicj,gj->gic", by_qd, qd - knot) + np.einsum("gijc,gj->gic", M, qdd)
        return D, by_qd, M.swapaxes(2, 3)

    D, by_qd, by_qdd = at(q)
    by_q = np.zeros_like(by_qd)
    for j in positions:
        by_q[..., j] = (at(q + only(step, j))[0] - D) / step[j]
    return Expansion(D, by_q, by_qd, by_qdd)


def positions_that_matter(model: Affine, bounds: np.ndarray) -> list[int]:
    """The joints whose position changes the inverse model, seen at random points within bounds (4, n)."""
    q, qd = np.random.default_rng(0).uniform(-0.8, 0.8, (2, 20, bounds.shape[1])) * bounds[:2, None]

    def parts(q: np.ndarray) -> np.ndarray:
        M = model.mass(q)
        return np.concatenate([M.ravel(), model.rest(q, qd, M).ravel()])

    here = parts(q)
    changes = [np.abs(parts(q + only(0.1 * bounds[0], j)) - here).max() for j in range(q.shape[1])]
    return [j for j, change in enumerate(changes) if change > 1e-9 * np.abs(here).max()]


def only(size: np.ndarray, j: int) -> np.ndarray:
    """The entry j of size (n,), zeros elsewhere."""
    return np.where(np.arange(len(size)) == j, size, 0.0)


def criterion(D: np.ndarray, weight: np.ndarray, task: Task, rho: float) -> tuple[float, np.ndarray]:
    """−log det of the relative information of D (N, n, p), rows weighted by weight (n,), and its derivative by D.

    The caps on cond(W_w) and cond(Phi) add rho · max(0, log(cond/cap))². Raises IdentificationError where the
    information is singular.
    """
    weighted = D * (weight[:, None] * task.scale)
    R = np.linalg.qr((D * np.sqrt(weight)[:, None] * task.scale).reshape(-1, D.shape[2]), mode="r")
    diagonal = np.abs(np.diag(R))
    if not diagonal.min() > SINGULAR * diagonal.max():
        raise IdentificationError(_not_excited(diagonal, task))
    inverse = np.linalg.inv(R)
    value, G = -2.0 * np.log(diagonal).sum(), -2.0 * inverse @ inverse.T
    for size, cap in ((1.0 / task.scale, task.cap_W), (task.chi / task.scale, task.cap_Phi)):
        log_cond, slope = _log_condition(R, size)
        excess = log_cond - np.log(cap)
        if excess > 0.0:
            value, G = value + rho * excess**2, G + 2.0 * rho * excess * slope
    return float(value), weighted @ (G * task.scale)


def _not_excited(diagonal: np.ndarray, task: Task) -> str:
    """Which parameter a motion says nothing of: diagonal (p,) of R."""
    worst = int(np.argmin(diagonal))
    name = task.names[worst] if task.names else f"parameter {worst + 1}"
    share = diagonal[worst] / diagonal.max() if diagonal.max() > 0.0 else 0.0
    tau = ", ".join(f"{limit:g}" for limit in task.limits.tau)
    return (
        f"excitation: {name} is not excited at all, or not apart from the others (its share is {share:.1g}, at least "
        f"{SINGULAR:g} is needed); widen the limits (tau = {tau}), or give more segments or a finer grid"
    )


def _log_condition(R: np.ndarray, size: np.ndarray) -> tuple[float, np.ndarray]:
    """log cond(R diag(size)) over the columns of size ≠ 0, and G (p, p) such that its differential is tr(dRᵀ R G)."""
    known = size != 0.0
    if not known.any():
        return 0.0, np.zeros((len(size), len(size)))
    _, s, Vt = np.linalg.svd(R[:, known] * size[known])
    ends = np.zeros((2, len(size)))
    ends[:, known] = Vt[[0, -1]] * size[known] / s[[0, -1], None]
    return float(np.log(s[0] / s[-1])), np.outer(ends[0], ends[0]) - np.outer(ends[1], ends[1])


def hinge(values: np.ndarray, limit: np.ndarray) -> tuple[float, np.ndarray]:
    """Σ max(0, |values|/limit − 1)², and its derivative by the values."""
    excess = np.maximum(np.abs(values) / limit - 1.0, 0.0)
    return float(np.sum(excess**2)), 2.0 * excess * np.sign(values) / limit
