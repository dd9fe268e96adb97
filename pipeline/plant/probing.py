"""The inverse model tau = D(q, qd, qdd) chi + y0, probed from the plant FMU: no formula is needed.

qdd is affine in the input, qdd = qdd0 + J tau, so tau(q, qd, qdd; chi) = J⁻¹ (qdd − qdd0); where tau is linear in
chi, column i of D is a difference of tau over a large step. Both assumptions are tested before D is used.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from pipeline.errors import FmuError, IdentificationError
from pipeline.in_order import solve
from pipeline.plant.model_exchange import ModelExchangePlant

TOLERANCE = 1e-9  # of max|tau|: round-off leaves about 1e-13, a wrong model structure far more
POINTS = 50
SINGULAR = "the mass matrix is singular somewhere on the data: check the a-priori values"
TORQUE_STEP = 0.1  # of the input's range: large against round-off, inside every saturation


class InverseModel:
    """The probed inverse model of a plant, called as `D, y0 = model(q, qd, qdd)`.

    `names` (p,) are the parameters it is linear in; `held` maps the others to the reason; those stay at their
    a-priori values within y0. Build it with `probe`.
    """

    def __init__(self, plant: ModelExchangePlant, held: dict[str, str] | None = None):
        self._plant = plant
        self._chi0 = plant.binding.a_priori
        self._delta = np.maximum(np.abs(self._chi0), plant.binding.scale)
        self._step = TORQUE_STEP * plant.binding.u_range
        self.held = held or {}
        self._active = [i for i, name in enumerate(plant.binding.names) if name not in self.held]
        self.names = tuple(plant.binding.names[i] for i in self._active)
        self._with_mass = self._active

    def __call__(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """D (N, n, p) and y0 (N, n) such that tau = D chi + y0, at q, qd, qdd (N, n).

        Raises FmuError where an evaluation fails, IdentificationError where the mass matrix is singular.
        """
        own = [True, *(i in self._with_mass for i in self._active)]
        T = self._by_parameter(self._torques(q, qd, qdd, self._sets(self._active), own), self._active)
        return T[..., :-1], T[..., -1]

    def mass(self, q: np.ndarray) -> np.ndarray:
        """M (N, n, n, p + 1), the mass matrix at q (N, n) per unit of each parameter; the last column is what is left.

        [D y0] = M qdd + rest(q, qd, M): D needs no further call of the FMU when only qdd changes.
        """
        still = np.zeros_like(q)
        masses = [_inverse(self._response(q, still, chi)[1]) for chi in self._sets(self._with_mass)]
        return self._by_parameter(masses, self._with_mass)

    def _leave_friction_out_of_mass(self, q: np.ndarray) -> None:
        """Take it that parameters that make no difference to the mass matrix at q (N, n) make none anywhere."""
        size = np.abs(self.mass(q)[..., :-1] * self._delta[self._active]).max(axis=(0, 1, 2))
        self._with_mass = [i for i, s in zip(self._active, size, strict=True) if s > TOLERANCE * size.max(initial=0.0)]

    def rest(self, q: np.ndarray, qd: np.ndarray, mass: np.ndarray) -> np.ndarray:
        """h (N, n, p + 1), the torque without acceleration per unit of each parameter, given mass = self.mass(q)."""
        still = np.zeros(q.shape[1])

        def torque(chi: np.ndarray) -> np.ndarray:
            M = mass @ np.append(chi[self._active], 1.0)
            return -np.einsum("gij,gj->gi", M, self._plant.accelerations(q, qd, still, chi))

        return self._by_parameter([torque(chi) for chi in self._sets(self._active)], self._active)

    def torque(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, chi: np.ndarray) -> np.ndarray:
        """tau (N, n) that gives the accelerations qdd (N, n) at q, qd (N, n) with parameters chi (p of the plant,)."""
        free, J = self._response(q, qd, chi)
        return np.einsum("gij,gj->gi", _inverse(J), qdd - free)  # not `solve`: its last bits are in the stored designs

    def _sets(self, among: list[int]) -> list[np.ndarray]:
        """The a-priori values, then the same with one of the parameters `among` moved by its delta."""
        sets = [self._chi0.copy() for _ in range(1 + len(among))]
        for chi, i in zip(sets[1:], among, strict=True):
            chi[i] += self._delta[i]
        return sets

    def _by_parameter(self, values: Sequence[np.ndarray], among: list[int]) -> np.ndarray:
        """What is linear in the active parameters, as (…, p + 1): its columns, and what chi = 0 leaves.

        values: at the sets of parameters `_sets(among)`; it depends on no others than those.
        """
        base = values[0]
        columns = np.zeros((*base.shape, len(self._active) + 1))
        for i, value in zip(among, values[1:], strict=True):
            columns[..., self._active.index(i)] = (value - base) / self._delta[i]
        columns[..., -1] = base - columns[..., :-1] @ self._chi0[self._active]
        return columns

    def _torques(self, q, qd, qdd, sets: list[np.ndarray], own: list[bool]) -> np.ndarray:
        """tau (sets, N, n) for every set of parameters; one without a mass of its own has that of the first."""
        try:
            if self._plant.compiled:
                return self._plant.torques(q, qd, qdd, np.array(sets), np.array(own), self._step)
            return np.array(list(self._torques_in_python(q, qd, qdd, sets, own)))
        except np.linalg.LinAlgError:
            raise IdentificationError(SINGULAR) from None

    def _torques_in_python(self, q, qd, qdd, sets: list[np.ndarray], own: list[bool]) -> Iterator[np.ndarray]:
        """What `plant.torques` computes: the same operations in the same order."""
        first = None
        for chi, mass in zip(sets, own, strict=True):
            free, J = self._response(q, qd, chi) if mass else (self._free(q, qd, chi), first)
            first = J if first is None else first
            yield solve(J, qdd - free)

    def mass_is_positive(self, q: np.ndarray, qd: np.ndarray, theta: np.ndarray) -> bool:
        """Whether the mass matrix is positive definite at q, qd (N, n) with the probed parameters theta (p,).

        If it is not, theta is no robot: most often the sign of the force, or of a position, is wrong in the data.
        """
        chi = self._chi0.copy()
        chi[self._active] = theta
        try:
            _, J = self._response(q, qd, chi)
        except FmuError:  # a mass matrix without an inverse gives no acceleration
            return False
        return bool(np.linalg.eigvalsh(J + J.transpose(0, 2, 1)).min() > 0.0)

    def _response(self, q: np.ndarray, qd: np.ndarray, chi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """qdd (N, n) without a force, and J (N, n, n) = ∂qdd/∂tau, the inverse of the mass matrix."""
        step, force = self._step, self._plant.binding.gain * self._step
        free = self._free(q, qd, chi)
        J = np.empty((*q.shape, q.shape[1]))
        for j in range(q.shape[1]):
            u = np.zeros_like(step)
            u[j] = step[j]
            J[:, :, j] = (self._plant.accelerations(q, qd, u, chi) - free) / force[j]
        return free, J

    def _free(self, q: np.ndarray, qd: np.ndarray, chi: np.ndarray) -> np.ndarray:
        return self._plant.accelerations(q, qd, np.zeros_like(self._step), chi)


def _inverse(J: np.ndarray) -> np.ndarray:
    """The mass matrix (N, n, n) of J (N, n, n)."""
    try:
        return np.linalg.inv(J)
    except np.linalg.LinAlgError:
        raise IdentificationError(SINGULAR) from None


def probe(plant: ModelExchangePlant, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, seed: int = 0) -> InverseModel:
    """The inverse model of a plant, its structure tested at points drawn from q, qd, qdd (N, n).

    A parameter that is not linear by itself is held at its a-priori value and named. Raises IdentificationError
    where qdd is not affine in the input, or where only the set is not linear.
    """
    rng = np.random.default_rng(seed)
    rows = rng.choice(len(q), size=min(POINTS, len(q)), replace=False)
    point = (q[rows], qd[rows], qdd[rows])
    _check_affine(plant, *point[:2])
    model = InverseModel(plant)
    held = {
        name: "the inverse model is not linear in it; held at its a-priori value"
        for i, name in enumerate(model.names)
        if not _nonlinearity(model, point, np.eye(len(model.names))[i] * rng.uniform(0.3, 0.9)) <= TOLERANCE
    }
    model = InverseModel(plant, held)
    model._leave_friction_out_of_mass(point[0])
    defect = _nonlinearity(model, point, rng.uniform(0.1, 0.9, len(model.names)))
    if not defect <= TOLERANCE:  # NaN is no pass
        raise IdentificationError(
            f"{plant.file.path.name}: the inverse model is not linear in its parameters together (defect {defect:.1e} "
            f"of max|tau|, allowed {TOLERANCE:.0e}): WLS does not apply; use the filter, or a plant in base parameters"
        )
    return model


def _nonlinearity(model: InverseModel, point: tuple, relative: np.ndarray) -> float:
    """|tau(chi0 + Δ) − tau(chi0) − D Δ| / max|tau| for Δ = relative·δ over the active parameters."""
    chi0, active = model._chi0, model._active
    change = relative * model._delta[active]
    chi = chi0.copy()
    chi[active] += change
    D, _ = model(*point)
    base, moved = model.torque(*point, chi0), model.torque(*point, chi)
    return float(np.max(np.abs(moved - base - D @ change)) / max(np.max(np.abs(moved)), np.max(np.abs(base))))


def _check_affine(plant: ModelExchangePlant, q: np.ndarray, qd: np.ndarray) -> None:
    """Refuse a plant whose qdd is not affine in u, seen at two amplitudes."""
    chi, step = plant.binding.a_priori, TORQUE_STEP * plant.binding.u_range
    free, once, twice = (plant.accelerations(q, qd, k * step, chi) for k in (0.0, 1.0, 2.0))
    defect = np.max(np.abs(twice - 2.0 * once + free)) / np.max(np.abs(twice - free))
    if not defect <= TOLERANCE:
        raise IdentificationError(
            f"{plant.file.path.name}: the acceleration is not affine in the input (defect {defect:.1e}, allowed "
            f"{TOLERANCE:.0e}); lower u_range in the binding below every saturation, or use the filter only"
        )
