"""The extended Kalman filter of the augmented state z = [qd, q, h, chi], its transition computed by the plant FMU.

(Gautier & Poignet 2001, section 3.) The Jacobian comes from the FMU's directional derivatives or from differences
through the plant; the covariance is kept in the Joseph form or as UDUᵀ.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.errors import FmuError, IdentificationError
from pipeline.identify.covariance_forms import FORMS, P_LOST
from pipeline.identify.jacobian import linearise
from pipeline.in_order import normalised
from pipeline.records import FilterRun

MASS_LOST = "the mass matrix lost positive definiteness: the parameters left what is physical"
NOT_A_NUMBER = "the estimate or its covariance is not finite"


@dataclass(frozen=True)
class Tuning:
    """The noise the filter assumes: R (n,) variances of the measured position, and the process noise G diag(q) Gᵀ.

    `input_noise` True: G = ∂s⁺/∂tau and q (n,) are variances of the joint force; False: G is the identity on the
    plant's states and q (ns,) their variances a step, as in the paper.
    """

    R: np.ndarray
    q: np.ndarray
    input_noise: bool


def run_filter(
    plant,
    time: np.ndarray,
    q: np.ndarray,
    u: np.ndarray,
    z0: np.ndarray,
    P0: np.ndarray,
    tuning: Tuning,
    jacobian: str = "forward",
    covariance: str = "udu",
) -> FilterRun:
    """Filter the measured positions q (N, n) with the inputs u (N, n) held from time[k] to time[k+1] (N,) s.

    z0 (nx,) and P0 (nx, nx) are the prior of z = [qd, q, h, chi]. covariance: "udu", "joseph", or (in Python only)
    "filterpy". A compiled plant is filtered by the compiled filter. Where the plant or the covariance fails, the run
    ends before that sample and says so in `failed_at` and `reason`; nothing is raised.
    """
    if plant.compiled:
        from pipeline.identify.ekf_compiled import run_compiled  # numba is slow to import

        return run_compiled(plant, time, q, u, z0, P0, tuning, jacobian, covariance)
    n, ns = plant.n, plant.ns
    H = np.zeros((n, len(z0)))
    H[:, n : 2 * n] = np.eye(n)
    samples = len(time)
    x, P_diag = np.empty((samples, len(z0))), np.empty((samples, len(z0)))
    innovation, S_diag, NIS = np.empty((samples, n)), np.empty((samples, n)), np.empty(samples)
    failed_at, reason, done, P = None, "", 0, P0
    try:
        form = FORMS[covariance](z0, P0, H, tuning.R)
        for k in range(samples):
            if k:
                _predict(form, plant, ns, u[k - 1], time[k - 1], time[k] - time[k - 1], tuning, jacobian)
            innovation[k], S = form.update(q[k])
            x[k], P_diag[k], S_diag[k] = form.x, form.P_diag, np.diag(S)
            if (found := normalised(innovation[k], S)) is None:
                raise IdentificationError(P_LOST)
            NIS[k] = found
            if not np.isfinite(NIS[k] + x[k].sum() + P_diag[k].sum()):
                raise IdentificationError(NOT_A_NUMBER)
            done, P = k + 1, form.P if k == samples - 1 else P
    except (FmuError, IdentificationError, np.linalg.LinAlgError) as error:
        failed_at, reason = done, str(error)
    return FilterRun(
        time[:done], x[:done], P_diag[:done], innovation[:done], S_diag[:done], NIS[:done], P, failed_at, reason
    )


def _predict(form, plant, ns: int, u: np.ndarray, t: float, dt: float, tuning: Tuning, jacobian: str) -> None:
    s, chi = form.x[:ns], form.x[ns:]
    model = linearise(plant, s, chi, u, t, dt, jacobian)
    G_tau = model.C / plant.binding.gain
    _watch_mass_matrix(G_tau[: plant.n])
    G = G_tau if tuning.input_noise else np.eye(ns)
    form.predict(np.concatenate([model.f, chi]), np.hstack([model.A, model.B]), G, tuning.q)


def _watch_mass_matrix(response: np.ndarray) -> None:
    """Refuse parameters with which a force does not push its own way: ∂qd⁺/∂tau (n, n) ≈ M⁻¹ dt must be positive.

    The FMU rejects no parameter that a filter may ask for, so this is watched here.
    """
    if np.linalg.eigvalsh(response + response.T)[0] <= 0:
        raise IdentificationError(MASS_LOST)
