"""The SCARA in the paper's closed form (Gautier & Poignet 2001, section 4): the independent oracle of the tests.

Derived again from Lagrange: the last factor of row 1's LMY2 term is C2 (the paper prints S2), and row 2 has two
leading zeros and one more than printed. No other plant has a formula in this project.
"""

import numpy as np

NAMES = ("ZZR1", "Fv1", "Fs1", "ZZ2", "LMX2", "LMY2", "Fv2", "Fs2")
UNITS = ("kg.m2", "N.m.s/rad", "N.m", "kg.m2", "kg.m2", "kg.m2", "N.m.s/rad", "N.m")
TRUTH = np.array([3.42, 0.07, 0.58, 0.064, 0.131, 0.0, 0.015, 0.156])


def friction_sign(qd, eps):
    """sgn qd, or its smooth form tanh(qd/eps) where eps > 0 [rad/s]."""
    return np.tanh(qd / eps) if eps > 0 else np.sign(qd)


def regressor(q, qd, qdd, eps=0.0):
    """D (N, 2, 8) with tau = D chi, from q, qd, qdd (N, 2) in rad, rad/s, rad/s²."""
    (qd1, qd2), (qdd1, qdd2) = qd.T, qdd.T
    C2, S2 = np.cos(q[:, 1]), np.sin(q[:, 1])
    s1, s2 = friction_sign(qd, eps).T
    zero = np.zeros_like(qd1)
    row1 = [
        qdd1,
        qd1,
        s1,
        qdd1 + qdd2,
        (2 * qdd1 + qdd2) * C2 - qd2 * (2 * qd1 + qd2) * S2,
        -(2 * qdd1 + qdd2) * S2 - qd2 * (2 * qd1 + qd2) * C2,
        zero,
        zero,
    ]
    row2 = [zero, zero, zero, qdd1 + qdd2, qdd1 * C2 + qd1**2 * S2, qd1**2 * C2 - qdd1 * S2, qd2, s2]
    return np.stack([np.stack(row1, axis=1), np.stack(row2, axis=1)], axis=1)


def inverse_model(q, qd, qdd):
    """The seam's regressor in closed form, sign friction: (D (N, 2, 8), y0 (N, 2) = 0)."""
    return regressor(q, qd, qdd), np.zeros_like(q)


class Affine:
    """The inverse model in parts: [D y0] (N, 2, 9) = mass(q) qdd + rest(q, qd, mass(q)); smooth friction if eps > 0."""

    def __init__(self, eps=0.0):
        self.eps = eps

    def mass(self, q):
        zero = np.zeros_like(q)
        M = np.zeros((len(q), 2, 2, 9))
        for j in range(2):
            M[:, :, j, :8] = regressor(q, zero, zero + np.eye(2)[j]) - regressor(q, zero, zero)
        return M

    def rest(self, q, qd, mass):
        return np.pad(regressor(q, qd, np.zeros_like(q), self.eps), ((0, 0), (0, 0), (0, 1)))


def acceleration(q, qd, tau, chi=TRUTH, eps=0.01):
    """Direct model qdd = M⁻¹(tau − N), two arrays (…) per argument in a list or array of length 2."""
    ZZR1, Fv1, Fs1, ZZ2, LMX2, LMY2, Fv2, Fs2 = chi
    C2, S2 = np.cos(q[1]), np.sin(q[1])
    qd1, qd2 = qd
    a, b = LMX2 * C2 - LMY2 * S2, LMX2 * S2 + LMY2 * C2
    M11, M12, M22 = ZZR1 + ZZ2 + 2 * a, ZZ2 + a, ZZ2
    s1, s2 = friction_sign(np.asarray(qd), eps)
    n1 = tau[0] - Fv1 * qd1 - Fs1 * s1 + b * qd2 * (qd2 + 2 * qd1)
    n2 = tau[1] - Fv2 * qd2 - Fs2 * s2 - b * qd1 * qd1
    det = M11 * M22 - M12 * M12
    return np.stack([(M22 * n1 - M12 * n2) / det, (M11 * n2 - M12 * n1) / det])
