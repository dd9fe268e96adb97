"""Plants and controllers once more, without any Modelica: Lagrange by sympy, recursions in NumPy, SciPy's Radau."""

from functools import cache
from math import tanh

import numpy as np
import sympy
from scipy.integrate import solve_ivp

SCARA = dict(ZZR1=3.42, Fv1=0.07, Fs1=0.58, ZZ2=0.064, LMX2=0.131, LMY2=0.0, Fv2=0.015, Fs2=0.156, eps=0.01)
EMPS = dict(M=95.0, Fv=200.0, Fc=20.0, offset=-3.0, eps=1e-3, G=35.0)


@cache
def _two_links():
    """M (2, 2) and h (2,) with M qdd + h = tau, from the kinetic energy of two planar links.

    Link 1: inertia J1 about its joint, length L. Link 2: mass m, centre of mass at (x, y) in its own frame, inertia
    I about it. Base parameters: ZZR1 = J1 + m L², ZZ2 = I + m (x² + y²), LMX2 = L m x, LMY2 = L m y.
    """
    t = sympy.Symbol("t")
    J1, L, m, x, y, I2 = sympy.symbols("J1 L m x y I2")
    q = [sympy.Function(f"q{i}")(t) for i in (1, 2)]
    angle = q[0] + q[1]
    centre = sympy.Matrix(
        [
            L * sympy.cos(q[0]) + x * sympy.cos(angle) - y * sympy.sin(angle),
            L * sympy.sin(q[0]) + x * sympy.sin(angle) + y * sympy.cos(angle),
        ]
    )
    v = centre.diff(t)
    T = (J1 * q[0].diff(t) ** 2 + m * v.dot(v) + I2 * angle.diff(t) ** 2) / 2
    lhs = sympy.Matrix([T.diff(qi.diff(t)).diff(t) - T.diff(qi) for qi in q]).expand()
    Q, V, A = (sympy.symbols(f"{s}1:3") for s in ("p", "v", "a"))
    for qi, Qi, Vi, Ai in zip(q, Q, V, A, strict=True):
        lhs = lhs.subs(qi.diff(t, 2), Ai).subs(qi.diff(t), Vi).subs(qi, Qi)
    M = lhs.jacobian(A)
    h = lhs.subs({a: 0 for a in A})
    return sympy.lambdify((Q, V, (J1, L, m, x, y, I2)), (M[0, 0], M[0, 1], M[1, 1], h[0], h[1]), "math", cse=True)


def links(p, L=0.5, m=1.7):
    """Physical links that have the base parameters p, whatever length and mass they have."""
    x, y = p["LMX2"] / (L * m), p["LMY2"] / (L * m)
    return p["ZZR1"] - m * L * L, L, m, x, y, p["ZZ2"] - m * (x * x + y * y)


def scara_rhs(p):
    """f(x, tau) -> derivatives of x = [q_1, q_2, qd_1, qd_2]."""
    terms, body = _two_links(), links(p)

    def f(x, tau):
        q, v = x[:2], x[2:]
        m11, m12, m22, h1, h2 = terms(q, v, body)
        r1 = tau[0] - h1 - p["Fv1"] * v[0] - p["Fs1"] * tanh(v[0] / p["eps"])
        r2 = tau[1] - h2 - p["Fv2"] * v[1] - p["Fs2"] * tanh(v[1] / p["eps"])
        det = m11 * m22 - m12 * m12
        return [v[0], v[1], (m22 * r1 - m12 * r2) / det, (m11 * r2 - m12 * r1) / det]

    return f


def emps_rhs(p):
    """f(x, u) -> derivatives of x = [q, qd]."""

    def f(x, u):
        force = p["G"] * u[0] - p["Fv"] * x[1] - p["Fc"] * tanh(x[1] / p["eps"]) - p["offset"]
        return [x[1], force / p["M"]]

    return f


def held(f, x, u, h):
    """The state after h seconds under a held input: Radau at 1e-10."""
    run = solve_ivp(lambda _, x: f(x, u), (0.0, h), x, method="Radau", rtol=1e-10, atol=1e-10)
    assert run.success
    return run.y[:, -1]


def march(f, x, inputs, h):
    """States (N+1, n) under the held inputs (N, m)."""
    states = [np.asarray(x, dtype=float)]
    for u in inputs:
        states.append(held(f, states[-1], u, h))
    return np.array(states)


def runge_kutta(f, x, inputs, h, n):
    """States (N+1, n) under the held inputs (N, m) by the classical fourth-order method, n steps in h seconds."""
    states, step = [np.asarray(x, dtype=float)], h / n
    for u in inputs:
        x = states[-1]
        for _ in range(n):
            k1 = np.array(f(x, u))
            k2 = np.array(f(x + step / 2 * k1, u))
            k3 = np.array(f(x + step / 2 * k2, u))
            k4 = np.array(f(x + step * k3, u))
            x = x + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        states.append(x)
    return np.array(states)


class SampledPD:
    """tau = sat(Kp (qr − q) + Kd (qdr − v)), v the backward Euler derivative; both joints at once."""

    def __init__(self, q_start=(0, 0), v_start=(0, 0), Kp=(250, 8), Kd=(45, 0.9), Tf=0.02, tau_max=(40, 6), Ts=0.01):
        self.q, self.v = np.array(q_start, float), np.array(v_start, float)
        self.Kp, self.Kd, self.tau_max = (np.array(a, float) for a in (Kp, Kd, tau_max))
        self.Tf, self.Ts = Tf, Ts

    def tick(self, qr, qdr, q):
        self.v = (self.Tf * self.v + (q - self.q)) / (self.Tf + self.Ts)
        self.q = np.array(q, float)
        return np.clip(self.Kp * (qr - q) + self.Kd * (qdr - self.v), -self.tau_max, self.tau_max)


class TwoLoop:
    """u = sat(kp kv (qr − q) − kv qd + pulse), qd = (q(k) − q(k−2))/(2 Ts): the difference of two-point means."""

    def __init__(self, q_start=0.0, qd_start=0.0, kp=160.18, kv=243.45, u_max=10.0, Ts=1e-3):
        self.past = [q_start - 2 * Ts * qd_start, q_start - Ts * qd_start]
        self.kp, self.kv, self.u_max, self.Ts = kp, kv, u_max, Ts

    def tick(self, qr, pulse, q):
        velocity = (q - self.past[0]) / (2 * self.Ts)
        self.past = [self.past[1], q]
        return float(np.clip(self.kp * self.kv * (qr - q) - self.kv * velocity + pulse, -self.u_max, self.u_max))
