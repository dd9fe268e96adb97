"""Forms of the Kalman filter's covariance with one face: Bierman–Thornton's UDUᵀ, Joseph's, and filterpy's."""

from __future__ import annotations

import numpy as np

from pipeline.errors import IdentificationError
from pipeline.identify import udu
from pipeline.in_order import product

P_LOST = 'the covariance P lost positive definiteness; check P0, Q and R (ekf.covariance = "udu" keeps it longest)'


class UduForm:
    """Estimate x (nx,) and covariance P = U diag(d) Uᵀ; measurements y = H x + v are taken one by one.

    H (n, nx), R (n,) variances of v, x0 (nx,), P0 (nx, nx).
    """

    def __init__(self, x0: np.ndarray, P0: np.ndarray, H: np.ndarray, R: np.ndarray):
        self.x, self.H, self.R = x0.copy(), H, R
        self.U, self.d = udu.factor(P0)

    def predict(self, x: np.ndarray, F: np.ndarray, G: np.ndarray, q: np.ndarray) -> None:
        """Take the predicted x (nx,); propagate P by F (ns, nx), the upper rows of [A B; 0 I], and G (ns, nq), q."""
        self.x = x
        self.U, self.d = udu.predict(self.U, self.d, F, G, q)

    def update(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Take the measurement y (n,); returns the innovation (n,) and its covariance S (n, n)."""
        innovation = y - self.H @ self.x
        HU = self.H @ self.U
        S = product(HU * self.d, HU.T) + np.diag(self.R)
        for h, r, yi in zip(self.H, self.R, y, strict=True):
            residual = yi - h @ self.x
            self.U, self.d, K = udu.update(self.U, self.d, h, r)
            self.x = self.x + K * residual
        return innovation, S

    @property
    def P(self) -> np.ndarray:
        """The covariance (nx, nx)."""
        return udu.covariance(self.U, self.d)

    @property
    def P_diag(self) -> np.ndarray:
        """Its diagonal (nx,)."""
        return udu.variances(self.U, self.d)


class JosephForm:
    """The same face, with P itself, updated in the Joseph form (I − K h) P (I − K h)ᵀ + K r Kᵀ."""

    def __init__(self, x0: np.ndarray, P0: np.ndarray, H: np.ndarray, R: np.ndarray):
        self.x, self.P, self.H, self.R = x0.copy(), P0.copy(), H, R

    def predict(self, x: np.ndarray, F: np.ndarray, G: np.ndarray, q: np.ndarray) -> None:
        """Take the predicted x (nx,); propagate P by F (ns, nx), the upper rows of [A B; 0 I], and G (ns, nq), q."""
        ns = len(F)
        self.x, T = x, product(F, self.P)
        self.P = self.P.copy()
        self.P[:ns, ns:], self.P[ns:, :ns] = T[:, ns:], T[:, ns:].T
        self.P[:ns, :ns] = _mirrored(product(np.hstack([T, G * q]), np.hstack([F, G]).T))

    def update(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Take the measurement y (n,); returns the innovation (n,) and its covariance S (n, n)."""
        innovation, S = y - self.H @ self.x, self.H @ self.P @ self.H.T + np.diag(self.R)
        for h, r, yi in zip(self.H, self.R, y, strict=True):
            Ph = self.P @ h
            K = Ph * (1.0 / (h @ Ph + r))
            self.x = self.x + K * (yi - h @ self.x)
            M = self.P - np.outer(K, Ph)
            self.P = _mirrored(M + np.outer(K * r - M @ h, K))
        if not np.all(np.diag(self.P) > 0):
            raise IdentificationError(P_LOST)
        return innovation, S

    @property
    def P_diag(self) -> np.ndarray:
        """Its diagonal (nx,)."""
        return np.diag(self.P)


def _mirrored(P: np.ndarray) -> np.ndarray:
    """P symmetric, as its lower triangle has it."""
    return np.tril(P) + np.tril(P, -1).T


class FilterpyForm:
    """The same face on filterpy's `ExtendedKalmanFilter`, which updates P in the Joseph form: a third opinion."""

    def __init__(self, x0: np.ndarray, P0: np.ndarray, H: np.ndarray, R: np.ndarray):
        from filterpy.kalman import ExtendedKalmanFilter  # slow to import, and needed by this form only

        self._filter = ExtendedKalmanFilter(dim_x=len(x0), dim_z=len(R))
        self._filter.x, self._filter.P, self._filter.R = x0.copy(), P0.copy(), np.diag(R)
        self._filter.predict_x = lambda u=0: None  # the FMU has predicted x already
        self._H = H

    def predict(self, x: np.ndarray, F: np.ndarray, G: np.ndarray, q: np.ndarray) -> None:
        """Take the predicted x (nx,); propagate P by F (ns, nx), the upper rows of [A B; 0 I], and G (ns, nq), q."""
        whole, Q = np.eye(len(x)), np.zeros((len(x), len(x)))
        whole[: len(F)], Q[: len(F), : len(F)] = F, (G * q) @ G.T
        self._filter.x, self._filter.F, self._filter.Q = x, whole, Q
        self._filter.predict()

    def update(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Take the measurement y (n,); returns the innovation (n,) and its covariance S (n, n)."""
        self._filter.update(y, lambda x: self._H, lambda x: self._H @ x)
        if not np.all(np.diag(self._filter.P) > 0):
            raise IdentificationError(P_LOST)
        return self._filter.y, self._filter.S

    @property
    def x(self) -> np.ndarray:
        """The estimate (nx,)."""
        return self._filter.x

    @property
    def P(self) -> np.ndarray:
        """The covariance (nx, nx)."""
        return self._filter.P

    @property
    def P_diag(self) -> np.ndarray:
        """Its diagonal (nx,)."""
        return np.diag(self._filter.P)


FORMS = {"udu": UduForm, "joseph": JosephForm, "filterpy": FilterpyForm}
