"""The planar chain by the recursion of Newton and Euler: the independent oracle of Plants.Chain.

It goes from link to link, through physical links that have the base parameters; the model solves Lagrange's equations
in the base parameters themselves.
"""

import numpy as np

LENGTH, GRAVITY, EPS = 0.5, 9.81, 0.1  # m, m/s², rad/s


def torques(q, qd, qdd, chi, gravity=GRAVITY, eps=EPS) -> np.ndarray:
    """tau (n,) that moves the chain: out along the links with the joints' accelerations, back with the forces.

    q, qd, qdd (n,) of the joints; chi: ZZ, MX, Fv, Fs (n,) each. Links of these base parameters, whatever their masses
    m[k], have J[i] = ZZ[i] - L² Σ m[k] and mX[i] = MX[i] - L Σ m[k], k > i.
    """
    n = len(q)
    m = np.linspace(1.5, 0.4, n)
    behind = np.append(np.cumsum(m[::-1])[::-1][1:], 0.0)
    J, mX = chi["ZZ"] - LENGTH**2 * behind, chi["MX"] - LENGTH * behind
    theta, omega, omegad = np.cumsum(q), np.cumsum(qd), np.cumsum(qdd)
    along, across = np.array([np.sin(theta), -np.cos(theta)]).T, np.array([np.cos(theta), np.sin(theta)]).T
    turn = across * omegad[:, None] - along * omega[:, None] ** 2  # acceleration of a point per its distance
    a = np.array([0.0, gravity])  # of the first joint: gravity as an acceleration upwards
    forces, moments = np.empty((n, 2)), np.empty(n)
    for i in range(n):
        forces[i] = m[i] * a + mX[i] * turn[i]
        moments[i] = J[i] * omegad[i] + mX[i] * across[i] @ a
        a = a + LENGTH * turn[i]
    tau, force, moment = np.empty(n), np.zeros(2), 0.0
    for i in reversed(range(n)):
        moment += moments[i] + LENGTH * across[i] @ force
        force = force + forces[i]
        tau[i] = moment
    return tau + chi["Fv"] * qd + chi["Fs"] * np.tanh(qd / eps)


def accelerations(q, qd, tau, chi, gravity=GRAVITY, eps=EPS) -> np.ndarray:
    """qdd (n,) under tau (n,): the torques are affine in it."""
    rest = torques(q, qd, np.zeros_like(q), chi, gravity, eps)
    columns = [torques(q, qd, e, chi, gravity, eps) - rest for e in np.eye(len(q))]
    return np.linalg.solve(np.array(columns).T, tau - rest)


def energy(q, qd, chi, gravity=GRAVITY) -> float:
    """Kinetic and potential energy, by the speed of the joints and the links' own inertia about them."""
    theta, omega = np.cumsum(q), np.cumsum(qd)
    pairs = LENGTH * chi["MX"][None, :] * np.cos(theta[None, :] - theta[:, None]) * np.outer(omega, omega)
    return chi["ZZ"] @ omega**2 / 2 + np.triu(pairs, 1).sum() - gravity * chi["MX"] @ np.cos(theta)
